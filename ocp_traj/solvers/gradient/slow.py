"""Slow motions in closed form: something feasible for every task from rest to rest that time alone makes possible."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.audit import audit
from ocp_traj.solvers.gradient.starts import centripetal_durations
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.curve import build_trajectory
from ocp_traj.transcription.guess import initial_guess

ROUNDING = 1e-9
"""Slowing beyond the least one, relative."""


def slow_motion(task: TrajectoryTask) -> Trajectory | None:
    """Return a feasible motion made without a solver, the shortest of a few; None where none of them is feasible.

    Velocity, acceleration and jerk vanish as time grows, and of the torque only gravity is left: a spline through the
    waypoints, slowed uniformly, keeps all of them. What slowing cannot mend is a position limit that the spline
    crosses (splines that stop at the waypoints cross least), an end that moves, or too little time.

    Parameters
    ----------
    task : TrajectoryTask
    """
    if not task.boundary.is_rest:
        return None
    best: Trajectory | None = None
    for motion in _shapes(task):
        scale = audit(task, motion).smallest_feasible_scale
        if scale is None or not np.isfinite(scale):
            continue
        slower = motion.scaled(max(scale, np.finfo(float).tiny) * (1.0 + ROUNDING))
        longer = best is not None and slower.duration >= best.duration
        if not longer and audit(task, slower).feasible:
            best = slower
    return best


def _shapes(task: TrajectoryTask) -> Iterator[Trajectory]:
    """Yield splines of the task's family that keep its end conditions, each with other durations."""
    fits = task.family.takes_virtual_knots
    for durations in (None, centripetal_durations(task), np.ones(task.gaps)):
        guess = initial_guess(task, durations)
        if not (fits and task.virtual_knots):
            yield guess
            continue
        times = np.asarray(guess.waypoint_times)
        share = np.diff(times) / (task.virtual_knots + 1)
        knots = np.concatenate([[0.0], np.cumsum(np.repeat(share, task.virtual_knots + 1))])
        yield build_trajectory(task, np.diff(knots), _at_waypoints(task, guess(knots)))
        yield build_trajectory(task, np.diff(knots), _stopping(task))


def _at_waypoints(task: TrajectoryTask, positions: Array) -> Array:
    exact = np.array(positions)
    exact[:: task.virtual_knots + 1] = task.waypoints
    return exact


def _stopping(task: TrajectoryTask) -> Array:
    """Return positions at evenly spaced knots of a motion that slows down smoothly at every waypoint."""
    u = np.arange(task.virtual_knots + 1) / (task.virtual_knots + 1)
    travelled = (u**3 * (10.0 - 15.0 * u + 6.0 * u**2))[None, :, None]
    waypoints = np.asarray(task.waypoints)
    inside = waypoints[:-1, None] + travelled * np.diff(waypoints, axis=0)[:, None]
    return np.concatenate([inside.reshape(-1, task.n), waypoints[-1:]])
