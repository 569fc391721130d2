"""What every solver gives back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

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


@dataclass(frozen=True, eq=False)
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
    def empty(cls, dimension: int) -> History:
        """Return a history of no entries, for solvers that report none."""
        none = np.empty(0)
        return cls(np.empty(0, dtype=np.intp), none, none, none, np.empty((0, dimension)), none)

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


@dataclass(frozen=True, eq=False)
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
        (m,) its violation, row by row.
    status, message
        Why the solver ended, as a word and as its own sentence.
    evaluations
        Candidates evaluated.
    build_time, solve_time
        Seconds spent before and in the search.
    history
        The course of the run.
    """

    problem: Problem
    x: FloatArray
    cost: float
    violation: FloatArray
    status: Status
    message: str
    evaluations: int
    build_time: float
    solve_time: float
    history: History

    @property
    def total_violation(self) -> float:
        """Sum of the violation over its rows; 0 for a feasible answer."""
        return float(self.violation.sum())

    @property
    def feasible(self) -> bool:
        """Whether there is an answer that keeps every constraint row, by the problem's own account."""
        return math.isfinite(self.cost) and self.total_violation == 0.0
