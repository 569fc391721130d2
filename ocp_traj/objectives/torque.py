"""Effort: integral of squared torque over squared torque limit."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from ocp_traj.constraints.constraint import SymbolicSample
from ocp_traj.objectives.objective import SampledTerm


class SquaredTorque(SampledTerm):
    """Integral of sum (tau_i / limit_i)^2 dt; a joint without torque limit counts with 1 N m."""

    name = "torque"

    def expression(self, sample: SymbolicSample) -> Any:
        """Return the squared ratios."""
        limits = np.abs(sample.task.limits.get("torque")).max(axis=(0, 1))
        scale = np.where(np.isfinite(limits) & (limits > 0), limits, 1.0)
        return (sample.tau / ca.DM(scale)) ** 2
