"""Timing of a fixed path with bounded jerk, by a sequence of convex problems.

Along a path, with x = sdot^2, u = sddot and u' = du/ds, the jerk is sqrt(x) (q''' x + 3 q'' u + q' u'), so

    |q''' x + 3 q'' u + q' u'| <= J / sqrt(x).

The left side is linear in the unknowns; the right side is convex in x, and lies above its tangent at any x_k:

    |q''' x + 3 q'' u + q' u'| <= J (3/2 x_k^(-1/2) - 1/2 x_k^(-3/2) x).

Every solution with the tangent keeps the true limit, and x_k itself stays feasible. So from a feasible start (the
time-optimal timing, slowed until the jerk holds) the durations fall monotonically; the limit is a local optimum of
the discretised problem. At an end at rest the constant-jerk start x = (6 J s / q')^(4/3) (q'/J)^2 J^2/4 bounds x at
the first grid point where the task wants zero end acceleration.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.deadline import Deadline
from ocp_traj.exceptions import InputError
from ocp_traj.references.timing.clarabel_solver import best_backend
from ocp_traj.references.timing.path_limits import PathRows, path_rows
from ocp_traj.references.timing.paths import PathGrid, geometric_path, sample_path
from ocp_traj.references.timing.result import ReferenceResult, cell_durations
from ocp_traj.references.timing.timing import failure_at, finished, nothing_moves, reason_against, scale_rows
from ocp_traj.references.timing.toppra_reference import fastest_timing

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

ROUNDS = 60

WORK = 60.0
"""Compiling the problem and the first rounds take about so many times as long as preparing its grid."""


def jerk_limited_reference(
    task: TrajectoryTask,
    path: str | Trajectory = "chord",
    *,
    points: int = 300,
    tolerance: float = 1e-4,
    time_limit: float = np.inf,
) -> ReferenceResult:
    """Return a timing of a fixed path with bounded jerk besides velocity, acceleration and torque.

    A local optimum on one grid: an estimate, not a bound. The paths ``"uniform"`` and ``"chord"`` have continuous
    curvature; a path of another motion needs it too.

    Parameters
    ----------
    task : TrajectoryTask
        From rest to rest, with jerk limits.
    path : ``"uniform"``, ``"chord"`` or a Trajectory
    points : int
        Cells of the grid.
    tolerance : float
        The sequence stops when the duration falls by less than this share.
    time_limit : float
        Seconds; the last timing of the sequence by then is returned.

    Raises
    ------
    InputError
        The task has no jerk limit, or an end is not at rest, or viscous friction acts under a torque limit.
    """
    if not task.limited("jerk"):
        raise InputError("the task has no jerk limit; use convex_reference or toppra_reference")
    curve = geometric_path(task, path)
    if curve.end_speeds.any():
        raise InputError("an end is not at rest, which timing with bounded jerk does not cover")
    if curve.curve is None:
        return nothing_moves("convex-jerk", curve, task)
    deadline = Deadline(time_limit)
    if deadline.left <= 0.0:
        return ReferenceResult("convex-jerk", curve.name, None, "the time limit left no time for this path")
    began = time.perf_counter()
    grid = sample_path(curve, points, dense_ends=True)
    rows = path_rows(task, grid)
    if rows.by_speed.any():
        raise InputError(
            "viscous friction acts under a torque limit, which timing with bounded jerk does not cover"
        )
    rest = np.zeros(2)
    reason = reason_against(task, grid, rows, rest)
    x, node = (None, 0) if reason else fastest_timing(grid, rows, rest)
    if x is None:
        return ReferenceResult("convex-jerk", curve.name, None, reason or failure_at(grid, rows, node))
    problem = _JerkProblem(task, grid, rows)
    built = time.perf_counter()
    if WORK * (built - began) > deadline.left:
        reason = f"its {deadline} of the time limit do not allow for timing this path with bounded jerk"
        return ReferenceResult("convex-jerk", curve.name, None, reason)
    x, reason = problem.improve(smooth_timing(grid), tolerance, deadline)
    timings: dict[str, Any] = {"build_time": built - began, "solve_time": time.perf_counter() - built}
    if reason:
        return ReferenceResult("convex-jerk", curve.name, None, reason, **timings)
    result = finished("convex-jerk", curve, grid, rows, x, points=points, **timings)
    if not deadline.passed or result.reason:
        return result
    reason = f"its {deadline} of the time limit ended the sequence, so the duration may still fall"
    return replace(result, reason=reason)


def smooth_timing(grid: PathGrid) -> Array:
    """Return x (N + 1,) of the motion along s = 10 t^3 - 15 t^4 + 6 t^5 in one second, the sequence's start."""
    t = np.linspace(0.0, 1.0, 4001)
    s = t**3 * (10.0 - 15.0 * t + 6.0 * t**2)
    return np.asarray(np.interp(grid.s, s, 30.0 * t**2 * (1.0 - t) ** 2) ** 2)


@dataclass(frozen=True)
class _JerkRows:
    """Rows |by_x x_i + before u_(i-1) + after u_i| <= limit / sqrt(x_i) at inner grid points, (N - 1, r)."""

    by_x: Array
    before: Array
    after: Array
    limit: Array


def jerk_rows(task: TrajectoryTask, grid: PathGrid) -> _JerkRows:
    """Return the jerk rows of both sides of every inner grid point.

    u is constant in cells, so u' at a grid point is the step of u over the mean width of its cells, and u there is
    their mean; q''' is the difference of q'' over a cell.
    """
    width = np.diff(grid.s)
    third = (grid.curvature[:, 1] - grid.curvature[:, 0]) / width[:, None]
    reach = 0.5 * (width[:-1] + width[1:])[:, None]
    limits = task.limits.get("jerk")[grid.gaps]
    blocks = []
    for side in (0, 1):  # the cell before, the cell after
        cells = slice(0, -1) if side == 0 else slice(1, None)
        tangent, curvature = grid.tangent[cells, 1 - side], grid.curvature[cells, 1 - side]
        step, mean = tangent / reach, 1.5 * curvature
        for sign, limit in ((1.0, limits[cells, 1]), (-1.0, -limits[cells, 0])):
            blocks.append((sign * third[cells], sign * (mean - step), sign * (mean + step), limit))
    return _JerkRows(*(np.concatenate([block[k] for block in blocks], axis=1) for k in range(4)))


class _JerkProblem:
    """The convexified problem on one grid, compiled once; only the tangents change from round to round."""

    def __init__(self, task: TrajectoryTask, grid: PathGrid, rows: PathRows) -> None:
        self.grid, self.rows = grid, rows
        self.jerk = jerk_rows(task, grid)
        self.ends = self._end_bounds(task)
        bounded = np.isfinite(self.jerk.limit).any(axis=0)
        self.jerk = _JerkRows(*(part[:, bounded] for part in vars(self.jerk).values()))

    def _end_bounds(self, task: TrajectoryTask) -> Array:
        """Return the bound on x at the first and the last inner grid point from constant jerk out of rest."""
        if task.boundary.acceleration is None:
            return np.full(2, np.inf)
        limits = task.limits.get("jerk")
        bounds = []
        for cell, tangent in ((0, self.grid.tangent[0, 0]), (-1, self.grid.tangent[-1, 1])):
            room = np.where(tangent > 0, limits[self.grid.gaps[cell], 1], -limits[self.grid.gaps[cell], 0])
            jerk = float(
                np.min(np.where(tangent != 0, room / np.where(tangent != 0, np.abs(tangent), 1.0), np.inf))
            )
            length = float(np.diff(self.grid.s)[cell])
            bounds.append(
                0.25 * jerk**2 * (6.0 * length / jerk) ** (4.0 / 3.0) if np.isfinite(jerk) else np.inf
            )
        return np.array(bounds)

    def ratio(self, x: Array) -> float:
        """Return the largest jerk over its limit, 1 where it just holds; scales with slowing to the power -3."""
        u = np.diff(x) / (2.0 * np.diff(self.grid.s))
        value = (
            self.jerk.by_x * x[1:-1, None] + self.jerk.before * u[:-1, None] + self.jerk.after * u[1:, None]
        )
        ratio = float((value * np.sqrt(x[1:-1, None]) / self.jerk.limit).max())
        ends = np.array([x[1], x[-2]]) / self.ends
        return float(max(ratio, ends.max() ** 1.5))

    def improve(self, x: Array, tolerance: float, deadline: Deadline) -> tuple[Array, str]:
        """Return the last of a falling sequence of timings, in 1/s^2, and why there is none."""
        x = x * self._slowing(x) * (1 - 1e-9)
        unit = float(cell_durations(self.grid.s, x).sum())
        x = x * unit**2
        solve = self._compiled(unit, x)
        duration, longest = 1.0, 0.0
        for _ in range(ROUNDS):
            if longest > deadline.left or deadline.passed:
                break
            begun = deadline.spent
            trial = solve(x)
            longest = max(longest, deadline.spent - begun)
            if trial is None:
                break
            trial = trial * min(self._slowing(trial / unit**2), 1.0)
            new = float(cell_durations(self.grid.s, trial).sum())
            if not new < duration:
                break
            x, gain, duration = trial, 1.0 - new / duration, new
            if gain <= tolerance:
                break
        return x / unit**2, "" if np.isfinite(duration) else "no feasible timing with bounded jerk was found"

    def _slowing(self, x: Array) -> float:
        """Return the factor on x that makes every limit hold: 1 / time^2."""
        u = np.diff(x) / (2.0 * np.diff(self.grid.s))
        low, high = 0.0, 1.0
        while self._holds(high, u, x):
            low, high = high, 4.0 * high
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._holds(middle, u, x) else (low, middle)
        return low

    def _holds(self, factor: float, u: Array, x: Array) -> bool:
        within = bool((factor * x <= self.rows.largest_x).all())
        rows = self.rows.by_u.shape[2] == 0 or float(self.rows.ratios(factor * u, factor * x).max()) <= 1.0
        return within and rows and self.ratio(factor * x) <= 1.0

    def _compiled(self, unit: float, first: Array) -> Callable[[Array], Array | None]:
        """Return the function from one profile to the next, in units of `unit` seconds.

        Unknowns are shares of the first profile, so that all numbers are of order one: near a rest x falls with the
        power 4/3 of the distance.
        """
        cp: Any = import_module("cvxpy")  # its own annotations are incomplete

        count = len(self.grid.gaps)
        width = np.diff(self.grid.s)
        size = np.where(first > 0, first, 1.0)
        root = np.where(first > 0, np.sqrt(first), 0.0)
        y, c, d = cp.Variable(count + 1), cp.Variable(count + 1), cp.Variable(count)
        x = cp.multiply(first, y)
        u = cp.multiply(x[1:] - x[:-1], 0.5 / width)
        pace = root[:-1] + root[1:]
        share = cp.multiply(root[:-1] / pace, c[:-1]) + cp.multiply(root[1:] / pace, c[1:])
        scaled = scale_rows(self.rows, unit)
        largest = np.minimum(scaled.largest_x, 1e6)
        largest[[1, -2]] = np.minimum(largest[[1, -2]], self.ends * unit**2)
        constraints = [
            y[[0, count]] == 0,
            y[1:-1] <= (largest / size)[1:-1],
            cp.SOC(y + 1, cp.vstack([2 * c, y - 1])),
            cp.SOC(d + share, cp.vstack([np.full(count, 2.0), d - share])),
        ]
        for row in range(scaled.bound.shape[1]):
            terms = cp.multiply(scaled.by_u[:, row], u) + cp.multiply(scaled.by_start[:, row], x[:-1])
            constraints.append(terms + cp.multiply(scaled.by_end[:, row], x[1:]) <= scaled.bound[:, row])
        constant, slope = cp.Parameter(count - 1, nonneg=True), cp.Parameter(count - 1, nonneg=True)
        for row in range(self.jerk.limit.shape[1]):
            limit = self.jerk.limit[:, row] * unit**3
            part = np.where(np.isfinite(limit), root[1:-1] / np.where(np.isfinite(limit), limit, 1.0), 0.0)
            value = cp.multiply(self.jerk.by_x[:, row] * part, x[1:-1])
            value += cp.multiply(self.jerk.before[:, row] * part, u[:-1])
            value += cp.multiply(self.jerk.after[:, row] * part, u[1:])
            constraints.append(value <= constant - cp.multiply(slope, y[1:-1]))
        problem = cp.Problem(cp.Minimize((2.0 * width / pace) @ d), constraints)

        def solve(last: Array) -> Array | None:
            inverse = np.sqrt(first[1:-1] / last[1:-1])
            constant.value, slope.value = 1.5 * inverse, 0.5 * inverse**3
            with warnings.catch_warnings():  # the profile is checked, and scaled to its limits, afterwards
                warnings.filterwarnings("ignore", message="Solution may be inaccurate")
                try:
                    problem.solve(solver=cp.CLARABEL, canon_backend=best_backend())
                except cp.error.SolverError:
                    return None
            return None if y.value is None else np.maximum(np.asarray(y.value), 0.0) * first

        return solve
