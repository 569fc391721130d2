"""A population method looks around, a gradient solver finishes: from the best few distinct motions found."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from ocp_traj.exceptions import InputError
from ocp_traj.solvers.gradient.gradient import Gradient
from ocp_traj.solvers.outcomes import join_outcomes, run_from_each
from ocp_traj.solvers.population.counting import Counted
from ocp_traj.solvers.population.explaining import explained
from ocp_traj.solvers.population.population import Population
from ocp_traj.solvers.solver import DEFAULT_BUDGET, Outcome, Request, Solver
from ocp_traj.task import TrajectoryTask

DEFAULT_FRACTION = 0.2
"""Fraction of a population method's default budget that a hybrid takes when the request names none."""


@dataclass(frozen=True)
class Hybrid(Solver):
    """A population method on the condensed form, then a gradient solver.

    Parameters
    ----------
    population : Population
        The first solver; by default on the scaled encoding, where every candidate is feasible.
    gradient : Gradient
        The second solver.
    starts : int
        Number of distinct motions the gradient solver starts from; it stops early when the budget is used up.
    share : float
        Share of the budget that goes to the population method; 0.1 of the default budget when none is given.
    """

    kind: ClassVar[str] = "hybrid"

    population: Population
    gradient: Gradient
    starts: int = 3
    share: float = 0.5

    def __post_init__(self) -> None:
        if self.starts < 1:
            raise InputError(f"starts is {self.starts}, expected at least 1")
        if not 0.0 < self.share < 1.0:
            raise InputError(f"share is {self.share}, expected a number between 0 and 1")

    @classmethod
    def from_settings(cls, settings: dict[str, Any]) -> Hybrid:
        """Return the solver; settings that are not its own go to the population method.

        ``method`` and ``plugin`` name the two parts.
        """
        given = {"encoding": "scaled", **settings}
        gradient = Gradient(plugin=str(given.pop("plugin", "ipopt")))
        own = {name: given.pop(name) for name in ("starts", "share") if name in given}
        return cls(Population.from_settings(given), gradient, **own)

    def check_available(self) -> None:
        """Raise `UnavailableError` when one of the parts is not there."""
        self.population.check_available()
        self.gradient.check_available()

    def run(self, task: TrajectoryTask, request: Request) -> Outcome:
        """Search, then refine the best few; see `Solver.run`."""
        if task.search.protocol == "per-joint":
            raise InputError("a hybrid solver moves all joints together, expected search.protocol 'shared'")
        begin = time.perf_counter()
        first, problem = self._look_around(task, request)
        starts = (problem.nlp.decode(x) for _, _, x in problem.archive.entries)
        outcomes = run_from_each(self.gradient, task, request, starts, begin=begin, before=[first])
        return join_outcomes(task, outcomes)

    def _look_around(self, task: TrajectoryTask, request: Request) -> tuple[Outcome, Counted]:
        begin = time.perf_counter()
        nlp = self.population.problem(task)
        total = int(DEFAULT_FRACTION * DEFAULT_BUDGET) if request.budget is None else request.budget
        part = replace(
            request,
            budget=max(1, int(self.share * total)),
            time_limit=None if request.time_limit is None else self.share * request.time_limit,
        )
        problem = Counted(nlp, part.budget, keep=self.starts)
        start, spent, counts = self.population.start_candidates(nlp, part)
        build_time = time.perf_counter() - begin
        solution = self.population.search_counted(problem, part, start)
        counts = {**counts, "evaluate": problem.evaluations}
        solution = replace(
            solution, build_time=solution.build_time + build_time, evaluations=solution.evaluations + spent
        )
        solution, diagnosis = explained(nlp, solution)
        return Outcome(nlp.decode(solution.x), solution, counts, diagnosis), problem
