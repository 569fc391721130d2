"""Effort: integral of squared torque over squared torque limit."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.costs.cost import InstantCost
from ocp_traj.instant import Instant
from ocp_traj.quantities import SpeedLaw
from ocp_traj.task import TrajectoryTask


class SquaredTorque(InstantCost):
    """Integral of sum (tau_i / limit_i)^2 dt; a joint without torque limit counts with 1 N m."""

    name = "torque"

    def expression(self, instant: Instant) -> Any:
        """Return the squared ratios."""
        return (instant.tau / ca.DM(torque_scales(instant.task))) ** 2

    def scaling(self, task: TrajectoryTask) -> SpeedLaw:
        """Return that the integrand is a sum of squared torques."""
        return SpeedLaw(torque=2, factors=torque_scales(task) ** -2.0)


def torque_scales(task: TrajectoryTask) -> Array:
    """Return the torque limit of every joint, N m; 1 where there is none."""
    limits = np.abs(task.limits.get("torque")).max(axis=(0, 1))
    return np.where(np.isfinite(limits) & (limits > 0), limits, 1.0)
