"""Effort: integral of squared torque over squared torque limit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.costs.cost import SampledTerm
from ocp_traj.limits.limit import SymbolicSample

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask


class SquaredTorque(SampledTerm):
    """Integral of sum (tau_i / limit_i)^2 dt; a joint without torque limit counts with 1 N m."""

    name = "torque"

    def expression(self, sample: SymbolicSample) -> Any:
        """Return the squared ratios."""
        return (sample.tau / ca.DM(torque_scales(sample.task))) ** 2


def torque_scales(task: TrajectoryTask) -> Array:
    """Return the torque limit of every joint, N m; 1 where there is none."""
    limits = np.abs(task.limits.get("torque")).max(axis=(0, 1))
    scales: Array = np.where(np.isfinite(limits) & (limits > 0), limits, 1.0)
    return scales
