"""Copper loss of DC motors behind the joints."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.costs.cost import SampledTerm
from ocp_traj.limits.limit import SymbolicSample

if TYPE_CHECKING:
    from ocp_traj.task import Motor


class MotorLoss(SampledTerm):
    """Integral of sum R_i (tau_i / (N_i k_i))^2 dt, J; friction enters through the torque."""

    name = "motor_loss"

    def expression(self, sample: SymbolicSample) -> Any:
        """Return the loss of every motor, W."""
        motor = sample.task.objective.motor
        assert motor is not None
        return ca.DM(loss_factors(motor, sample.task.n)) * sample.tau**2


def loss_factors(motor: Motor, n: int) -> Array:
    """Return R / (N k)^2 of every joint, W/(N m)^2."""
    torque_constant, resistance, gear = (
        np.broadcast_to(np.asarray(value, dtype=np.float64), (n,))
        for value in (motor.torque_constant, motor.resistance, motor.gear_ratio)
    )
    return resistance / (gear * torque_constant) ** 2
