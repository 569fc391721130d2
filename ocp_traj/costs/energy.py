"""Mechanical energy, with and without what braking could give back."""

from __future__ import annotations

from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.costs.cost import InstantCost
from ocp_traj.instant import Instant, Instants
from ocp_traj.quantities import SpeedLaw
from ocp_traj.task import TrajectoryTask


class JointPower(InstantCost):
    """Integral of a part of the power of every joint."""

    def expression(self, instant: Instant) -> Any:
        """Return the power of every joint, W."""
        return instant.tau * instant.v

    def integrand(self, instants: Instants, function: Any) -> Array:
        """Return the sum over joints from the torques, which are known already."""
        torque, v = instants.torque, instants.motion(1)
        total = np.zeros(v.shape[1:])
        power = np.empty_like(total)
        for tau_of_joint, v_of_joint in zip(torque, v):
            np.multiply(tau_of_joint, v_of_joint, out=power)
            if self.shape == "absolute":
                np.absolute(power, out=power)
            else:
                np.maximum(power, 0.0, out=power)
            total += power
        return total

    def scaling(self, task: TrajectoryTask) -> SpeedLaw:
        """Return that the power is the product of torques and velocities."""
        return SpeedLaw(speed=1, torque=1)


class Energy(JointPower):
    """Integral of sum |tau qdot| dt, J (paper A; its printed formula is lost, the absolute value is our reading)."""

    name = "energy"
    shape = "absolute"


class EnergyWithoutRegeneration(JointPower):
    """Integral of sum max(tau qdot, 0) dt, J: braking costs nothing and gives nothing back."""

    name = "energy_without_regeneration"
    shape = "positive"
