"""Limits of the joint velocity."""

from __future__ import annotations

from ocp_traj.limits.limit import DerivativeLimit


class VelocityLimit(DerivativeLimit):
    """Lower and upper velocity of every joint."""

    name = "velocity"
    order = 1
