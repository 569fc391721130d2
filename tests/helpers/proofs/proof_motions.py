"""Random tasks with motions that ride on a limit, and their proofs."""

from __future__ import annotations

from typing import Any

import numpy as np

from helpers.random_tasks import random_motion, random_robot, random_task
from ocp_traj.audit import audit
from ocp_traj.task import Boundary, Limits, Objective, TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription import trajectory_from_durations


def kinematic_motion(seed: int) -> tuple[TrajectoryTask, Trajectory]:
    """A task of one to eight joints with kinematic limits, and a motion that rides on one of them."""
    task = random_task(seed)
    task = task.changed(virtual_knots=0) if task.virtual_knots else task
    durations = np.random.default_rng(seed).uniform(0.2, 2.0, task.gaps)
    return task, at_its_limit(task, trajectory_from_durations(task, durations))


def torque_motion(
    seed: int, *, friction: float = 0.0, rate: bool = False, weights: dict[str, float] | None = None
) -> tuple[TrajectoryTask, Trajectory]:
    """A random chain of revolute and prismatic joints, its torques as large as they may be somewhere."""
    robot = random_robot(seed, friction=friction)
    motion = random_motion(seed, robot.n)
    t = np.linspace(0.0, motion.duration, 400)
    q, v, a = (motion(t, order) for order in range(3))
    torque = np.abs(robot.torque(q, v, a)).max(axis=0) + np.abs(robot.torque(q, 0 * v, 0 * a)).max(axis=0)
    limits: dict[str, Any] = {"torque": torque, "velocity": 2.0 * np.abs(v).max(axis=0)}
    limits["acceleration"] = 2.0 * np.abs(a).max(axis=0)
    if rate:
        smooth = robot.torque(q, v, a) - robot.friction.coulomb * np.sign(v)
        limits["torque_rate"] = np.abs(np.diff(smooth, axis=0)).max(axis=0) / (t[1] - t[0])
    points = motion(motion.waypoint_times)
    task = TrajectoryTask(
        points,
        Limits(**limits),
        robot,
        family="quintic",
        boundary=Boundary(acceleration=0.0),
        objective=Objective(time=1.0, **(weights or {})),
        name=f"torque-{seed}",
    )
    return task, at_its_limit(task, motion)


def at_its_limit(task: TrajectoryTask, motion: Trajectory) -> Trajectory:
    """Return the motion slowed or sped up until the judge says that it just keeps the limits."""
    scale = audit(task, motion).smallest_feasible_scale
    assert scale is not None
    return motion.scaled(scale * (1 + 1e-7))
