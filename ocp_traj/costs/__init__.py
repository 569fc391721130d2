"""Costs of a motion, one idea per file. A new one is a file with a class, and one line here.

The total time is not among them: it is linear in the durations and every transcription adds it itself.
"""

from __future__ import annotations

from ocp_traj.costs.cost import Cost, InstantCost
from ocp_traj.costs.custom import CustomCosts
from ocp_traj.costs.derivatives import SQUARED_DERIVATIVES, SquaredDerivative
from ocp_traj.costs.energy import Energy, EnergyWithoutRegeneration
from ocp_traj.costs.motor_loss import MotorLoss
from ocp_traj.costs.torque import SquaredTorque
from ocp_traj.task import TrajectoryTask

INSTANT_COSTS: list[InstantCost] = [
    Energy(),
    EnergyWithoutRegeneration(),
    SquaredTorque(),
    MotorLoss(),
    CustomCosts(),
]
"""The costs integrated from samples."""


def instant_costs(task: TrajectoryTask) -> list[InstantCost]:
    """Return the costs integrated from samples that have weight in a task."""
    return [cost for cost in INSTANT_COSTS if cost.weight(task) > 0]


__all__ = [
    "INSTANT_COSTS",
    "SQUARED_DERIVATIVES",
    "Cost",
    "InstantCost",
    "SquaredDerivative",
]
