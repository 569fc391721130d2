"""Maximum velocity curves: how fast a path can be driven at most at each of its points, by kind of limit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.arrays import Array, read_only
from ocp_traj.exceptions import InputError
from ocp_traj.references.timing.path_limits import PathRows, path_rows
from ocp_traj.references.timing.paths import geometric_path, sample_path
from ocp_traj.references.timing.timing import time_unit

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

_CEILING = 1e8
"""Squared speed, in units of the time the motion takes, above which a point counts as unlimited."""


@dataclass(frozen=True)
class LimitCurves:
    """Largest path speed sdot by each kind of limit.

    Attributes
    ----------
    s : (N + 1,) array
        Grid over the path's arc length, scaled to [0, 1].
    velocity : (N + 1,) array
        1/s, from velocity and Cartesian speed limits; 0 at corners, infinite where nothing limits.
    by_kind : dict of str to (N + 1,) array
        1/s: the speed above which no sddot whatever keeps all ``"acceleration"``, or all ``"torque"`` limits.
    waypoints : (K,) array
        s of the waypoints.
    """

    s: Array
    velocity: Array
    by_kind: dict[str, Array]
    waypoints: Array

    def __post_init__(self) -> None:
        for name in ("s", "velocity", "waypoints"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        object.__setattr__(self, "by_kind", {kind: read_only(curve) for kind, curve in self.by_kind.items()})


def limit_curves(task: TrajectoryTask, path: str | Trajectory = "chord", *, points: int = 400) -> LimitCurves:
    """Return the maximum velocity curves of a path (Bobrow, Dubowsky and Gibson 1985, without their switching curve).

    Parameters
    ----------
    task : TrajectoryTask
    path : ``"uniform"``, ``"chord"`` or a Trajectory
        See `geometric_path`.
    points : int
        Number of cells.

    Raises
    ------
    InputError
        The path is unknown, or nothing moves along it.
    """
    curve = geometric_path(task, path)
    if curve.curve is None:
        raise InputError("nothing moves along the path, so it has no phase plane")
    grid = sample_path(curve, points)
    rows = path_rows(task, grid)
    kinds = dict.fromkeys(name for name, _ in rows.labels)
    found = {kind: np.sqrt(_largest_x(rows, [name == kind for name, _ in rows.labels])) for kind in kinds}
    return LimitCurves(grid.s, np.sqrt(rows.largest_x), found, grid.s[grid.waypoint_nodes])


def _largest_x(rows: PathRows, chosen: list[bool]) -> Array:
    """Return the largest x (N + 1,) at which the chosen rows leave a u, by bisection at both sides of every point."""
    unit = time_unit(rows)
    ceiling = _CEILING / unit**2 if np.isfinite(unit) else _CEILING
    parts = [part[:, :, chosen] for part in (rows.by_u, rows.by_x, rows.by_speed, rows.constant)]
    lower, upper = rows.lower[:, :, chosen], rows.upper[:, :, chosen]
    low = np.zeros(parts[0].shape[:2])
    high = np.full(low.shape, ceiling)
    unlimited = _some_u(parts, lower, upper, high)
    for _ in range(80):
        middle = 0.5 * (low + high)
        possible = _some_u(parts, lower, upper, middle)
        low, high = np.where(possible, middle, low), np.where(possible, high, middle)
    found = np.where(unlimited, np.inf, low)
    nodes = np.full(len(found) + 1, np.inf)
    nodes[:-1] = found[:, 0]
    nodes[1:] = np.minimum(nodes[1:], found[:, 1])
    return nodes


def _some_u(parts: list[Array], lower: Array, upper: Array, x: Array) -> Array:
    """Return whether some u keeps the rows at x, (N, 2)."""
    by_u, by_x, by_speed, constant = parts
    value = by_x * x[:, :, None] + by_speed * np.sqrt(x)[:, :, None] + constant
    moving = np.abs(by_u) > 0
    factor = np.where(moving, by_u, 1.0)
    ends = ((lower - value) / factor, (upper - value) / factor)
    least = np.where(moving, np.minimum(*ends), -np.inf).max(axis=2)
    most = np.where(moving, np.maximum(*ends), np.inf).min(axis=2)
    kept = np.where(moving, True, (value >= lower) & (value <= upper)).all(axis=2)
    return np.asarray((least <= most) & kept)
