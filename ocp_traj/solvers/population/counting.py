"""The problem counts its own evaluations: no solver, ours or somebody else's, gets more than was allowed."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from metaheuristics import Evaluation, Problem, Solution, Status
from metaheuristics.recorder import Recorder
from ocp_traj.arrays import Array
from ocp_traj.transcription.condensed.condensed import CondensedNlp

HISTORY_STEP = 50
"""Evaluations between two entries of the history of a solver that asks for one candidate at a time."""


class BudgetSpent(Exception):
    """Ends somebody else's loop from inside: the budget, the time, or the caller's patience is used up.

    Attributes
    ----------
    status : Status
    """

    def __init__(self, status: Status, message: str) -> None:
        super().__init__(message)
        self.status = status


@dataclass(frozen=True)
class Seen:
    """What a progress callback is shown.

    Attributes
    ----------
    evaluations : int
    cost, violation : float
        Of the best candidate so far.
    seconds : float
    """

    evaluations: int
    cost: float
    violation: float
    seconds: float


class Counted(Problem):
    """A condensed problem that counts, stops at its budget, and remembers the best distinct motions.

    Parameters
    ----------
    nlp : CondensedNlp
    budget : int, optional
        Candidates that may be evaluated; a batch beyond it is cut, and `BudgetSpent` raised.
    seconds : float, optional
        Wall time, looked at before every batch.
    progress : callable, optional
        Called with `Seen` now and then; true stops by `BudgetSpent`.
    keep : int
        Number of distinct motions to remember.
    """

    def __init__(
        self,
        nlp: CondensedNlp,
        budget: int | None = None,
        seconds: float | None = None,
        progress: Any = None,
        keep: int = 0,
    ) -> None:
        super().__init__(nlp.name, nlp.lower, nlp.upper)
        self.nlp, self.budget, self.seconds, self.progress = nlp, budget, seconds, progress
        self.archive = Archive(nlp, keep)
        self.recorder = Recorder(np.array(nlp.guess))
        self.begin = time.perf_counter()
        self._recorded = 0

    @property
    def evaluations(self) -> int:
        """Candidates evaluated so far."""
        return self.recorder.evaluations

    def evaluate(self, X: Array) -> Evaluation:
        """Judge a batch (p, d); see `metaheuristics.Problem.evaluate`.

        Raises
        ------
        BudgetSpent
            The batch was cut, or nothing may be evaluated any more.
        """
        self._check_time()
        left = len(X) if self.budget is None else self.budget - self.evaluations
        evaluation = self.nlp.evaluate(X[:left]) if left > 0 else None
        if evaluation is not None:
            self.recorder.update(X[:left], evaluation)
            self.archive.add(X[:left], evaluation)
            if len(X) > 1 or self.evaluations - self._recorded >= HISTORY_STEP:
                self._record()
        if evaluation is None or left < len(X):
            raise BudgetSpent(Status.BUDGET_EXHAUSTED, f"Used the {self.budget} evaluations allowed.")
        return evaluation

    def _check_time(self) -> None:
        if self.seconds is not None and time.perf_counter() - self.begin >= self.seconds:
            raise BudgetSpent(Status.TIME_EXHAUSTED, f"Used the {self.seconds:g} s allowed.")

    def _record(self) -> None:
        seconds = time.perf_counter() - self.begin
        self.recorder.close_generation(seconds, float("nan"))
        self._recorded = self.evaluations
        seen = Seen(self.evaluations, self.recorder.cost, self.recorder.violation, seconds)
        if self.progress is not None and self.progress(seen):
            raise BudgetSpent(Status.BUDGET_EXHAUSTED, "Stopped by the callback.")

    def make_solution(self, status: Status, message: str, build_time: float) -> Solution:
        """Return the best candidate seen, whatever the solver itself called its answer."""
        recorder = self.recorder
        if self.evaluations > self._recorded:
            recorder.close_generation(time.perf_counter() - self.begin, float("nan"))
        if not np.isfinite(recorder.cost):
            status, message = Status.FAILED, f"No candidate had finite values. {message}"
        elif recorder.violation > 0.0:
            status = Status.INFEASIBLE
            message = f"The least total violation found is {recorder.violation:.3g}. {message}"
        return Solution(
            self.nlp,
            recorder.x,
            recorder.cost,
            recorder.rows,
            status,
            message,
            recorder.evaluations,
            build_time,
            time.perf_counter() - self.begin,
            recorder.make_history(),
        )


class Archive:
    """The best distinct motions seen: least violation first, then least cost.

    Two candidates are the same motion when they are less than `DISTANCE` apart, in the sense of their encoding.

    Parameters
    ----------
    nlp : CondensedNlp
    size : int
    """

    DISTANCE = 0.03
    LOOKED_AT = 8

    def __init__(self, nlp: CondensedNlp, size: int) -> None:
        self.nlp, self.size = nlp, size
        self.entries: list[tuple[float, float, Array]] = []

    def add(self, X: Array, evaluation: Evaluation) -> None:
        """Look at the best few of a batch."""
        if not self.size:
            return
        cost, violation = evaluation.scores
        for index in np.lexsort((cost, violation))[: self.LOOKED_AT]:
            entry = (float(violation[index]), float(cost[index]), np.array(X[index]))
            if len(self.entries) == self.size and entry[:2] >= self.entries[-1][:2]:
                return
            self._insert(entry)

    def _insert(self, entry: tuple[float, float, Array]) -> None:
        near = [old for old in self.entries if self.nlp.encoding.distance(old[2], entry[2]) < self.DISTANCE]
        if any(old[:2] <= entry[:2] for old in near):
            return
        kept = [old for old in self.entries if not any(old is other for other in near)]
        self.entries = sorted([*kept, entry], key=lambda old: old[:2])[: self.size]
