"""Timing of a fixed path as a convex problem (Verscheure et al. 2009): time, or time and thermal energy."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.deadline import Deadline
from ocp_traj.exceptions import InputError
from ocp_traj.references.timing.clarabel_solver import best_backend
from ocp_traj.references.timing.convex_problem import TimingAnswer, TimingNumbers, solve_numbers
from ocp_traj.references.timing.half_planes import touching
from ocp_traj.references.timing.path_limits import PathRows, describe, path_rows
from ocp_traj.references.timing.paths import (
    CELLS_A_PIECE,
    GeometricPath,
    PathGrid,
    geometric_path,
    sample_path,
)
from ocp_traj.references.timing.result import ReferenceResult
from ocp_traj.references.timing.timing import (
    ScaledRows,
    failure_at,
    finished,
    nothing_moves,
    reason_against,
    scale_rows,
    time_unit,
)
from ocp_traj.references.timing.toppra_reference import FRICTION_ROUNDS, toppra_reference

if TYPE_CHECKING:
    import numpy.typing as npt

    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

FALLBACK_GRID = 1000
LEAST_CELLS = 100
ACTIVE_MULTIPLIER = 1e-6
"""A limit counts as active where loosening it by all of itself would gain this share of the duration."""

WORK = 25.0
"""Compiling and solving the convex problem takes about so many times as long as TOPP-RA on the same grid."""

NEAR_REST = 20.0
"""Slope of the typical profile of x near a rest, where the path has length 1 and the motion lasts about 1."""


def convex_reference(
    task: TrajectoryTask,
    path: str | Trajectory = "uniform",
    *,
    thermal_weight: float = 0.0,
    points: int | None = None,
    time_limit: float = np.inf,
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
    time_limit : float
        Seconds; where the problem is not expected to be solved by then, fewer cells are taken, or none.

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
    deadline = Deadline(time_limit)
    curve = geometric_path(task, path)
    if curve.curve is None:
        return nothing_moves("convex", curve, task)
    if deadline.passed:
        return _unfinished(curve, deadline)
    best_backend()  # the compiler is loaded once, which takes a second or two
    if points is not None:
        return _solve_on_grid(task, curve, points, thermal_weight, deadline)
    fastest = toppra_reference(task, path, time_limit=deadline.left / 2)
    wanted = fastest.points or FALLBACK_GRID
    possible = _possible_points(fastest, curve.curve, wanted, deadline.left)
    if not possible:
        return _unfinished(curve, deadline)
    result = _solve_on_grid(task, curve, possible, thermal_weight, deadline)
    if possible == wanted or result.reason:
        return result
    allowed = f"its {deadline} of the time limit allowed for {possible} of {wanted} cells"
    return replace(result, reason=f"{allowed}, so the duration may still change")


def _possible_points(fastest: ReferenceResult, curve: Trajectory, wanted: int, seconds: float) -> int:
    """Return the cells to ask for so that the problem is solved in time, going by TOPP-RA's pace; 0 for none."""
    if np.isinf(seconds) or not len(fastest.s):
        return wanted
    pace = WORK * (fastest.build_time + fastest.solve_time) / len(fastest.s)  # seconds a cell
    cells = seconds / pace
    fewest = max(LEAST_CELLS, CELLS_A_PIECE * (len(curve.breakpoints) - 1))
    return 0 if cells < fewest else min(wanted, int(cells))


def _unfinished(path: GeometricPath, deadline: Deadline) -> ReferenceResult:
    reason = "the time limit left no time for this path"
    if deadline.seconds > 0:
        reason = f"its {deadline} of the time limit do not allow for the convex problem of this path"
    return ReferenceResult("convex", path.name, None, reason)


def _solve_on_grid(
    task: TrajectoryTask, path: GeometricPath, points: int, thermal_weight: float, deadline: Deadline
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
    answer, kept = solve_timing(task, grid, rows, end_x, unit, thermal_weight, deadline)
    timings: dict[str, Any] = {"build_time": built - began, "solve_time": time.perf_counter() - built}
    if answer.y is None and deadline.passed:
        return _unfinished(path, deadline)
    if answer.y is None:
        reason = f"the convex problem has no solution on this path (Clarabel: {answer.status})"
        return ReferenceResult("convex", path.name, None, reason, **timings)
    active, multipliers = active_limits(grid, rows, kept, answer, unit)
    return finished(
        "convex",
        path,
        grid,
        rows,
        answer.y * kept.profile / unit**2,
        points=points,
        active=active,
        multipliers=multipliers,
        objective=answer.objective * unit,
        **timings,
    )


def solve_timing(
    task: TrajectoryTask,
    grid: PathGrid,
    rows: PathRows,
    end_x: Array,
    unit: float,
    thermal_weight: float,
    deadline: Deadline,
) -> tuple[TimingAnswer, KeptRows]:
    """Solve in units of `unit` seconds; viscous friction by its tangent at the last profile, iterated."""
    profile = typical_profile(grid, end_x)
    guess: Array | None = None
    last = np.inf
    for _ in range(FRICTION_ROUNDS):
        kept = keep_rows(grid, rows, scale_rows(rows, unit, guess), profile)
        if kept.empty_cell >= 0:
            return TimingAnswer(failure_at(grid, rows, kept.empty_cell)), kept
        numbers = timing_numbers(grid, kept, end_x * unit**2)
        if thermal_weight > 0:
            numbers = _with_torques(numbers, grid, rows, unit, guess, thermal_weight, profile)
        answer = solve_numbers(numbers, deadline)
        if answer.y is None or not rows.by_speed.any():
            break
        if abs(answer.objective - last) <= 1e-7 * abs(answer.objective):
            break
        guess, last = answer.y * profile, answer.objective
    return answer, kept


def typical_profile(grid: PathGrid, end_x: Array) -> Array:
    """Return a profile (N + 1,) of order one that falls linearly to rests, as x does there; above 0 everywhere."""
    resting = grid.stops.copy()
    resting[[0, -1]] = end_x <= 0
    if not resting.any():
        return np.ones(len(grid.s))
    distance = np.abs(grid.s[:, None] - grid.s[resting][None, :]).min(axis=1)
    profile = np.minimum(1.0, NEAR_REST * distance)
    width = np.diff(grid.s)
    beside = np.minimum(np.append(width, np.inf), np.append(np.inf, width))
    return np.asarray(np.where(resting, np.minimum(1.0, NEAR_REST * beside), profile))


@dataclass(frozen=True)
class KeptRows:
    """Rows by_start y_i + by_end y_(i+1) <= bound that touch the set of possible (y_i, y_(i+1)).

    Attributes
    ----------
    profile : (N + 1,) array
        x = y profile, in the unit of time of the rows.
    by_start, by_end, bound : (N, r) arrays
        Each row divided by `size` (N, r); rows of zeros fill the table.
    sources : (N, r) int array
        Index among the prepared rows; -1 for fillers, -2 and -3 for the bounds on speed at start and end.
    empty_cell : int
        First cell without any possible (x_i, x_(i+1)), or -1.
    """

    profile: Array
    by_start: Array
    by_end: Array
    bound: Array
    size: Array
    sources: npt.NDArray[np.int_]
    empty_cell: int


def keep_rows(grid: PathGrid, rows: PathRows, scaled: ScaledRows, profile: Array) -> KeptRows:
    """Return the rows that matter, with u = (x_(i+1) - x_i) / 2 ds_i eliminated, in a table of even width.

    Of the dozens of rows of a cell few touch the polygon they leave in the plane of (y_i, y_(i+1)); the others are
    redundant whatever the objective.
    """
    by_u = scaled.by_u / (2.0 * np.diff(grid.s))[:, None]
    normals = np.stack([scaled.by_start - by_u, scaled.by_end + by_u], axis=2)
    speeds, bounds = _speed_rows(scaled.largest_x)
    normals = np.concatenate([normals, speeds], axis=1)
    normals *= np.stack([profile[:-1], profile[1:]], axis=1)[:, None, :]
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
        profile,
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
    root = np.sqrt(kept.profile)
    pace = root[:-1] + root[1:]
    end_y = end_x / kept.profile[[0, -1]]
    times = 2.0 * np.diff(grid.s) / pace
    return TimingNumbers(times, root[:-1] / pace, kept.by_start, kept.by_end, kept.bound, end_y)


def _with_torques(
    numbers: TimingNumbers,
    grid: PathGrid,
    rows: PathRows,
    unit: float,
    guess: Array | None,
    thermal_weight: float,
    profile: Array,
) -> TimingNumbers:
    """Add the torques at the cells' middles (mean of both ends), over their limits, to the objective."""
    chosen = [index for index, (name, _) in enumerate(rows.labels) if name == "torque"]
    limit = np.maximum(np.abs(rows.lower), np.abs(rows.upper))[:, :, chosen]
    limited = np.isfinite(limit) & (limit > 0)
    share = np.where(limited, np.sqrt(thermal_weight) / np.where(limited, limit, 1.0), 0.0)
    by_x, constant = rows.by_x[:, :, chosen] / unit**2, rows.constant[:, :, chosen]
    friction = rows.by_speed[:, :, chosen] / unit
    if guess is not None and friction.any():
        ends = np.sqrt(np.maximum(np.stack([guess[:-1], guess[1:]], axis=1)[:, :, None], 1e-6))
        by_x, constant = by_x + 0.5 * friction / ends, constant + 0.5 * friction * ends
    width = np.diff(grid.s)[:, None]
    by_u = 0.25 * (share * rows.by_u[:, :, chosen]).sum(axis=1) / unit**2 / width
    by_x, constant = 0.5 * share * by_x, 0.5 * share * constant
    return replace(
        numbers,
        torque_start=(by_x[:, 0] - by_u) * profile[:-1, None],
        torque_end=(by_x[:, 1] + by_u) * profile[1:, None],
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
