"""Time against effort: the front of motions none of which is both faster and cheaper, by continuation.

The duration is bounded and the second objective minimised (the epsilon constraint): the front is found whatever its
shape, while weighted sums miss its hollows. It is followed from the shortest motion to slower ones; each point starts
from its neighbour, which keeps the longer bound too, so that costs never grow along it. Optima are local: where a
slower motion is of a better kind, the way back carries it to the faster ones.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from typing import Any

import numpy as np

from ocp_traj.arrays import Array, read_only
from ocp_traj.audit.costs import objective_value
from ocp_traj.exceptions import InputError, did_you_mean
from ocp_traj.files import finite
from ocp_traj.quantities import COSTS
from ocp_traj.solving import SolveResult, solve
from ocp_traj.task import Objective, TrajectoryTask
from ocp_traj.trajectory import Trajectory

FAST_END_SLACK = 1e-4
"""At the fast end the cheapest of all motions within this fraction of the shortest duration is looked for."""

SMALLEST_GAIN = 1e-4
"""On the way back a point is replaced by one that is cheaper by more than this fraction."""

TIE_TOLERANCE = 1e-7
"""Durations and values that differ by less than this fraction are equal when points are compared."""


@dataclass(frozen=True, eq=False)
class ParetoFront:
    """Motions of one task from the fastest to the slowest allowed, each audited.

    Attributes
    ----------
    task : TrajectoryTask
    quantity, unit : str
        The second objective beside the duration.
    bounds : (N,) s
        The bound on the duration of each point.
    results : tuple of N SolveResult
        The answers, feasible or not; the reason of a failure is in each one's ``message``.
    durations, values : (N,)
        Duration (s) and second objective of each motion, nan where there is none.
    feasible : (N,) bool
        The audit's verdict.
    dominated : (N,) bool
        Another feasible point is as fast and as cheap; of equal points the first counts.
    """

    task: TrajectoryTask
    quantity: str
    unit: str
    bounds: Array
    results: tuple[SolveResult, ...]
    durations: Array
    values: Array
    feasible: Any
    dominated: Any

    @property
    def efficient(self) -> Any:
        """Points of the front itself: feasible and not dominated, (N,) bool."""
        return self.feasible & ~self.dominated

    @cached_property
    def verdicts(self) -> tuple[str, ...]:
        """What each point is, in a word: ``efficient``, ``dominated`` or ``infeasible``."""
        words = np.where(self.feasible, np.where(self.dominated, "dominated", "efficient"), "infeasible")
        return tuple(str(word) for word in words)

    def to_json(self) -> dict[str, Any]:
        """Return the front with every point's full result; numbers finite or null."""
        points = [
            {
                "bound": finite(self.bounds[index]),
                "duration": finite(self.durations[index]),
                "value": finite(self.values[index]),
                "feasible": bool(self.feasible[index]),
                "dominated": bool(self.dominated[index]),
                "result": result.to_json(),
            }
            for index, result in enumerate(self.results)
        ]
        return {
            "schema": 1,
            "case": self.task.name,
            "quantity": self.quantity,
            "unit": self.unit,
            "solver": self.results[0].solver if self.results else None,
            "points": points,
        }

    def rows(self) -> list[list[str]]:
        """Return the cells of a table: number, bound, duration, value, verdict, status."""
        return [
            [
                str(index + 1),
                _number(self.bounds[index], ".4f"),
                _number(self.durations[index], ".4f"),
                _number(self.values[index], ".6g"),
                self.verdicts[index],
                result.status,
            ]
            for index, result in enumerate(self.results)
        ]

    @property
    def columns(self) -> list[str]:
        """Return the heads of `rows`."""
        return ["point", "at most, s", "duration, s", f"{self.quantity}, {self.unit}", "verdict", "status"]

    def __str__(self) -> str:
        cells = [self.columns, *self.rows()]
        widths = [max(len(row[column]) for row in cells) for column in range(len(self.columns))]
        lines = ["  ".join(cell.rjust(width) for cell, width in zip(row, widths)) for row in cells]
        count = int(self.efficient.sum())
        title = f"{self.task.name}: duration against {self.quantity}, {count} of {len(self.results)} points efficient"
        return "\n".join([title, *lines])

    def _repr_html_(self) -> str:
        def row(cells: list[str], tag: str) -> str:
            return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"

        title = escape(f"{self.task.name}: duration against {self.quantity}")
        body = "".join(row(cells, "td") for cells in self.rows())
        return f"<table><caption>{title}</caption>{row(self.columns, 'th')}{body}</table>"


def pareto_front(
    task: TrajectoryTask, points: int = 10, *, objective: str | None = None, **options: Any
) -> ParetoFront:
    """Return the front of duration against a second objective.

    Parameters
    ----------
    task, points, objective, **options
        As in `follow_front`: ``slowest``, ``solver``, ``seed`` and ``time_limit`` are the options.

    Raises
    ------
    InputError
        The task has no second objective, or a number makes no sense; says what there is.
    """
    return collect_front(task, objective, list(follow_front(task, points, objective=objective, **options)))


@dataclass(frozen=True, eq=False)
class FrontPoint:
    """One point of a front as it is found.

    Attributes
    ----------
    index : int
        From 0, the fastest; a point found again on the way back replaces the one before.
    bound : float
        On the duration, s.
    result : SolveResult
    """

    index: int
    bound: float
    result: SolveResult


def follow_front(
    task: TrajectoryTask,
    points: int = 10,
    *,
    objective: str | None = None,
    slowest: float = 2.0,
    solver: str = "ipopt",
    seed: int = 0,
    time_limit: float | None = None,
) -> Iterator[FrontPoint]:
    """Yield each point of a front as it is found; cheaper ones found on the way back come again.

    Without a shortest motion there is one point, which says why.

    Parameters
    ----------
    task : TrajectoryTask
        Its own bounds on durations hold for every point.
    points : int
        Number of points, 2 or more; their bounds on the duration are spaced geometrically.
    objective : str, optional
        The second objective, a name of `ocp_traj.quantities.COSTS`. By default what the task weighs beside time; if
        that is nothing, the energy of a robot with inertia.
    slowest : float
        The last bound, in units of the shortest duration; the task's own bound where that is less.
    solver : str
        Name, with parameters.
    seed : int
        Source of all randomness.
    time_limit : float, optional
        Seconds at most per point.

    Raises
    ------
    InputError
        The task has no second objective, or a number makes no sense; says what there is.
    """
    if points < 2:
        raise InputError(f"a front of {points} points was asked for, expected at least 2")
    if not (np.isfinite(slowest) and slowest > 1.0):
        raise InputError(f"the slowest motion shall take {slowest} times the shortest, expected more than 1")
    effort = second_objective(task, objective)
    asked: dict[str, Any] = {"seed": seed, "time_limit": time_limit}
    fastest = solve(task.changed(objective=task.objective.with_weights({"time": 1.0})), solver, **asked)
    high = float(np.asarray(task.objective.duration)[1])
    if not fastest.feasible or fastest.trajectory is None or fastest.duration is None:
        yield FrontPoint(0, high, fastest)
        return
    last = max(min(high, slowest * fastest.duration), fastest.duration * (1.0 + FAST_END_SLACK))
    bounds = np.minimum(np.geomspace(fastest.duration * (1.0 + FAST_END_SLACK), last, points), high)
    tasks = [_bounded(task, effort, float(bound)) for bound in bounds]
    neighbour, found = fastest.trajectory, []
    for index, cheaper in enumerate(tasks):
        result = solve(cheaper, solver, warm_start=_start(cheaper, neighbour, bounds[index]), **asked)
        neighbour = result.trajectory if result.feasible and result.trajectory is not None else neighbour
        found.append(result)
        yield FrontPoint(index, float(bounds[index]), result)
    for index in range(points - 2, -1, -1):  # back, as long as that pays
        slower = found[index + 1].trajectory
        if slower is None:
            return
        start = _start(tasks[index], slower, bounds[index])
        again = solve(tasks[index], solver, warm_start=start, **asked)
        if not _is_cheaper(again, found[index]):
            return
        found[index] = again
        yield FrontPoint(index, float(bounds[index]), again)


def _bounded(task: TrajectoryTask, effort: Objective, bound: float) -> TrajectoryTask:
    low = float(np.asarray(task.objective.duration)[0])
    return task.changed(objective=replace(effort, duration=(low, bound)))


def _is_cheaper(new: SolveResult, old: SolveResult) -> bool:
    if not new.feasible or new.objective is None:
        return False
    return not old.feasible or old.objective is None or new.objective < old.objective * (1.0 - SMALLEST_GAIN)


def second_objective(task: TrajectoryTask, name: str | None = None) -> Objective:
    """Return the objective of the points of a front: a named term alone, or what the task weighs beside time.

    Raises
    ------
    InputError
        There is none, or the task's robot does not allow the one named.
    """
    own = task.objective
    if name is None:
        if set(own.weights) - {"time"} or own.custom:
            return replace(own, time=0.0)
        if not task.has_inertia:
            raise InputError(
                f"{task.name} weighs time only and has no robot with inertia: choose the second objective, one of "
                f"{', '.join(_efforts(kinematic=True))}"
            )
        name = "energy"
    if name not in _efforts():
        hint = did_you_mean(name, _efforts())
        raise InputError(f"the objective {name!r} is unknown, expected one of {', '.join(_efforts())}{hint}")
    if COSTS[name].needs_inertia and not task.has_inertia:
        raise InputError(
            f"{name} needs a robot with inertia, but {task.name} has none; expected one of "
            f"{', '.join(_efforts(kinematic=True))}"
        )
    if name == "motor_loss" and own.motor is None:
        raise InputError(f"motor_loss needs the motors' parameters, but {task.name} has none in robot.motor")
    return own.with_weights({name: 1.0})


def _efforts(kinematic: bool = False) -> list[str]:
    """Return the costs beside time, all of them or those that need no robot."""
    return [
        name for name, row in COSTS.items() if name != "time" and not (kinematic and row.needs_inertia)
    ]


def collect_front(task: TrajectoryTask, objective: str | None, found: Sequence[FrontPoint]) -> ParetoFront:
    """Return the points `follow_front` yielded as a front, compared with each other; the last of an index counts."""
    effort = second_objective(task, objective)
    terms = [*effort.weights, *(custom.name for custom in effort.custom)]
    single = len(terms) == 1 and terms[0] in COSTS
    scale = effort.weights[terms[0]] if single else 1.0
    valued = task.changed(objective=effort)
    latest = {point.index: point for point in found}
    results = tuple(latest[index].result for index in sorted(latest))
    durations = np.array([np.nan if each.duration is None else each.duration for each in results])
    values = np.array([_value(valued, each.trajectory) / scale for each in results])
    feasible = np.array([each.feasible for each in results], dtype=bool)
    return ParetoFront(
        task,
        " + ".join(terms),
        COSTS[terms[0]].unit if single else "weighted",
        read_only(np.array([latest[index].bound for index in sorted(latest)])),
        results,
        read_only(durations),
        read_only(values),
        feasible,
        dominated_points(durations, values, feasible),
    )


def dominated_points(durations: Array, values: Array, feasible: Any) -> Any:
    """Return which feasible points another one matches or beats in both, (N,) bool; the first of equals stays."""
    each = np.stack([durations, values], axis=1)
    tie = TIE_TOLERANCE * np.maximum(np.abs(each[:, None]), np.abs(each))
    no_worse = (each[:, None] <= each + tie).all(axis=2)
    beats = no_worse & (~no_worse.T | np.triu(np.ones_like(no_worse), 1))
    return np.asarray(feasible) & (beats & np.asarray(feasible)[:, None]).any(axis=0)


def _start(task: TrajectoryTask, neighbour: Trajectory, bound: float) -> Trajectory:
    """Return the neighbour, or the neighbour slowed down to the bound where that is allowed and cheaper.

    A neighbour that is slower than the bound is sped up to it: a start only, it may break limits.
    """
    if not task.boundary.is_rest or not np.isinf(np.asarray(task.objective.gap_durations)[:, 1]).all():
        return neighbour
    scaled = neighbour.scaled(bound / neighbour.duration)
    if neighbour.duration > bound or objective_value(task, scaled) < objective_value(task, neighbour):
        return scaled
    return neighbour


def _value(task: TrajectoryTask, trajectory: Trajectory | None) -> float:
    return np.nan if trajectory is None else objective_value(task, trajectory)


def _number(value: float, form: str) -> str:
    return format(value, form) if np.isfinite(value) else "–"
