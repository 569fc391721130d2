"""What every timing of a fixed path shares: units of time, reasons for failure, the finished result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.references.timing.path_limits import PathRows, describe
from ocp_traj.references.timing.paths import GeometricPath, PathGrid
from ocp_traj.references.timing.result import ReferenceResult, cell_durations

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask

ACTIVE_RATIO = 0.999
"""A limit counts as active from this share of its value on."""


@dataclass(frozen=True)
class ScaledRows:
    """Rows by_u u + by_start x_i + by_end x_(i+1) <= bound for one-sided use, in a unit of time that suits the path.

    Attributes
    ----------
    by_u, by_start, by_end, bound : (N, r) arrays
        Blocks of m columns: upper and lower limits at the cells' start, then at their end. Each row divided by its
        limit. Rows at a cell's start have by_end = 0 and the other way round.
    largest_x : (N + 1,) array
    unit : float
        Unit of time, s: the motion lasts about one.
    """

    by_u: Array
    by_start: Array
    by_end: Array
    bound: Array
    largest_x: Array
    unit: float


def time_unit(rows: PathRows) -> float:
    """Return a time about as long as the motion, s; infinite where no limit bounds the speed.

    It is what the typical cell would take at full speed, or a whole path of such cells at full acceleration.
    """
    finite = rows.largest_x[(rows.largest_x > 0) & np.isfinite(rows.largest_x)]
    at_speed = 1.0 / np.sqrt(np.median(finite)) if finite.size else 0.0
    span = np.minimum(rows.upper, -rows.lower)
    span = np.where(span > 0, span, np.maximum(rows.upper, -rows.lower))
    share = np.zeros_like(rows.by_u)
    np.divide(np.abs(rows.by_u), span, out=share, where=np.isfinite(span) & (span > 0))
    heaviest = share.max(axis=(1, 2)) if share.size else np.zeros(1)
    at_acceleration = 2.0 * float(np.sqrt(np.median(heaviest)))
    unit = max(at_speed, at_acceleration)
    return float(unit) if unit > 0 else np.inf


def scale_rows(rows: PathRows, unit: float, guess_x: Array | None = None) -> ScaledRows:
    """Return one-sided rows in units of `unit` seconds, each divided by the span of its limits.

    Viscous friction is not linear in x; its sqrt(x) is replaced by the tangent at `guess_x` (in 1/unit^2), which
    lies above it: a torque that friction helps to exceed its limit is overestimated.
    """
    by_u, by_x = rows.by_u / unit**2, rows.by_x / unit**2
    constant = rows.constant
    if rows.by_speed.any() and guess_x is not None:
        ends = np.maximum(np.stack([guess_x[:-1], guess_x[1:]], axis=1)[:, :, None], 1e-6)
        by_x = by_x + rows.by_speed / unit * 0.5 / np.sqrt(ends)
        constant = constant + rows.by_speed / unit * 0.5 * np.sqrt(ends)
    parts: dict[str, list[Array]] = {"u": [], "start": [], "end": [], "bound": []}
    for end in range(2):
        for sign, limit in ((1.0, rows.upper[:, end]), (-1.0, -rows.lower[:, end])):
            room = limit - sign * constant[:, end]
            bounded = np.isfinite(room)
            size = np.where(bounded & (limit > 0), limit, 1.0)
            parts["u"].append(np.where(bounded, sign * by_u[:, end] / size, 0.0))
            at_end = np.where(bounded, sign * by_x[:, end] / size, 0.0)
            parts["start"].append(at_end if end == 0 else np.zeros_like(at_end))
            parts["end"].append(at_end if end == 1 else np.zeros_like(at_end))
            parts["bound"].append(np.where(bounded, room / size, 1.0))
    stacked = {name: np.concatenate(blocks, axis=1) for name, blocks in parts.items()}
    largest_x = rows.largest_x * unit**2
    return ScaledRows(stacked["u"], stacked["start"], stacked["end"], stacked["bound"], largest_x, unit)


def reason_against(task: TrajectoryTask, grid: PathGrid, rows: PathRows, end_x: Array) -> str:
    """Return why no timing of the path can exist, in one sentence, or an empty string.

    Checked are what can be seen without solving: a joint that may not move, a torque that gravity and Coulomb
    friction alone exceed, ends that are faster than a limit, and limits that leave the speed unbounded.
    """
    blocked = np.flatnonzero((rows.largest_x <= 0) & ~grid.stops)
    if blocked.size:
        return (
            f"{rows.x_labels[blocked[0]]}: a limit of 0 where the path needs motion{_where(grid, blocked[0])}"
        )
    still = (rows.constant > rows.upper) | (rows.constant < rows.lower)
    if still.any():
        cell, end, row = np.argwhere(still)[0]
        name, joint = rows.labels[row]
        value = rows.constant[cell, end, row]
        limit = (rows.upper if value > 0 else rows.lower)[cell, end, row]
        return (
            f"{describe(name, joint)}: standing still already needs {value:.6g} N m with a limit of {limit:.6g}"
            f"{_where(grid, cell)}"
        )
    stuck = (rows.lower == 0) & (rows.upper == 0) & (np.abs(rows.by_u) > 0)
    if stuck.any():
        cell, _, row = np.argwhere(stuck)[0]
        return f"{describe(*rows.labels[row])}: a limit of 0 where the path needs motion{_where(grid, cell)}"
    for end, word in ((0, "start"), (-1, "end")):
        if end_x[end] > rows.largest_x[end] * (1 + 1e-9):
            return (
                f"{rows.x_labels[end]}: the given velocity at the {word} is above the limit along this path"
            )
    if not np.isfinite(time_unit(rows)):
        return "no velocity, acceleration or torque limit bounds the speed along this path"
    return ""


def _where(grid: PathGrid, node: int) -> str:
    gap = int(grid.gaps[min(int(node), len(grid.gaps) - 1)]) + 1
    return f", in gap {gap} at {100 * float(grid.s[int(node)]):.4g} % of the path's length"


def failure_at(grid: PathGrid, rows: PathRows, node: int) -> str:
    """Return a sentence on a grid point from which the end cannot be reached within the limits."""
    return (
        f"no speed at which the rest of the path can be driven within the limits exists{_where(grid, node)} "
        f"(the tightest limit on speed there: {rows.x_labels[node]})"
    )


def finished(
    method: str, path: GeometricPath, grid: PathGrid, rows: PathRows, x: Array, **details: Any
) -> ReferenceResult:
    """Return the result for x = sdot^2 (N + 1,) in 1/s^2 on a grid."""
    u = np.diff(x) / (2.0 * np.diff(grid.s))
    durations = cell_durations(grid.s, x)
    times = np.append(0.0, np.cumsum(durations))
    duration = float(times[-1])
    if not np.isfinite(duration):
        node = int(np.flatnonzero(~np.isfinite(durations))[0])
        return ReferenceResult(method, path.name, None, failure_at(grid, rows, node))
    ratios = cell_ratios(grid, rows, u, x)
    worst = ratios.argmax(axis=1)
    names = [describe(*label) for label in rows.labels]
    active = []
    for cell, row in enumerate(worst):
        label = names[row - 2] if row >= 2 else rows.x_labels[cell + row]
        active.append(label if ratios[cell, row] >= ACTIVE_RATIO else "")
    speed = np.sqrt(np.maximum(x, 0.0))
    tangent = np.concatenate([grid.tangent[:, 0], grid.tangent[-1:, 1]])
    details.setdefault("active", tuple(active))
    details.setdefault("multipliers", np.zeros(len(u)))
    return ReferenceResult(
        method,
        path.name,
        duration,
        s=grid.s,
        speed=speed,
        acceleration=u,
        q=grid.q,
        v=tangent * speed[:, None],
        times=times,
        waypoint_times=times[grid.waypoint_nodes],
        largest_ratio=float(ratios.max()),
        **details,
    )


def cell_ratios(grid: PathGrid, rows: PathRows, u: Array, x: Array) -> Array:
    """Return value over limit, (N, 2 + m): the speed limit at a cell's start and end, then every row."""
    speed = np.zeros_like(x)
    np.divide(x, rows.largest_x, out=speed, where=np.isfinite(rows.largest_x) & (rows.largest_x > 0))
    speed = np.sqrt(np.maximum(speed, 0.0))
    return np.concatenate([speed[:-1, None], speed[1:, None], rows.ratios(u, x).max(axis=1)], axis=1)


def nothing_moves(method: str, path: GeometricPath, task: TrajectoryTask) -> ReferenceResult:
    """Return the result for waypoints that are all equal: it takes no time."""
    waypoints = np.asarray(task.waypoints)
    return ReferenceResult(
        method,
        path.name,
        0.0,
        q=waypoints,
        v=np.zeros_like(waypoints),
        waypoint_times=np.zeros(len(waypoints)),
    )
