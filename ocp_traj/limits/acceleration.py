"""Limits of the joint acceleration."""

from __future__ import annotations

from ocp_traj.limits.limit import DerivativeLimit


class AccelerationLimit(DerivativeLimit):
    """Lower and upper acceleration of every joint."""

    name = "acceleration"
    order = 2
