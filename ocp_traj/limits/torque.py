"""Limits of the joint torques."""

from __future__ import annotations

from typing import Any

from ocp_traj.arrays import Array
from ocp_traj.instant import Instant, Instants
from ocp_traj.limits.limit import JointLimit
from ocp_traj.quantities import SpeedLaw
from ocp_traj.task import TrajectoryTask


class TorqueLimit(JointLimit):
    """Lower and upper torque of every joint, N m (N for prismatic joints)."""

    name = "torque"

    def value(self, instant: Instant) -> Any:
        """Return the torques."""
        return instant.tau

    def values(self, instants: Instants, function: Any) -> Array:
        """Return the torques of the limited joints, which are known already."""
        torque, joints = instants.torque, self.joints(instants.task)
        return torque if len(joints) == len(torque) else torque[joints]

    def scaling(self, task: TrajectoryTask) -> SpeedLaw:
        """Return that the values are torques."""
        return SpeedLaw(torque=1)
