"""Outcomes of several runs of one task: one run after the other on what is left, and the best of them."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from metaheuristics import History, Solution
from ocp_traj.audit import audit
from ocp_traj.audit.costs import objective_value
from ocp_traj.solvers.mending import LARGEST_REPAIR
from ocp_traj.solvers.solver import SMALLEST_BUDGET, Outcome, Request, Solver
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory


def run_from_each(
    solver: Solver,
    task: TrajectoryTask,
    request: Request,
    starts: Iterable[Trajectory | None],
    *,
    begin: float,
    before: Sequence[Outcome] = (),
) -> list[Outcome]:
    """Run a solver from several motions in turn, until budget or time is used up; there is always one outcome.

    A run that would not end in time, were it as long as the longest so far, is not begun.

    Parameters
    ----------
    solver, task, request
        Each run gets what is left of the request.
    starts : iterable of Trajectory or None
        None leaves the start to the solver.
    begin : float
        Clock (`time.perf_counter`) when the time of the request began, s.
    before : sequence of Outcome
        Of runs already made, which have spent a share of the budget; they come first in the answer.
    """
    outcomes, longest = list(before), 0.0
    for start in starts:
        spent = sum(outcome.solution.evaluations for outcome in outcomes)
        left = request.less(spent, time.perf_counter() - begin)
        if outcomes and left.exhausted(SMALLEST_BUDGET):
            break
        if outcomes and left.time_limit is not None and longest > left.time_limit:
            break
        started = time.perf_counter()
        outcomes.append(solver.run(task, replace(left, warm_start=start)))
        longest = max(longest, time.perf_counter() - started)
    return outcomes


def join_outcomes(task: TrajectoryTask, outcomes: Sequence[Outcome]) -> Outcome:
    """Return the best of several outcomes of one task with the evaluations and the seconds of all."""
    values = [_value(task, outcome) for outcome in outcomes]
    best = outcomes[min(range(len(outcomes)), key=values.__getitem__)]
    solutions = [outcome.solution for outcome in outcomes]
    solution = best.solution.paying_for(
        solutions,
        history=_joined_history(solutions, len(best.solution.x)),
        message=f"{best.solution.message} Best of {len(outcomes)} runs.",
    )
    return replace(best, solution=solution, counts=add_counts(*(outcome.counts for outcome in outcomes)))


def add_counts(*counts: dict[str, int]) -> dict[str, int]:
    """Return the sums of several runs' calls of each function."""
    total: dict[str, int] = {}
    for part in counts:
        for name, count in part.items():
            total[name] = total.get(name, 0) + count
    return total


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
        shifted = (history.evaluations + evaluations, history.cost, history.violation, history.seconds + seconds)
        for column, values in zip(columns, shifted):
            column.append(values)
        evaluations, seconds = evaluations + part.evaluations, seconds + part.seconds
    at, cost, violation, when = (np.concatenate(column) for column in columns)
    return History.of(cost, evaluations=at, dimension=dimension, violation=violation, seconds=when)
