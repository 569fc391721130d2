"""Limits of the rate of change of the joint torques."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca

from ocp_traj.arrays import Array
from ocp_traj.limits.limit import SampledConstraint, SymbolicSample, finite_joints

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask


class TorqueRateLimit(SampledConstraint):
    """Lower and upper d tau / dt = (d tau/dq) v + (d tau/dv) a + (d tau/da) jerk of every joint, N m/s."""

    name = "torque_rate"
    needs_jerk = True

    def applies(self, task: TrajectoryTask) -> bool:
        """Return whether any joint has a finite limit."""
        return task.limited("torque_rate")

    def expression(self, sample: SymbolicSample) -> Any:
        """Return the torque rates of the limited joints, by the directional derivative along the motion."""
        assert sample.task.robot is not None
        columns = [ca.SX.sym(name, sample.task.n) for name in "qva"]
        state = ca.vertcat(*columns)
        direction = ca.SX.sym("direction", state.numel())
        rate = ca.jtimes(sample.task.robot.symbolic.inverse_dynamics(*columns), state, direction)
        function = ca.Function("torque_rate", [state, direction], [rate])
        value = function(ca.vertcat(sample.q, sample.v, sample.a), ca.vertcat(sample.v, sample.a, sample.j))
        return value[self.joints(sample.task)]

    def bounds(self, task: TrajectoryTask) -> Array:
        """Return the limits of the limited joints."""
        return task.limits.get("torque_rate")[:, :, self.joints(task)]

    def joints(self, task: TrajectoryTask) -> list[int]:
        """Return the limited joints."""
        return finite_joints(task.limits.get("torque_rate"))
