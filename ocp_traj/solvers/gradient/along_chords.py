"""A start for ends that move: speeds along the straight lines between waypoints, faster and slower as limits allow."""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory


def chord_start(task: TrajectoryTask, virtual_knots: int) -> Trajectory | None:
    """Return a cubic Hermite curve through the waypoints with speeds that lead from one end's speed to the other's.

    On the straight line of a gap one speed moves all joints, within velocity and acceleration limits; at waypoints
    its square is bounded by what can be gained from the start and lost until the end. Waypoints and end velocities
    are exact. Limits across the lines are not looked at, so there is a start where a spline path has no timing. None
    where no acceleration limit decides, or a gap has no length.

    Parameters
    ----------
    task : TrajectoryTask
    virtual_knots : int
        Per gap, evenly spaced.
    """
    points = np.asarray(task.waypoints)
    steps = np.diff(points, axis=0)
    ranges = np.ptp(points, axis=0)
    unit = np.where(ranges > 0, ranges, 1.0)
    lengths = np.linalg.norm(steps / unit, axis=1)
    if not (lengths > 0).all():
        return None
    directions = steps / lengths[:, None]
    most = _along(task.limits.get("velocity"), directions)
    gain = _along(task.limits.get("acceleration"), directions)
    if not np.isfinite(gain).all() or not (gain > 0).all() or not (most > 0).all():
        return None
    speeds = _waypoint_speeds(task, directions / unit, unit, lengths, most, gain)
    durations = _gap_durations(lengths, speeds, most, gain)
    velocities = np.zeros_like(points)
    same = directions[1:] * directions[:-1] > 0  # a joint that turns at a waypoint rests there
    velocities[1:-1] = np.where(same, speeds[1:-1, None] * 0.5 * (directions[1:] + directions[:-1]), 0.0)
    velocities[[0, -1]] = task.boundary.velocity
    times = np.concatenate([[0.0], np.cumsum(durations)])
    curve = hermite_curve(task, times, points, velocities, times)
    if not virtual_knots:
        return curve
    per_gap = virtual_knots + 1
    knots = np.append((times[:-1, None] + durations[:, None] * np.arange(per_gap) / per_gap).ravel(), times[-1])
    q = np.array(curve(knots))
    q[::per_gap] = points
    return hermite_curve(task, knots, q, curve(knots, 1), knots[::per_gap])


def _along(limits: Array, directions: Array) -> Array:
    """Return the largest value along each gap's line that keeps the smaller side of every joint's limit, (G,)."""
    both = np.minimum(-limits[:, 0], limits[:, 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = both / np.abs(directions)
    return np.asarray(np.where(np.isnan(ratio), np.inf, ratio).min(axis=1))


def _waypoint_speeds(
    task: TrajectoryTask, shape: Array, unit: Array, lengths: Array, most: Array, gain: Array
) -> Array:
    """Return the speed along the line at every waypoint, (K,): a pass forwards and one backwards.

    `shape` are the lines' directions in units of the joints' ranges; a corner lets pass the cosine of its angle.
    """
    size = np.linalg.norm(shape, axis=1)
    corner = np.clip((shape[1:] * shape[:-1]).sum(axis=1) / (size[1:] * size[:-1]), 0.0, 1.0)
    cap = np.concatenate([most[:1], np.minimum(most[1:], most[:-1]) * corner, most[-1:]])
    ends = np.asarray(task.boundary.velocity) / unit
    for side in (0, -1):
        cap[side] = min(cap[side], max(float(ends[side] @ shape[side]) / size[side] ** 2, 0.0))
    square = np.minimum(cap, 1e150) ** 2
    for k in range(len(lengths)):
        square[k + 1] = min(square[k + 1], square[k] + 2 * gain[k] * lengths[k])
    for k in reversed(range(len(lengths))):
        square[k] = min(square[k], square[k + 1] + 2 * gain[k] * lengths[k])
    return np.asarray(np.sqrt(square))


def _gap_durations(lengths: Array, speeds: Array, most: Array, gain: Array) -> Array:
    """Return the time each gap takes: speeding up to a peak or the limit, then slowing down, (G,) s."""
    entry, leaving = speeds[:-1], speeds[1:]
    peak = np.minimum(np.sqrt((entry**2 + leaving**2) / 2 + gain * lengths), most)
    peak = np.maximum(peak, np.maximum(entry, leaving))
    ramps = (2 * peak**2 - entry**2 - leaving**2) / (2 * gain)
    cruise = np.maximum(lengths - ramps, 0.0) / peak
    return np.asarray((2 * peak - entry - leaving) / gain + cruise)


def hermite_curve(task: TrajectoryTask, knots: Array, q: Array, v: Array, waypoint_times: Array) -> Trajectory:
    """Return the cubic Hermite curve through positions and velocities at knots; the acceleration may jump there.

    Parameters
    ----------
    task : TrajectoryTask
        Gives family and name.
    knots : (m + 1,) s
    q, v : (m + 1, n) rad (m), rad/s (m/s)
    waypoint_times : (K,) s
    """
    h = np.diff(knots)[:, None]
    slope = np.diff(q, axis=0) / h
    powers = [q[:-1], v[:-1], (3 * slope - 2 * v[:-1] - v[1:]) / h, (v[:-1] + v[1:] - 2 * slope) / h**2]
    return Trajectory(knots, np.stack(powers, axis=2), waypoint_times, task.family.name, task.name)
