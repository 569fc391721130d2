"""A user's own limits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.limits.limit import SampledConstraint, SymbolicSample

if TYPE_CHECKING:
    from ocp_traj.task import CustomConstraint, TrajectoryTask


class CustomLimit(SampledConstraint):
    """Every `CustomConstraint` of a task: functions of (q, v, a, tau)."""

    name = "custom"

    def applies(self, task: TrajectoryTask) -> bool:
        """Return whether the task has any."""
        return bool(task.constraints)

    def expression(self, sample: SymbolicSample) -> Any:
        """Return the functions' values, divided by their scales."""
        values = [
            ca.vec(custom.function(sample.q, sample.v, sample.a, torque_or_zero(sample)))
            / custom_scale(custom)
            for custom in sample.task.constraints
        ]
        return ca.vertcat(*values)

    def bounds(self, task: TrajectoryTask) -> Array:
        """Return the bounds of the scaled values."""
        lower, upper = [], []
        for custom in task.constraints:
            size = custom.function.numel_out(0)
            lower.append(np.broadcast_to(custom.lower, (size,)) / custom_scale(custom))
            upper.append(np.broadcast_to(custom.upper, (size,)) / custom_scale(custom))
        return np.tile(np.stack([np.concatenate(lower), np.concatenate(upper)]), (task.gaps, 1, 1))

    def scales(self, task: TrajectoryTask) -> Array:
        """Return ones, (G, k): values and bounds are scaled already."""
        return np.ones((task.gaps, self.bounds(task).shape[2]))


def torque_or_zero(sample: SymbolicSample) -> Any:
    """Return the torques, or zeros for a task without inertia."""
    return sample.tau if sample.task.has_inertia else ca.SX.zeros(sample.task.n)


def custom_scale(custom: CustomConstraint) -> float:
    """Return the scale of a custom constraint: given, or its largest finite bound, or 1."""
    if custom.scale is not None:
        return float(custom.scale)
    bounds = np.abs(np.concatenate([np.ravel(custom.lower), np.ravel(custom.upper)]))
    finite = bounds[np.isfinite(bounds) & (bounds > 0)]
    return float(finite.max()) if finite.size else 1.0
