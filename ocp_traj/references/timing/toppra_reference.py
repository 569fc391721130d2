"""Time-optimal timing of a fixed path by reachability analysis (TOPP-RA, Pham and Pham 2018)."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.deadline import NO_DEADLINE, Deadline
from ocp_traj.exceptions import InputError
from ocp_traj.references.timing.path_limits import PathRows, path_rows
from ocp_traj.references.timing.paths import GeometricPath, PathGrid, geometric_path, sample_path
from ocp_traj.references.timing.result import ReferenceResult, cell_durations
from ocp_traj.references.timing.timing import (
    ScaledRows,
    failure_at,
    finished,
    nothing_moves,
    reason_against,
    scale_rows,
    time_unit,
)

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

FIRST_GRID = 200
LARGEST_GRID = 12_800
FRICTION_ROUNDS = 30

_logger = logging.getLogger(__name__)


def toppra_reference(
    task: TrajectoryTask,
    path: str | Trajectory = "uniform",
    *,
    duration: float | None = None,
    stability: float = 5e-4,
    points: int | None = None,
    time_limit: float = np.inf,
) -> ReferenceResult:
    """Return the shortest timing of a fixed path within velocity, acceleration and torque limits.

    Parameters
    ----------
    task : TrajectoryTask
    path : ``"uniform"``, ``"chord"`` or a Trajectory
        See `geometric_path`. Position, jerk and torque-rate limits are not looked at.
    duration : float, optional
        Duration wanted, s; the shortest when left out. A longer one is the shortest slowed uniformly.
    stability : float
        The grid is doubled until the duration changes relatively by less than this (0.05 %, which leaves less than
        0.1 % where the error at least halves).
    points : int, optional
        Number of cells, instead of that doubling.
    time_limit : float
        Seconds; a grid that is not expected to be finished by then is not begun. The first one is if there is any.

    Returns
    -------
    ReferenceResult
        With `duration` None and a `reason` where no timing was found; with both where time was up before the
        duration was stable.

    Raises
    ------
    InputError
        The path is unknown or does not fit, or the wanted duration is no positive number.
    """
    if duration is not None and not (np.isfinite(duration) and duration > 0):
        raise InputError(f"duration is {duration}, expected a positive number of seconds")
    deadline = Deadline(time_limit)
    curve = geometric_path(task, path)
    if curve.curve is None:
        result = nothing_moves("toppra", curve, task)
    elif deadline.passed:
        return ReferenceResult("toppra", curve.name, None, "the time limit left no time for this path")
    else:
        result = refine(lambda cells: _solve_on_grid(task, curve, cells), stability, points, deadline)
    return result if duration is None else _slowed(result, task, curve, duration)


def refine(
    solve: Callable[[int], ReferenceResult],
    stability: float,
    points: int | None,
    deadline: Deadline = NO_DEADLINE,
) -> ReferenceResult:
    """Return `solve` on a grid of `points` cells, or doubled until the duration is stable.

    A failure on the first grids is not final: coarse cells at sharp turns can be infeasible. A grid of twice the
    cells is expected to take twice the time.
    """
    if points is not None:
        return solve(points)
    previous, cells = solve(FIRST_GRID), 2 * FIRST_GRID
    last = deadline.spent
    while cells <= LARGEST_GRID:
        if 2.0 * last > deadline.left:
            return replace(previous, reason=_out_of_time(previous, cells // 2, deadline))
        begun = deadline.spent
        result = solve(cells)
        last = deadline.spent - begun
        found = previous.duration is not None and result.duration is not None
        if found and abs(result.duration - previous.duration) <= stability * result.duration:  # type: ignore[operator]
            return result
        if previous.duration is None and result.duration is None and cells >= 8 * FIRST_GRID:
            return result
        previous, cells = result, 2 * cells
    if previous.duration is not None:
        reason = f"the duration still changes by more than {stability:g} with {LARGEST_GRID} cells"
        _logger.warning("%s path: %s", previous.path, reason)
    return previous


def _out_of_time(result: ReferenceResult, cells: int, deadline: Deadline) -> str:
    if result.duration is None:
        return f"{result.reason} (with {cells} cells; its {deadline} of the time limit did not allow for more)"
    return f"its {deadline} of the time limit allowed for {cells} cells only, so the duration may still change"


def _solve_on_grid(task: TrajectoryTask, path: GeometricPath, points: int) -> ReferenceResult:
    began = time.perf_counter()
    grid = sample_path(path, points)
    rows = path_rows(task, grid)
    end_x = (path.end_speeds / grid.length) ** 2
    reason = reason_against(task, grid, rows, end_x)
    if reason:
        return ReferenceResult("toppra", path.name, None, reason)
    built = time.perf_counter()
    x, node = fastest_timing(grid, rows, end_x)
    timings: dict[str, Any] = {"build_time": built - began, "solve_time": time.perf_counter() - built}
    if x is None:
        return ReferenceResult("toppra", path.name, None, failure_at(grid, rows, node), **timings)
    return finished("toppra", path, grid, rows, x, points=points, **timings)


def fastest_timing(grid: PathGrid, rows: PathRows, end_x: Array) -> tuple[Array | None, int]:
    """Return x = sdot^2 (N + 1,) in 1/s^2, or None and the grid point at which TOPP-RA gave up.

    Viscous friction is iterated: solved with its tangent at the last profile until the profile stands still. Every
    iterate after the first is feasible wherever friction adds to the load.
    """
    unit = time_unit(rows)
    guess: Array | None = None
    duration = np.inf
    for _ in range(FRICTION_ROUNDS):
        x, node = run_toppra(grid, scale_rows(rows, unit, guess), end_x * unit**2)
        if x is None:
            return None, node
        if not rows.by_speed.any():
            break
        last, duration = duration, float(cell_durations(grid.s, x).sum())
        if abs(duration - last) <= 1e-8 * duration:
            break
        guess = x
    return None if x is None else x / unit**2, -1


def run_toppra(grid: PathGrid, rows: ScaledRows, end_x: Array) -> tuple[Array | None, int]:
    """Run toppra's own passes over prepared rows; x in 1/unit^2, or None and the grid point of the failure."""
    import toppra
    import toppra.algorithm

    line = toppra.SplineInterpolator([0.0, 1.0], [[0.0], [1.0]])
    algorithm = toppra.algorithm.TOPPRA(
        [_prepared_constraint(grid, rows)], line, gridpoints=grid.s, solver_wrapper="seidel"
    )
    with _quiet(logging.getLogger("toppra")):
        _, speed, _, sets = algorithm.compute_parameterization(
            float(np.sqrt(end_x[0])), float(np.sqrt(end_x[1])), return_data=True
        )
    if speed is not None and np.isfinite(speed).all():
        return np.asarray(speed) ** 2, -1
    lost = np.flatnonzero(np.isnan(np.asarray(sets)).any(axis=1))
    if lost.size:
        return None, int(lost[-1])
    return None, 0 if speed is None else int(np.flatnonzero(~np.isfinite(speed))[0])


def _prepared_constraint(grid: PathGrid, rows: ScaledRows) -> Any:
    """Return toppra's constraint object for rows that are already computed."""
    from toppra.constraint import LinearConstraint

    steps = 2.0 * np.diff(grid.s)[:, None]
    by_u = rows.by_u + rows.by_end * steps  # x_(i+1) = x_i + 2 ds u
    by_x = rows.by_start + rows.by_end
    last = np.zeros((1, by_u.shape[1]))
    coefficients = (np.vstack([by_u, last]), np.vstack([by_x, last]))
    bound = np.vstack([rows.bound, last + 1.0])
    speeds = np.stack([np.zeros(len(grid.s)), np.minimum(rows.largest_x, 1e8)], axis=1)

    class PreparedConstraint(LinearConstraint):  # type: ignore[misc]
        """Rows by_u u + by_x x <= bound in every cell, and the bound on x."""

        def compute_constraint_params(self, path: Any, gridpoints: Any) -> tuple[Any, ...]:
            selection = np.broadcast_to(np.eye(by_u.shape[1]), (len(bound), by_u.shape[1], by_u.shape[1]))
            return (*coefficients, np.zeros_like(bound), selection, bound, None, speeds)

    return PreparedConstraint()


class _quiet:
    """Keep a library from logging warnings that become our own reasons."""

    def __init__(self, logger: logging.Logger) -> None:
        self.logger = logger

    def __enter__(self) -> None:
        self.level = self.logger.level
        self.logger.setLevel(logging.ERROR)

    def __exit__(self, *_: object) -> None:
        self.logger.setLevel(self.level)


def _slowed(
    fastest: ReferenceResult, task: TrajectoryTask, path: GeometricPath, duration: float
) -> ReferenceResult:
    """Return the fastest timing run uniformly slower so that it lasts `duration`."""
    if fastest.duration is None:
        return fastest
    if path.curve is None or duration < fastest.duration * (1 - 1e-9):
        possible = "no other than 0 s" if path.curve is None else f"at least {fastest.duration:.6g} s"
        reason = f"a duration of {duration:g} s was asked for, this path takes {possible}"
        return ReferenceResult(fastest.method, path.name, None, reason)
    if path.end_speeds.any() and duration > fastest.duration * (1 + 1e-9):
        reason = (
            f"a duration of {duration:g} s was asked for, but with moving ends the motion cannot be slowed"
        )
        return ReferenceResult(fastest.method, path.name, None, reason)
    grid = sample_path(path, fastest.points)
    rows = path_rows(task, grid)
    result = finished(
        "toppra", path, grid, rows, (fastest.speed * fastest.duration / duration) ** 2, points=fastest.points
    )
    if result.largest_ratio > max(1 + 1e-6, fastest.largest_ratio):
        reason = f"slowed to {duration:g} s, viscous friction takes a torque to {result.largest_ratio:.6g} of its limit"
        return replace(result, duration=None, reason=reason)
    return result
