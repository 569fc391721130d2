"""A user's own costs."""

from __future__ import annotations

from typing import Any

import casadi as ca

from ocp_traj.costs.cost import InstantCost
from ocp_traj.instant import Instant
from ocp_traj.task import TrajectoryTask


class CustomCosts(InstantCost):
    """Every `CustomObjective` of a task, already weighted."""

    name = "custom"

    def weight(self, task: TrajectoryTask) -> float:
        """Return 1 when there is any; the costs carry their own weights."""
        return 1.0 if task.objective.custom else 0.0

    def expression(self, instant: Instant) -> Any:
        """Return the weighted integrands."""
        return ca.vertcat(
            *[
                custom.weight * custom.function(*instant.state)
                for custom in instant.task.objective.custom
            ]
        )
