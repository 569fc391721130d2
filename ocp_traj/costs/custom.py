"""A user's own cost terms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca

from ocp_traj.costs.cost import SampledTerm
from ocp_traj.limits.custom import torque_or_zero
from ocp_traj.limits.limit import SymbolicSample

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask


class CustomTerms(SampledTerm):
    """Every `CustomObjective` of a task, already weighted."""

    name = "custom"

    def weight(self, task: TrajectoryTask) -> float:
        """Return 1 when there is any; the terms carry their own weights."""
        return 1.0 if task.objective.custom else 0.0

    def expression(self, sample: SymbolicSample) -> Any:
        """Return the weighted integrands."""
        return ca.vertcat(
            *[
                custom.weight * custom.function(sample.q, sample.v, sample.a, torque_or_zero(sample))
                for custom in sample.task.objective.custom
            ]
        )
