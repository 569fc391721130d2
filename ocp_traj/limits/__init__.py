"""Limits of a motion, one idea per file. A new one is a file with a class, and one line here."""

from __future__ import annotations

from ocp_traj.limits.cartesian_speed import CartesianSpeedLimit
from ocp_traj.limits.custom import CustomLimit
from ocp_traj.limits.derivatives import DERIVATIVE_LIMITS, DerivativeLimit
from ocp_traj.limits.limit import InstantLimit, JointLimit, Limit
from ocp_traj.limits.torque import TorqueLimit
from ocp_traj.limits.torque_rate import TorqueRateLimit
from ocp_traj.task import TrajectoryTask

INSTANT_LIMITS: list[InstantLimit] = [
    TorqueLimit(),
    TorqueRateLimit(),
    CartesianSpeedLimit(),
    CustomLimit(),
]
"""The limits imposed at samples, in the order of their rows."""


def instant_limits(task: TrajectoryTask) -> list[InstantLimit]:
    """Return the limits of an instant that a task has."""
    return [limit for limit in INSTANT_LIMITS if limit.applies(task)]


__all__ = [
    "DERIVATIVE_LIMITS",
    "INSTANT_LIMITS",
    "DerivativeLimit",
    "InstantLimit",
    "JointLimit",
    "Limit",
]
