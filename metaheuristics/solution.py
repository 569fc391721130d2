"""What every solver gives back."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any

import numpy as np
import numpy.typing as npt

from metaheuristics.arrays import FloatArray, IntArray
from metaheuristics.problem import Problem


class Status(Enum):
    """Why a solver ended; the value is a sentence for people, `key` is the word for files."""

    CONVERGED = "The solver met its own optimality criterion or the target value."
    BUDGET_EXHAUSTED = "The evaluations or generations allowed are used up."
    TIME_EXHAUSTED = "The time allowed is used up."
    STALLED = "The best value stopped improving."
    INFEASIBLE = "No candidate that keeps every constraint was found."
    FAILED = "No candidate could be evaluated to finite numbers, or the solver broke down."

    @property
    def key(self) -> str:
        """Lower-case word for files and tables, such as ``budget_exhausted``."""
        return self.name.lower()


@dataclass(frozen=True, eq=False, kw_only=True)
class History:
    """The course of a run, one entry a generation (N entries).

    Parameters
    ----------
    evaluations
        (N,) evaluations spent so far.
    cost, violation
        (N,) cost and total violation of the best candidate so far.
    seconds
        (N,) wall time since the start, s.
    x
        (N, d) the best candidate so far.
    spread
        (N,) standard deviation of the population relative to the width of the box, mean over the coordinates
        (0.289 for a uniform one, 0 when all agree); NaN where a solver has no population.
    """

    evaluations: IntArray
    cost: FloatArray
    violation: FloatArray
    seconds: FloatArray
    x: FloatArray
    spread: FloatArray

    @classmethod
    def of(
        cls,
        cost: npt.ArrayLike,
        *,
        evaluations: npt.ArrayLike,
        dimension: int,
        violation: npt.ArrayLike | None = None,
        seconds: npt.ArrayLike | None = None,
        x: npt.ArrayLike | None = None,
        spread: npt.ArrayLike | None = None,
    ) -> History:
        """Return a history of what is known of a run; a column that is not given is NaN, of violations 0.

        Parameters
        ----------
        cost, evaluations, violation, seconds, x, spread
            The columns; see the class.
        dimension
            Number of variables d.
        """
        costs = np.asarray(cost, dtype=np.float64)
        unknown = np.full(costs.shape[0], np.nan)
        return cls(
            evaluations=np.asarray(evaluations, dtype=np.intp),
            cost=costs,
            violation=np.zeros(costs.shape[0]) if violation is None else np.asarray(violation),
            seconds=unknown if seconds is None else np.asarray(seconds),
            x=np.full((costs.shape[0], dimension), np.nan) if x is None else np.asarray(x),
            spread=unknown if spread is None else np.asarray(spread),
        )

    @classmethod
    def empty(cls, dimension: int = 0) -> History:
        """Return a history of no entries, for solvers that report none."""
        return cls.of((), evaluations=(), dimension=dimension)

    def __len__(self) -> int:
        """Return the number of entries."""
        return int(self.cost.shape[0])

    def generations_to_within(self, fraction: float = 1e-3) -> int:
        """Return after how many generations the best is feasible, if ever, and close to the final best.

        Parameters
        ----------
        fraction
            Allowed distance relative to the magnitude of the final best cost.

        Returns
        -------
        int
            Number of the generation, 0 for the initial population; 0 for an empty history.
        """
        if not len(self):
            return 0
        final = self.cost[-1]
        close = (self.cost <= final + fraction * abs(final)) & (self.violation <= self.violation[-1])
        return int(np.argmax(close))


@dataclass(frozen=True, eq=False, kw_only=True)
class Solution:
    """The answer of one run, with the way it was found.

    Parameters
    ----------
    problem
        The problem that was solved.
    x
        (d,) the best candidate: least total violation first, then least cost.
    cost
        Its cost.
    violation
        (m,) its violation, row by row; no rows by default.
    status, message
        Why the solver ended, as a word and as its own sentence.
    evaluations
        Candidates evaluated.
    build_time, solve_time
        Seconds spent before and in the search.
    history
        The course of the run; empty by default.
    """

    problem: Problem
    x: FloatArray
    cost: float
    violation: FloatArray = field(default_factory=lambda: np.empty(0))
    status: Status
    message: str = ""
    evaluations: int = 0
    build_time: float = 0.0
    solve_time: float = 0.0
    history: History = field(default_factory=History.empty)

    def __post_init__(self) -> None:
        if not len(self.history):
            object.__setattr__(self, "history", History.empty(self.x.shape[0]))

    @classmethod
    def failed(cls, problem: Problem, message: str, *, status: Status = Status.FAILED, **known: Any) -> Solution:
        """Return the answer of a solver that has none: x is NaN and its cost infinite.

        Parameters
        ----------
        problem, message, status
            See the class.
        **known
            Other fields, for instance the evaluations and seconds spent.
        """
        nothing = {"x": np.full(problem.dimension, np.nan), "cost": math.inf, "violation": np.array([math.inf])}
        return cls(problem=problem, status=status, message=message, **{**nothing, **known})

    @property
    def seconds(self) -> float:
        """Seconds spent in all."""
        return self.build_time + self.solve_time

    def paying_for(self, searches: Sequence[Solution], **changes: Any) -> Solution:
        """Return this answer with the evaluations and seconds of several searches, and other fields changed.

        Parameters
        ----------
        searches
            This answer's own among them.
        **changes
            Other fields.
        """
        return replace(
            self,
            evaluations=sum(search.evaluations for search in searches),
            build_time=sum(search.build_time for search in searches),
            solve_time=sum(search.solve_time for search in searches),
            **changes,
        )

    @property
    def total_violation(self) -> float:
        """Sum of the violation over its rows; 0 for a feasible answer."""
        return float(self.violation.sum())

    @property
    def feasible(self) -> bool:
        """Whether there is an answer that keeps every constraint row, by the problem's own account."""
        return math.isfinite(self.cost) and self.total_violation == 0.0
