"""Limits of a motion, one class a file. A new one is a file with a class, and one line here."""

from __future__ import annotations

from ocp_traj.limits.acceleration import AccelerationLimit
from ocp_traj.limits.cartesian_speed import CartesianSpeedLimit
from ocp_traj.limits.custom import CustomLimit
from ocp_traj.limits.jerk import JerkLimit
from ocp_traj.limits.limit import Constraint, DerivativeLimit, SampledConstraint, SymbolicSample
from ocp_traj.limits.position import PositionLimit
from ocp_traj.limits.torque import TorqueLimit
from ocp_traj.limits.torque_rate import TorqueRateLimit
from ocp_traj.limits.velocity import VelocityLimit

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
