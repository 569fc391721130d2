"""A user's own limits."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.instant import Instant
from ocp_traj.limits.limit import InstantLimit
from ocp_traj.task import CustomConstraint, TrajectoryTask


class CustomLimit(InstantLimit):
    """Every `CustomConstraint` of a task: functions of (q, v, a, tau)."""

    name = "custom"

    def applies(self, task: TrajectoryTask) -> bool:
        """Return whether the task has any."""
        return bool(task.constraints)

    def expression(self, instant: Instant) -> Any:
        """Return the functions' values, divided by their scales."""
        values = [
            ca.vec(custom.function(*instant.state)) / custom_scale(custom)
            for custom in instant.task.constraints
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


def custom_scale(custom: CustomConstraint) -> float:
    """Return the scale of a custom constraint: given, or its largest finite bound, or 1."""
    if custom.scale is not None:
        return float(custom.scale)
    bounds = np.abs(np.concatenate([np.ravel(custom.lower), np.ravel(custom.upper)]))
    finite = bounds[np.isfinite(bounds) & (bounds > 0)]
    return float(finite.max()) if finite.size else 1.0
