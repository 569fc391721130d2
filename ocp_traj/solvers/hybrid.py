"""A population method looks around, a gradient solver finishes: from the best few distinct motions found."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from metaheuristics import History, Solution
from ocp_traj.audit import audit
from ocp_traj.audit.costs import objective_value
from ocp_traj.exceptions import InputError
from ocp_traj.solvers.gradient.gradient import Gradient
from ocp_traj.solvers.per_joint import DEFAULT_BUDGET
from ocp_traj.solvers.population.counting import Counted
from ocp_traj.solvers.population.population import Population
from ocp_traj.solvers.solver import Outcome, Request, Solver
from ocp_traj.task import TrajectoryTask

LARGEST_REPAIR = 1.02
"""Slowing up to which a motion counts as within the limits when answers are compared; the judge repairs as much."""


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
        clock = time.perf_counter()
        first, problem = self._look_around(task, request)
        outcomes = [first]
        for _, _, x in problem.archive.entries:
            spent = sum(outcome.solution.evaluations for outcome in outcomes)
            left = None if request.budget is None else request.budget - spent
            seconds = (
                None if request.time_limit is None else request.time_limit - (time.perf_counter() - clock)
            )
            if (left is not None and left < 2) or (seconds is not None and seconds <= 0):
                break
            start = problem.nlp.decode(x)
            outcomes.append(
                self.gradient.run(
                    task, Request(request.seed, left, seconds, request.progress, warm_start=start)
                )
            )
        return join_outcomes(task, outcomes)

    def _look_around(self, task: TrajectoryTask, request: Request) -> tuple[Outcome, Counted]:
        begin = time.perf_counter()
        nlp = self.population.problem(task)
        total = DEFAULT_BUDGET // 5 if request.budget is None else request.budget
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
        return Outcome(nlp.decode(solution.x), solution, counts), problem


def join_outcomes(task: TrajectoryTask, outcomes: Sequence[Outcome]) -> Outcome:
    """Return the best of several outcomes of one task with the evaluations and the seconds of all."""
    values = [_value(task, outcome) for outcome in outcomes]
    best = outcomes[min(range(len(outcomes)), key=values.__getitem__)]
    counts: dict[str, int] = {}
    for outcome in outcomes:
        for name, count in outcome.counts.items():
            counts[name] = counts.get(name, 0) + count
    solutions = [outcome.solution for outcome in outcomes]
    solution = replace(
        best.solution,
        evaluations=sum(part.evaluations for part in solutions),
        build_time=sum(part.build_time for part in solutions),
        solve_time=sum(part.solve_time for part in solutions),
        history=_joined_history(solutions, len(best.solution.x)),
        message=f"{best.solution.message} Best of {len(outcomes)} runs.",
    )
    return replace(best, solution=solution, counts=counts)


def _value(task: TrajectoryTask, outcome: Outcome) -> tuple[float, float]:
    """Return what answers are compared by: excess over the limits, then the objective, both of the exact motion."""
    if outcome.trajectory is None:
        return np.inf, np.inf
    scale = audit(task, outcome.trajectory).smallest_feasible_scale
    motion = outcome.trajectory
    if scale is None or scale > LARGEST_REPAIR:
        return (np.inf if scale is None else scale), objective_value(task, motion)
    return 0.0, objective_value(task, motion.scaled(scale) if scale > 1.0 else motion)


def _joined_history(solutions: Sequence[Solution], dimension: int) -> History:
    """Return the histories one after the other; variables of different forms are not kept."""
    evaluations, seconds = 0, 0.0
    columns: list[list[Any]] = [[], [], [], []]
    for part in solutions:
        history = part.history
        columns[0].append(history.evaluations + evaluations)
        columns[1].append(history.cost)
        columns[2].append(history.violation)
        columns[3].append(history.seconds + seconds)
        evaluations, seconds = evaluations + part.evaluations, seconds + part.build_time + part.solve_time
    at, cost, violation, when = (np.concatenate(column) for column in columns)
    return History(
        at.astype(np.intp),
        cost,
        violation,
        when,
        np.full((len(at), dimension), np.nan),
        np.full(len(at), np.nan),
    )
