"""Terms of the cost, one idea a file. A new one is a file with a class, and one line here.

The total time is not among them: it is linear in the durations and every transcription adds it itself.
"""

from __future__ import annotations

from ocp_traj.costs.cost import SampledTerm, SquaredDerivative, Term
from ocp_traj.costs.custom import CustomTerms
from ocp_traj.costs.derivatives import SquaredAcceleration, SquaredJerk
from ocp_traj.costs.energy import Energy, EnergyWithoutRegeneration
from ocp_traj.costs.motor_loss import MotorLoss
from ocp_traj.costs.torque import SquaredTorque

SQUARED_DERIVATIVES: tuple[SquaredDerivative, ...] = (SquaredAcceleration(), SquaredJerk())
SAMPLED_TERMS: tuple[SampledTerm, ...] = (
    Energy(),
    EnergyWithoutRegeneration(),
    SquaredTorque(),
    MotorLoss(),
    CustomTerms(),
)

__all__ = ["SAMPLED_TERMS", "SQUARED_DERIVATIVES", "SampledTerm", "SquaredDerivative", "Term"]
