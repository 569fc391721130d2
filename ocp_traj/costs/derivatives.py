"""Smoothness: integrals of squared acceleration and of squared jerk."""

from __future__ import annotations

from ocp_traj.costs.cost import SquaredDerivative


class SquaredAcceleration(SquaredDerivative):
    """Integral of sum a^2 dt."""

    name = "acceleration"
    order = 2


class SquaredJerk(SquaredDerivative):
    """Integral of sum jerk^2 dt."""

    name = "jerk"
    order = 3
