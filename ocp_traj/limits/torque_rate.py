"""Limits of the rate of change of the joint torques."""

from __future__ import annotations

from typing import Any

import casadi as ca

from ocp_traj.instant import Instant
from ocp_traj.limits.limit import JointLimit


class TorqueRateLimit(JointLimit):
    """Lower and upper d tau / dt = (d tau/dq) v + (d tau/dv) a + (d tau/da) jerk of every joint, N m/s."""

    name = "torque_rate"
    needs_jerk = True

    def value(self, instant: Instant) -> Any:
        """Return the torque rates, by the directional derivative along the motion."""
        assert instant.task.robot is not None
        columns = [ca.SX.sym(name, instant.task.n) for name in "qva"]
        state = ca.vertcat(*columns)
        direction = ca.SX.sym("direction", state.numel())
        rate = ca.jtimes(instant.task.robot.symbolic.inverse_dynamics(*columns), state, direction)
        function = ca.Function("torque_rate", [state, direction], [rate])
        return function(ca.vertcat(instant.q, instant.v, instant.a), ca.vertcat(instant.v, instant.a, instant.j))
