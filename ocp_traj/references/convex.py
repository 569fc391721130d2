"""Timing of a fixed path as a convex problem (Verscheure et al. 2009): time, or time and thermal energy."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError
from ocp_traj.references.convex_problem import TimingAnswer, TimingNumbers, solve_numbers
from ocp_traj.references.half_planes import touching
from ocp_traj.references.path_limits import PathRows, describe, path_rows
from ocp_traj.references.paths import GeometricPath, PathGrid, geometric_path, sample_path
from ocp_traj.references.result import ReferenceResult
from ocp_traj.references.time_optimal import FRICTION_ROUNDS, toppra_reference
from ocp_traj.references.timing import (
    ScaledRows,
    failure_at,
    finished,
    nothing_moves,
    reason_against,
    scale_rows,
    time_unit,
)

if TYPE_CHECKING:
    import numpy.typing as npt

    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

FALLBACK_GRID = 1000
ACTIVE_MULTIPLIER = 1e-6
"""A limit counts as active where loosening it by all of itself would gain this share of the duration."""


def convex_reference(
    task: TrajectoryTask,
    path: str | Trajectory = "uniform",
    *,
    thermal_weight: float = 0.0,
    points: int | None = None,
) -> ReferenceResult:
    """Return the timing of a fixed path that minimises time, or time and thermal energy, by convex optimisation.

    The objective is duration + thermal_weight * integral of sum (torque / torque limit)^2 dt. The multipliers of
    the answer tell which limit is active in every cell and how much time loosening it would gain.

    Parameters
    ----------
    task : TrajectoryTask
    path : ``"uniform"``, ``"chord"`` or a Trajectory
        See `geometric_path`. Position, jerk and torque-rate limits are not looked at; for jerk see
        `jerk_limited_reference`.
    thermal_weight : float
        At least 0; above 0 it needs torque limits.
    points : int, optional
        Number of cells; when left out, as many as the time-optimal timing needs to be stable (`toppra_reference`).

    Returns
    -------
    ReferenceResult
        With `duration` None and a `reason` where no timing was found.

    Raises
    ------
    InputError
        The path or the weight cannot be used.
    """
    if not (np.isfinite(thermal_weight) and thermal_weight >= 0):
        raise InputError(f"thermal_weight is {thermal_weight}, expected a number of 0 or more")
    if thermal_weight > 0 and not (task.has_inertia and task.limited("torque")):
        raise InputError("thermal_weight is above 0, which needs a robot with inertia and torque limits")
    curve = geometric_path(task, path)
    if curve.curve is None:
        return nothing_moves("convex", curve, task)
    if points is None:
        fastest = toppra_reference(task, path)
        points = fastest.points or FALLBACK_GRID
    return _solve_on_grid(task, curve, points, thermal_weight)


def _solve_on_grid(
    task: TrajectoryTask, path: GeometricPath, points: int, thermal_weight: float
) -> ReferenceResult:
    began = time.perf_counter()
    grid = sample_path(path, points)
    rows = path_rows(task, grid)
    end_x = (path.end_speeds / grid.length) ** 2
    reason = reason_against(task, grid, rows, end_x)
    if reason:
        return ReferenceResult("convex", path.name, None, reason)
    unit = time_unit(rows)
    built = time.perf_counter()
    answer, kept = solve_timing(task, grid, rows, end_x, unit, thermal_weight)
    timings: dict[str, Any] = {"build_time": built - began, "solve_time": time.perf_counter() - built}
    if answer.x is None:
        reason = f"the convex problem has no solution on this path (Clarabel: {answer.status})"
        return ReferenceResult("convex", path.name, None, reason, **timings)
    active, multipliers = active_limits(grid, rows, kept, answer, unit)
    return finished(
        "convex",
        path,
        grid,
        rows,
        answer.x / unit**2,
        points=points,
        active=active,
        multipliers=multipliers,
        objective=answer.objective * unit,
        **timings,
    )


def solve_timing(
    task: TrajectoryTask, grid: PathGrid, rows: PathRows, end_x: Array, unit: float, thermal_weight: float
) -> tuple[TimingAnswer, KeptRows]:
    """Solve in units of `unit` seconds; viscous friction by its tangent at the last profile, iterated."""
    guess: Array | None = None
    last = np.inf
    for _ in range(FRICTION_ROUNDS):
        kept = keep_rows(grid, rows, scale_rows(rows, unit, guess))
        if kept.empty_cell >= 0:
            return TimingAnswer(failure_at(grid, rows, kept.empty_cell)), kept
        numbers = timing_numbers(grid, kept, end_x * unit**2)
        if thermal_weight > 0:
            numbers = _with_torques(numbers, rows, unit, guess, thermal_weight)
        answer = solve_numbers(numbers)
        if answer.x is None or not rows.by_speed.any():
            break
        if abs(answer.objective - last) <= 1e-7 * abs(answer.objective):
            break
        guess, last = answer.x, answer.objective
    return answer, kept


@dataclass(frozen=True)
class KeptRows:
    """Rows by_start x_i + by_end x_(i+1) <= bound that touch the set of possible (x_i, x_(i+1)).

    Attributes
    ----------
    by_start, by_end, bound : (N, r) arrays
        Each row divided by `size` (N, r); rows of zeros fill the table.
    sources : (N, r) int array
        Index among the prepared rows; -1 for fillers, -2 and -3 for the bounds on speed at start and end.
    empty_cell : int
        First cell without any possible (x_i, x_(i+1)), or -1.
    """

    by_start: Array
    by_end: Array
    bound: Array
    size: Array
    sources: npt.NDArray[np.int_]
    empty_cell: int


def keep_rows(grid: PathGrid, rows: PathRows, scaled: ScaledRows) -> KeptRows:
    """Return the rows that matter, with u = (x_(i+1) - x_i) / w_i eliminated, in a table of even width.

    Of the dozens of rows of a cell few touch the polygon they leave in the plane of (x_i, x_(i+1)); the others are
    redundant whatever the objective.
    """
    by_u = scaled.by_u / (2.0 * np.diff(grid.s))[:, None]
    normals = np.stack([scaled.by_start - by_u, scaled.by_end + by_u], axis=2)
    speeds, bounds = _speed_rows(scaled.largest_x)
    normals = np.concatenate([normals, speeds], axis=1)
    offsets = np.concatenate([scaled.bound, bounds], axis=1)
    size = np.linalg.norm(normals, axis=2)
    size = np.where(size > 0, size, 1.0)
    normals, offsets = normals / size[:, :, None], offsets / size
    edges, empty = touching(normals, offsets)
    width = max(2, 2 * int(np.ceil(edges.sum(axis=1).max() / 2)))
    order = np.argsort(np.logical_not(edges), axis=1, kind="stable")[:, :width]
    chosen = np.take_along_axis(edges, order, axis=1)
    normals = np.where(chosen[:, :, None], np.take_along_axis(normals, order[:, :, None], axis=1), 0.0)
    offsets = np.where(chosen, np.take_along_axis(offsets, order, axis=1), 1.0)
    count = scaled.bound.shape[1]
    sources = np.where(order >= count, count - order - 2, order)
    return KeptRows(
        normals[:, :, 0],
        normals[:, :, 1],
        offsets,
        np.take_along_axis(size, order, axis=1),
        np.where(chosen, sources, -1),
        int(np.argmax(empty)) if empty.any() else -1,
    )


def _speed_rows(largest_x: Array) -> tuple[Array, Array]:
    """Return x_i <= largest_i and x_(i+1) <= largest_(i+1) as rows (N, 2, 2) with bounds (N, 2)."""
    finite = np.isfinite(largest_x)
    factor = np.where(finite, 1.0, 0.0)
    positive = finite & (largest_x > 0)
    np.divide(1.0, largest_x, out=factor, where=positive)
    bound = np.where(largest_x > 0, 1.0, 0.0)
    normals = np.zeros((len(largest_x) - 1, 2, 2))
    normals[:, 0, 0], normals[:, 1, 1] = factor[:-1], factor[1:]
    return normals, np.stack([bound[:-1], bound[1:]], axis=1)


def timing_numbers(grid: PathGrid, kept: KeptRows, end_x: Array) -> TimingNumbers:
    """Return the problem's numbers without a thermal term."""
    root_weights = np.sqrt(2.0 * np.diff(grid.s) * len(grid.gaps))
    return TimingNumbers(root_weights, kept.by_start, kept.by_end, kept.bound, end_x)


def _with_torques(
    numbers: TimingNumbers,
    rows: PathRows,
    unit: float,
    guess: Array | None,
    thermal_weight: float,
) -> TimingNumbers:
    """Add the torques at the cells' middles (mean of both ends), over their limits, to the objective."""
    count = len(numbers.root_weights)
    chosen = [index for index, (name, _) in enumerate(rows.labels) if name == "torque"]
    limit = np.maximum(np.abs(rows.lower), np.abs(rows.upper))[:, :, chosen]
    limited = np.isfinite(limit) & (limit > 0)
    scale = np.sqrt(thermal_weight) * numbers.root_weights[:, None, None]
    share = np.where(limited, scale / np.where(limited, limit, 1.0), 0.0)
    by_x, constant = rows.by_x[:, :, chosen] / unit**2, rows.constant[:, :, chosen]
    friction = rows.by_speed[:, :, chosen] / unit
    if guess is not None and friction.any():
        ends = np.sqrt(np.maximum(np.stack([guess[:-1], guess[1:]], axis=1)[:, :, None], 1e-6))
        by_x, constant = by_x + 0.5 * friction / ends, constant + 0.5 * friction * ends
    by_u = (
        0.5
        * (share * rows.by_u[:, :, chosen]).sum(axis=1)
        / unit**2
        * (count / numbers.root_weights**2)[:, None]
    )
    by_x, constant = 0.5 * share * by_x, 0.5 * share * constant
    return replace(
        numbers,
        torque_start=by_x[:, 0] - by_u,
        torque_end=by_x[:, 1] + by_u,
        torque_constant=constant.sum(axis=1),
    )


def active_limits(
    grid: PathGrid, rows: PathRows, kept: KeptRows, answer: TimingAnswer, unit: float
) -> tuple[tuple[str, ...], Array]:
    """Return the active limit of every cell and its multiplier: seconds gained per relative loosening there."""
    assert answer.multipliers is not None
    count = len(rows.labels)
    group = np.where(kept.sources >= 0, kept.sources % max(count, 1), count - kept.sources - 2)
    gain = np.where(kept.sources == -1, 0.0, answer.multipliers / kept.size * unit)
    gain = np.where(kept.sources < -1, 2.0 * gain, gain)  # 1 % more speed is 2 % more x
    table = np.zeros((len(grid.gaps), count + 2))
    cells = np.broadcast_to(np.arange(len(table))[:, None], group.shape)
    np.add.at(table, (cells, np.where(kept.sources == -1, 0, group)), gain)
    column = table.argmax(axis=1)
    multipliers = table.max(axis=1)
    threshold = ACTIVE_MULTIPLIER * answer.objective * unit
    names = []
    for cell, index in enumerate(column):
        label = describe(*rows.labels[index]) if index < count else rows.x_labels[cell + index - count]
        names.append(label if multipliers[cell] > threshold else "")
    return tuple(names), multipliers
