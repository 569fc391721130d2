"""Every description of example-robot-data loads, or is refused with one sentence that names the reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ocp_traj.exceptions import RobotError
from ocp_traj.robot import Robot, robot_from_urdf
from ocp_traj.robot.packaged import data_folder

DESCRIPTIONS = sorted(path.relative_to(data_folder()).as_posix() for path in data_folder().rglob("*.urdf"))

NO_ARM = {
    "hector_description/robots/quadrotor_base.urdf": "has no joint left that moves",
    "iris_description/robots/iris_simple.urdf": "has no joint left that moves",
    "ur_description/urdf/ur3.urdf": "has no links, expected an arm",
}
"""Files without a joint, and the reason they are refused for."""


@pytest.mark.parametrize("name", DESCRIPTIONS)
def test_every_description_loads_or_says_why_not(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    path = data_folder() / name
    if name in NO_ARM:
        with pytest.raises(RobotError) as caught:
            robot_from_urdf(path)
        assert str(caught.value) == f"robot description {path}: {NO_ARM[name]}"
        return
    robot = robot_from_urdf(path)
    check_limits_and_frames(robot)
    assert capfd.readouterr().err == ""


def check_limits_and_frames(robot: Robot) -> None:
    assert robot.model.nq == robot.n + len(robot.followers)
    for quantity in ("velocity", "acceleration", "jerk", "torque"):
        lower, upper = getattr(robot, f"{quantity}_limits")
        assert (upper > 0.0).all() and (lower == -upper).all()
    pose = robot.pose(np.zeros(robot.n))
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)
    if robot.has_inertia and robot.n <= 12:
        q, v, a = np.random.default_rng(0).uniform(-1.0, 1.0, (3, 3, robot.n))
        expected = robot.torque(q, v, a)
        found = np.array(robot.symbolic.inverse_dynamics(q.T, v.T, a.T)).T
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def test_all_files_without_an_arm_are_there() -> None:
    assert set(NO_ARM) <= set(DESCRIPTIONS) and len(DESCRIPTIONS) > 60


@pytest.mark.parametrize("name", ["panda_description/urdf/panda.urdf", "kinova_description/robots/kinova.urdf"])
def test_the_default_tool_is_at_the_end_of_the_arm(name: str) -> None:
    path: Path = data_folder() / name
    group = {"panda": "arm"}.get(path.stem)
    robot = robot_from_urdf(path, group=group)
    assert robot.tool == {"panda": "panda_hand_tcp", "kinova": "j2s6s200_link_6"}[path.stem]
