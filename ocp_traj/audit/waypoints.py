"""When a motion passes the waypoints, if its file does not say."""

from __future__ import annotations

from math import comb

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.audit.motion import Motion, nearest_index
from ocp_traj.audit.numerics.roots import bracketed_root
from ocp_traj.exceptions import InputError
from ocp_traj.task import TrajectoryTask
from ocp_traj.task.preparing import passed_once
from ocp_traj.trajectory import Trajectory

_SAME_TIME = 1e-9
_SAMPLES = 16
_HAIR = 1e-6
_UNCLEAR = "the times at which the trajectory passes the waypoints cannot be told from its shape"


def with_waypoint_times(task: TrajectoryTask, trajectory: Trajectory) -> Trajectory:
    """Return the trajectory with one waypoint time for each of the task's waypoints, all of them breakpoints.

    A trajectory that names only its start and end (sampled motions do) is searched: among the ordered times
    where it comes nearest to each waypoint, those with the smallest sum of squared distances are taken. Equal
    waypoints that follow one another are one point, passed once, unless the duration of their gap is bounded.

    Raises
    ------
    InputError
        The trajectory names another number of waypoints, or they cannot be told apart in time.
    """
    count, named = len(task.waypoints), len(trajectory.waypoint_times)
    if named not in (2, count):
        raise InputError(f"the trajectory passes {named} waypoints, expected {count}")
    times = trajectory.waypoint_times if named == count else _find_all(task, trajectory)
    return _with_breakpoints(trajectory, times)


def _with_breakpoints(trajectory: Trajectory, times: Array) -> Trajectory:
    """Return the same motion with pieces cut at `times`, which become its waypoint times."""
    breakpoints = trajectory.breakpoints
    nearest = breakpoints[nearest_index(breakpoints, times)]
    apart = np.abs(nearest - times) > _SAME_TIME * trajectory.duration
    if not apart.any():
        if np.array_equal(times, trajectory.waypoint_times):
            return trajectory
        return Trajectory(breakpoints, trajectory.coefficients, times, trajectory.family, trajectory.case)
    merged = np.unique(np.concatenate([breakpoints, times[apart]]))
    piece = np.clip(np.searchsorted(breakpoints, merged[:-1], side="right") - 1, 0, len(breakpoints) - 2)
    shift = merged[:-1] - breakpoints[piece]
    old = trajectory.coefficients[piece]
    shifted = np.zeros_like(old)
    for power in range(old.shape[2]):  # Taylor's shift: sum over j >= i of c_j binomial(j, i) shift^(j - i)
        for i in range(power + 1):
            shifted[:, :, i] += old[:, :, power] * (comb(power, i) * shift ** (power - i))[:, None]
    return Trajectory(merged, shifted, times, trajectory.family, trajectory.case)


def _find_all(task: TrajectoryTask, trajectory: Trajectory) -> Array:
    """Return the times at which the waypoints are passed, (K,)."""
    point = np.concatenate([[0], np.cumsum(~passed_once(task))])
    if point[-1] == 0:  # nothing but rest: all of it is one gap, the last
        return np.append(np.full(len(point) - 1, trajectory.breakpoints[0]), trajectory.breakpoints[-1])
    first = np.unique(point, return_index=True)[1]
    found: Array = _find(task.waypoints[first], trajectory)[point]
    return found


def _find(waypoints: Array, trajectory: Trajectory) -> Array:
    """Return the times at which waypoints that differ from their neighbours are passed, (K,)."""
    motion = Motion.of(trajectory)
    inner = (
        trajectory.breakpoints[:-1, None] + motion.durations[:, None] * np.arange(_SAMPLES) / _SAMPLES
    ).ravel()
    grid = np.append(inner, trajectory.breakpoints[-1])
    positions = trajectory(grid)
    best = np.zeros(1)
    found: list[Array] = [grid[:1]]
    previous: list[Array] = []
    for waypoint in waypoints[1:-1]:
        candidates = _nearest_times(trajectory, waypoint, grid, positions)
        if not candidates.size:  # where positions are too large for floating-point numbers
            raise InputError(_UNCLEAR)
        distance = np.square(trajectory(candidates) - waypoint).sum(axis=1)
        cost, before = _cheapest_before(found[-1], best, candidates)
        best = cost + distance
        found.append(candidates)
        previous.append(before)
    _, last = _cheapest_before(found[-1], best, grid[-1:])
    chosen = int(last[0])
    if not np.isfinite(best[chosen]) or found[-1][chosen] >= grid[-1]:
        raise InputError(_UNCLEAR)
    times = [grid[-1]]
    for candidates, before in zip(reversed(found[1:]), reversed(previous), strict=True):
        times.append(candidates[chosen])
        chosen = int(before[chosen])
    return np.array([*times, grid[0]])[::-1]


def _cheapest_before(times: Array, cost: Array, candidates: Array) -> tuple[Array, Array]:
    """Return, for each candidate, the smallest cost of an earlier time (infinite if none) and its index."""
    allowed = np.where(times[None, :] < candidates[:, None], cost[None, :], np.inf)
    index = np.argmin(allowed, axis=1)
    return allowed[np.arange(len(candidates)), index], index


def _nearest_times(trajectory: Trajectory, waypoint: Array, grid: Array, positions: Array) -> Array:
    """Return the times at which the distance to a waypoint has a local minimum, ascending."""
    distance = np.pad(np.square(positions - waypoint).sum(axis=1), 1, constant_values=np.inf)
    index = np.flatnonzero((distance[1:-1] <= distance[:-2]) & (distance[1:-1] <= distance[2:]))

    def slope(t: Array) -> tuple[Array, Array]:
        away, v, a = trajectory(t) - waypoint, trajectory(t, 1), trajectory(t, 2)
        return (away * v).sum(axis=1), (v * v + away * a).sum(axis=1)

    left, right = grid[np.maximum(index - 1, 0)], grid[np.minimum(index + 1, len(grid) - 1)]
    # A hair inside: where the motion rests the slope is nothing but rounding.
    hair = _HAIR * (right - left)
    left, right = left + hair, right - hair
    before, behind = slope(left)[0], slope(right)[0]
    turns = (before < 0) & (behind >= 0)
    times = grid[index].copy()
    times[turns] = bracketed_root(slope, (left[turns], right[turns]), (before[turns], behind[turns]))
    return np.unique(times)
