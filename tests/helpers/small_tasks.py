"""Small tasks for the tests of solvers: two bare joints, and a UR5 between postures with a bent elbow."""

from __future__ import annotations

from typing import Any

import numpy as np

from ocp_traj.robot import load_robot
from ocp_traj.task import Limits, TrajectoryTask

POINTS = [[0.0, 0.0], [1.0, 0.5], [0.5, 1.0]]

ARM_POINTS = np.deg2rad(
    [
        [0, -90, 90, -90, -90, 0],
        [45, -70, 80, -100, -90, 45],
        [60, -10, 20, -90, -90, 60],
        [90, -90, 90, -90, -90, 90],
    ]
)
"""In the third the arm is nearly stretched out."""


def plain_task(**changes: Any) -> TrajectoryTask:
    """Return a task of two joints without a robot, and without virtual knots unless they are given."""
    return TrajectoryTask(POINTS, Limits(velocity=2.0, acceleration=4.0), **{"virtual_knots": 0, **changes})


def arm_task(points: Any = ARM_POINTS, **changes: Any) -> TrajectoryTask:
    """Return a task of the UR5; `limits` are added to those of velocity and acceleration."""
    limits = {"velocity": 2.1, "acceleration": 5.2, **changes.pop("limits", {})}
    return TrajectoryTask(points, Limits(**limits), **{"robot": load_robot("ur5"), "virtual_knots": 0, **changes})
