"""Torques of a solved motion by Pinocchio itself, from the URDF file, without any of our robot code."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import ocp_traj as ot
from ocp_traj.robot.packaged import data_folder
from ocp_traj.solvers.gradient.gradient import Gradient


def test_a_torque_limited_motion_keeps_its_limits_by_pinocchio_alone() -> None:
    task = ot.load_case("ur5-torque-limited")
    result = ot.solve(task, Gradient(compiled=False))
    assert result.feasible
    model = pinocchio.buildModelFromUrdf(str(data_folder() / "ur_description/urdf/ur5_robot.urdf"))
    data = model.createData()
    t = np.linspace(0.0, result.duration, 20_001)
    states = zip(*(result.trajectory(t, order) for order in range(3)))
    tau = np.array([pinocchio.rnea(model, data, q, v, a) for q, v, a in states])
    limit = np.asarray(task.limits.get("torque"))[0, 1]
    largest = (np.abs(tau) / limit).max()
    assert largest <= 1.0 + 1e-6
    assert result.audit.limits["torque"].ratio == pytest.approx(largest, abs=1e-6)
