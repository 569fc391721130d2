"""Ruckig: the exact optimum of a two-point motion with bounded velocity, acceleration and jerk."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import PPoly

from helpers.peers.answer import PeerAnswer, from_piecewise, least_cpu_time, symmetric_limit
from ocp_traj.task import Boundary, Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory


def random_two_point_task(
    rng: np.random.Generator, n: int, *, moving: bool = False, virtual_knots: int
) -> TrajectoryTask:
    """Return a random two-point task: limits over a decade and more, optionally with ends that move."""
    waypoints = rng.uniform(-np.pi, np.pi, (2, n))
    velocity = 10.0 ** rng.uniform(-0.5, 0.5, n)
    acceleration = velocity * 10.0 ** rng.uniform(-0.5, 1.0, n)
    jerk = acceleration * 10.0 ** rng.uniform(-0.5, 1.0, n)
    boundary = Boundary(acceleration=0.0)
    if moving:
        boundary = _moving_ends(rng, velocity, acceleration, jerk)
    limits = Limits(velocity=velocity, acceleration=acceleration, jerk=jerk)
    return TrajectoryTask(
        waypoints, limits, boundary=boundary, virtual_knots=virtual_knots, name="two-points"
    )


def _moving_ends(
    rng: np.random.Generator, velocity: np.ndarray, acceleration: np.ndarray, jerk: np.ndarray
) -> Boundary:
    """Return random end states from which (and towards which) the velocity limit can be kept."""
    while True:
        v = 0.7 * velocity * rng.uniform(-1.0, 1.0, (2, len(velocity)))
        a = 0.7 * acceleration * rng.uniform(-1.0, 1.0, (2, len(velocity)))
        if (np.abs(v) + a**2 / (2.0 * jerk) <= velocity).all():
            return Boundary(velocity=v, acceleration=a)


def solve_with_ruckig(task: TrajectoryTask, *, repeats: int = 1) -> PeerAnswer:
    """Return Ruckig's motion, synchronised in time."""
    found, seconds = least_cpu_time(lambda: _calculate(task), repeats)
    if isinstance(found, str):
        return PeerAnswer("Ruckig", "two points", None, seconds, found)
    return PeerAnswer("Ruckig", "two points", _exact_motion(found, task.n), seconds)


def _calculate(task: TrajectoryTask) -> Any:
    import ruckig

    given = ruckig.InputParameter(task.n)
    given.current_position, given.target_position = (list(row) for row in np.asarray(task.waypoints))
    velocity, acceleration = task.boundary.velocity, task.boundary.acceleration
    given.current_velocity, given.target_velocity = (list(row) for row in np.asarray(velocity))
    given.current_acceleration, given.target_acceleration = (list(row) for row in np.asarray(acceleration))
    given.max_velocity = list(symmetric_limit(task, "velocity"))
    given.max_acceleration = list(symmetric_limit(task, "acceleration"))
    given.max_jerk = list(symmetric_limit(task, "jerk"))
    trajectory = ruckig.Trajectory(task.n)
    result = ruckig.Ruckig(task.n).calculate(given, trajectory)
    return trajectory if result == ruckig.Result.Working else str(result)


def _exact_motion(trajectory: Any, n: int) -> Trajectory:
    """Return the cubic with breaks wherever a joint's jerk changes."""
    breaks = {0.0, trajectory.duration}
    for joint in trajectory.profiles[0]:
        spans = [*joint.brake.t, *joint.t, *joint.accel.t]
        breaks |= set(np.cumsum(spans))
    t = np.array(sorted(time for time in breaks if time <= trajectory.duration))
    t = t[np.concatenate([[True], np.diff(t) > 1e-12 * trajectory.duration])]
    t[-1] = trajectory.duration
    states = np.array([trajectory.at_time(time)[:3] for time in t])  # (N, 3, n)
    spans = np.diff(t)[:, None]
    jerk = np.diff(states[:, 2], axis=0) / spans
    start = states[:-1]
    pieces = PPoly(np.stack([jerk / 6.0, start[:, 2] / 2.0, start[:, 1], start[:, 0]]), t)
    return from_piecewise(pieces, t[[0, -1]], "cubic")
