"""Mechanical energy, with and without what braking could give back."""

from __future__ import annotations

from typing import Any

from ocp_traj.costs.cost import SampledTerm
from ocp_traj.limits.limit import SymbolicSample


class Energy(SampledTerm):
    """Integral of sum |tau qdot| dt, J (paper A; its printed formula is lost, the absolute value is our reading)."""

    name = "energy"
    shape = "absolute"

    def expression(self, sample: SymbolicSample) -> Any:
        """Return the power of every joint, W."""
        return sample.tau * sample.v


class EnergyWithoutRegeneration(SampledTerm):
    """Integral of sum max(tau qdot, 0) dt, J: braking costs nothing and gives nothing back."""

    name = "energy_without_regeneration"
    shape = "positive"

    def expression(self, sample: SymbolicSample) -> Any:
        """Return the power of every joint, W."""
        return sample.tau * sample.v
