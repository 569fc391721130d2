"""Limits of the Cartesian speed of named frames."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.instant import Instant
from ocp_traj.limits.limit import InstantLimit
from ocp_traj.quantities import SpeedLaw
from ocp_traj.task import TrajectoryTask


class CartesianSpeedLimit(InstantLimit):
    """Norm of a frame's linear velocity, imposed as its square (smooth at rest), m^2/s^2."""

    name = "cartesian_speed"

    def applies(self, task: TrajectoryTask) -> bool:
        """Return whether any frame has a speed limit."""
        return bool(task.limits.cartesian_speed)

    def expression(self, instant: Instant) -> Any:
        """Return the squared speed of every limited frame."""
        robot = instant.task.robot
        assert robot is not None
        speeds = [
            robot.symbolic.velocity(frame)(instant.q, instant.v)
            for frame, _ in instant.task.limits.cartesian_speed
        ]
        return ca.vertcat(*[ca.dot(speed, speed) for speed in speeds])

    def bounds(self, task: TrajectoryTask) -> Array:
        """Return minus infinity and the squared limits."""
        upper = np.array([speed**2 for _, speed in task.limits.cartesian_speed])
        return np.tile(np.stack([np.full_like(upper, -np.inf), upper]), (task.gaps, 1, 1))

    def scaling(self, task: TrajectoryTask) -> SpeedLaw:
        """Return that the squared speed goes with the square of the uniform speed."""
        return SpeedLaw(speed=2)
