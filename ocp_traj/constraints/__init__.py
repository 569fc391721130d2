"""Limits of a motion, one class a file. A new one is a file with a class, and one line here."""

from __future__ import annotations

from ocp_traj.constraints.acceleration import AccelerationLimit
from ocp_traj.constraints.cartesian_speed import CartesianSpeedLimit
from ocp_traj.constraints.constraint import Constraint, DerivativeLimit, SampledConstraint, SymbolicSample
from ocp_traj.constraints.custom import CustomLimit
from ocp_traj.constraints.jerk import JerkLimit
from ocp_traj.constraints.position import PositionLimit
from ocp_traj.constraints.torque import TorqueLimit
from ocp_traj.constraints.torque_rate import TorqueRateLimit
from ocp_traj.constraints.velocity import VelocityLimit

DERIVATIVE_LIMITS: tuple[DerivativeLimit, ...] = (
    PositionLimit(),
    VelocityLimit(),
    AccelerationLimit(),
    JerkLimit(),
)
SAMPLED_CONSTRAINTS: tuple[SampledConstraint, ...] = (
    TorqueLimit(),
    TorqueRateLimit(),
    CartesianSpeedLimit(),
    CustomLimit(),
)

__all__ = [
    "DERIVATIVE_LIMITS",
    "SAMPLED_CONSTRAINTS",
    "Constraint",
    "DerivativeLimit",
    "SampledConstraint",
    "SymbolicSample",
]
