"""Limits of the joint torques."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ocp_traj.arrays import Array
from ocp_traj.limits.limit import SampledConstraint, SymbolicSample, finite_joints

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask


class TorqueLimit(SampledConstraint):
    """Lower and upper torque of every joint, N m (N for prismatic joints)."""

    name = "torque"

    def applies(self, task: TrajectoryTask) -> bool:
        """Return whether any joint has a finite limit."""
        return task.limited("torque")

    def expression(self, sample: SymbolicSample) -> Any:
        """Return the torques of the limited joints."""
        return sample.tau[self.joints(sample.task)]

    def bounds(self, task: TrajectoryTask) -> Array:
        """Return the limits of the limited joints."""
        return task.limits.get("torque")[:, :, self.joints(task)]

    def joints(self, task: TrajectoryTask) -> list[int]:
        """Return the limited joints."""
        return finite_joints(task.limits.get("torque"))
