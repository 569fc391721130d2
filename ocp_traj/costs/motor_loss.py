"""Copper loss of DC motors behind the joints."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.costs.cost import InstantCost
from ocp_traj.instant import Instant
from ocp_traj.quantities import SpeedLaw
from ocp_traj.task import Motor, TrajectoryTask


class MotorLoss(InstantCost):
    """Integral of sum R_i (tau_i / (N_i k_i))^2 dt, J; friction enters through the torque."""

    name = "motor_loss"

    def expression(self, instant: Instant) -> Any:
        """Return the loss of every motor, W."""
        return ca.DM(self.scaling(instant.task).factors) * instant.tau**2

    def scaling(self, task: TrajectoryTask) -> SpeedLaw:
        """Return that the integrand is a sum of squared torques."""
        assert task.objective.motor is not None
        return SpeedLaw(torque=2, factors=loss_factors(task.objective.motor, task.n))


def loss_factors(motor: Motor, n: int) -> Array:
    """Return R / (N k)^2 of every joint, W/(N m)^2."""
    torque_constant, resistance, gear = (
        np.broadcast_to(np.asarray(value, dtype=np.float64), (n,))
        for value in (motor.torque_constant, motor.resistance, motor.gear_ratio)
    )
    return resistance / (gear * torque_constant) ** 2
