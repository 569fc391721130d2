"""Limits of the joint jerk."""

from __future__ import annotations

from ocp_traj.limits.limit import DerivativeLimit


class JerkLimit(DerivativeLimit):
    """Lower and upper jerk of every joint."""

    name = "jerk"
    order = 3
