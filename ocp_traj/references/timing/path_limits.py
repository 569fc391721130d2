"""A task's limits along a sampled path, as rows in the path speed and acceleration.

With path coordinate s(t), x = sdot^2 and u = sddot, velocity is q' sdot, acceleration q' u + q'' x, and torque
(M q') u + (M q'' + C(q, q') q') x + g + viscous q' sqrt(x) + coulomb sign(q') (Verscheure et al. 2009, Eqs. 7 to
10, with viscous friction added). In every cell u is constant, so x is linear in s; each row holds at both ends of
its cell. Velocity and Cartesian speed only bound x.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.references.timing.paths import PathGrid

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask


@dataclass(frozen=True)
class PathRows:
    """Rows lower <= by_u u + by_x x + by_speed sqrt(x) + constant <= upper, at both ends of every cell.

    Attributes
    ----------
    by_u, by_x, by_speed, constant, lower, upper : (N, 2, m) arrays
        At the start [.., 0, ..] and the end [.., 1, ..] of each cell.
    largest_x : (N + 1,) array
        Bound on x from velocity and Cartesian speed; 0 at corners.
    labels : tuple of m (limit, joint) pairs
        Joints from 0.
    x_labels : tuple of N + 1 str
        The limit behind `largest_x`.
    """

    by_u: Array
    by_x: Array
    by_speed: Array
    constant: Array
    lower: Array
    upper: Array
    largest_x: Array
    labels: tuple[tuple[str, int], ...]
    x_labels: tuple[str, ...]

    def values(self, u: Array, x: Array) -> Array:
        """Return the limited quantities (N, 2, m) for u (N,) and x (N + 1,)."""
        ends = np.stack([x[:-1], x[1:]], axis=1)[:, :, None]
        speed = np.sqrt(np.maximum(ends, 0.0))
        return self.by_u * u[:, None, None] + self.by_x * ends + self.by_speed * speed + self.constant

    def ratios(self, u: Array, x: Array) -> Array:
        """Return value over limit, (N, 2, m), each on its own side; 0 for a value and a limit of 0."""
        values = self.values(u, x)
        bounds = np.where(values < 0, self.lower, self.upper)
        ratio = np.zeros_like(values)
        np.divide(values, bounds, out=ratio, where=values != 0)
        return ratio


def describe(limit: str, joint: int) -> str:
    """Return the words for a limit, joints counted from 1."""
    return f"{limit}, joint {joint + 1}"


def path_rows(task: TrajectoryTask, grid: PathGrid) -> PathRows:
    """Return the rows of the task's velocity, acceleration, torque and Cartesian speed limits on a grid.

    Position, jerk and torque-rate limits have no place here: the path fixes the first, the others are not convex.
    """
    blocks = [_acceleration_rows(task, grid)]
    names = ["acceleration"]
    if task.has_inertia and task.limited("torque"):
        blocks.append(_torque_rows(task, grid))
        names.append("torque")
    parts = [np.concatenate([block[index] for block in blocks], axis=2) for index in range(6)]
    labels = [(name, joint) for name in names for joint in range(task.n)]
    limited = np.isfinite(parts[4]).any(axis=(0, 1)) | np.isfinite(parts[5]).any(axis=(0, 1))
    largest_x, x_labels = _speed_bounds(task, grid)
    return PathRows(
        by_u=parts[0][:, :, limited],
        by_x=parts[1][:, :, limited],
        by_speed=parts[2][:, :, limited],
        constant=parts[3][:, :, limited],
        lower=parts[4][:, :, limited],
        upper=parts[5][:, :, limited],
        largest_x=largest_x,
        labels=tuple(label for label, kept in zip(labels, limited) if kept),
        x_labels=x_labels,
    )


def _cell_limits(task: TrajectoryTask, name: str, grid: PathGrid) -> tuple[Array, Array]:
    """Return the lower and the upper limit at both ends of every cell, (N, 2, n) each."""
    limits = task.limits.get(name)[grid.gaps]
    return tuple(np.repeat(limits[:, None, side], 2, axis=1) for side in range(2))  # type: ignore[return-value]


def _acceleration_rows(task: TrajectoryTask, grid: PathGrid) -> tuple[Array, ...]:
    lower, upper = _cell_limits(task, "acceleration", grid)
    nothing = np.zeros_like(grid.tangent)
    return grid.tangent, grid.curvature, nothing, nothing, lower, upper


def _torque_rows(task: TrajectoryTask, grid: PathGrid) -> tuple[Array, ...]:
    robot = task.robot
    assert robot is not None  # `has_inertia` says so
    shape = grid.tangent.shape
    q = np.stack([grid.q[:-1], grid.q[1:]], axis=1).reshape(-1, task.n)
    tangent, curvature = grid.tangent.reshape(q.shape), grid.curvature.reshape(q.shape)
    nothing = np.zeros_like(q)
    gravity = robot.batch.torque(q, nothing, nothing)
    friction = robot.friction.viscous * tangent + robot.friction.coulomb * np.sign(tangent)
    by_u = robot.batch.torque(q, nothing, tangent) - gravity
    by_x = robot.batch.torque(q, tangent, curvature) - gravity - friction
    direction = np.repeat(np.sign(grid.middle_tangent)[:, None, :], 2, axis=1)  # no reversal inside a cell
    constant = gravity.reshape(shape) + robot.friction.coulomb * direction
    lower, upper = _cell_limits(task, "torque", grid)
    by_speed = (robot.friction.viscous * tangent).reshape(shape)
    return by_u.reshape(shape), by_x.reshape(shape), by_speed, constant, lower, upper


def _speed_bounds(task: TrajectoryTask, grid: PathGrid) -> tuple[Array, tuple[str, ...]]:
    """Return the bound on x at every grid point and the name of the limit behind it."""
    lower, upper = _cell_limits(task, "velocity", grid)
    bounds = _square_speed(grid.tangent, np.where(grid.tangent < 0, -lower, upper))
    names = [describe("velocity", joint) for joint in range(task.n)]
    for frame, speed in task.limits.cartesian_speed:
        motion = np.linalg.norm(_frame_velocities(task, grid, frame), axis=2, keepdims=True)
        bounds = np.concatenate([bounds, _square_speed(motion, np.full(motion.shape, speed))], axis=2)
        names.append(f"speed of frame {frame}")
    nodes = np.full((len(grid.s), bounds.shape[2]), np.inf)
    nodes[:-1] = bounds[:, 0]
    nodes[1:] = np.minimum(nodes[1:], bounds[:, 1])
    largest = nodes.min(axis=1)
    labels = [names[index] for index in nodes.argmin(axis=1)]
    for node in np.flatnonzero(grid.stops):
        labels[node] = "corner"
    return np.where(grid.stops, 0.0, largest), tuple(labels)


def _square_speed(motion: Array, limit: Array) -> Array:
    """Return the largest x for motion sqrt(x) <= limit, elementwise; infinite where nothing moves."""
    size = np.abs(motion)
    speed = np.full_like(size, np.inf)
    np.divide(limit, size, out=speed, where=size > 1e-12 * max(size.max(), 1e-300))
    return np.asarray(speed**2)


def _frame_velocities(task: TrajectoryTask, grid: PathGrid, frame: str) -> Array:
    """Return the frame's velocity by s, (N, 2, 3) in m, at both ends of every cell."""
    robot = task.robot
    assert robot is not None  # a frame's limit needs a robot
    q = np.stack([grid.q[:-1], grid.q[1:]], axis=1).reshape(-1, task.n)
    function = robot.symbolic.velocity(frame)
    mapped = function.map(len(q))
    velocity = np.asarray(mapped(q.T, grid.tangent.reshape(q.shape).T), dtype=np.float64).T
    return np.asarray(velocity.reshape(len(grid.gaps), 2, 3))
