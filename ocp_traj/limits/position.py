"""Limits of the joint position."""

from __future__ import annotations

from ocp_traj.limits.limit import DerivativeLimit


class PositionLimit(DerivativeLimit):
    """Lower and upper position of every joint."""

    name = "position"
    order = 0
