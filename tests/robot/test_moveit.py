"""Limits from MoveIt's joint_limits.yaml."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ocp_traj.exceptions import InputError
from ocp_traj.robot import limits_from_moveit, load_robot

FILE = """
default_velocity_scaling_factor: 0.5
default_acceleration_scaling_factor: 0.1
joint_limits:
  shoulder_pan_joint:
    has_velocity_limits: true
    max_velocity: 3.0
    has_acceleration_limits: true
    max_acceleration: 1e1
    has_jerk_limits: true
    max_jerk: 100
    has_position_limits: true
    min_position: !degrees -180.0
    max_position: !degrees 90
    has_effort_limits: true
    max_effort: 40.0
  elbow_joint:
    has_velocity_limits: true
    min_velocity: -1.0
    max_velocity: 2.0
    has_acceleration_limits: false
    max_acceleration: 7.0
  gripper:
    has_velocity_limits: true
    max_velocity: 1.0
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "joint_limits.yaml"
    path.write_text(text)
    return path


def test_switches_scaling_and_units_are_obeyed(tmp_path: Path) -> None:
    robot = load_robot("ur5")
    limits = limits_from_moveit(write(tmp_path, FILE), robot)
    np.testing.assert_allclose(limits["velocity"][:, 0], [-1.5, 1.5])
    np.testing.assert_allclose(limits["velocity"][:, 2], [-0.5, 1.0])
    np.testing.assert_allclose(limits["velocity"][:, 1], 0.5 * robot.velocity_limits[:, 1])
    np.testing.assert_allclose(limits["acceleration"][:, 0], [-1.0, 1.0])
    assert np.all(np.isinf(limits["acceleration"][:, 1:]))
    np.testing.assert_allclose(limits["jerk"][:, 0], [-100.0, 100.0])
    np.testing.assert_allclose(limits["position"][:, 0], [-np.pi, np.pi / 2])
    np.testing.assert_allclose(limits["position"][:, 1:], robot.position_limits[:, 1:])
    np.testing.assert_allclose(limits["torque"][:, 0], [-40.0, 40.0])
    np.testing.assert_allclose(limits["torque"][:, 1:], robot.torque_limits[:, 1:])


def test_only_what_the_file_speaks_of_is_returned(tmp_path: Path) -> None:
    robot = load_robot("ur5")
    text = "joint_limits:\n  elbow_joint:\n    has_velocity_limits: true\n    max_velocity: 1.0\n"
    limits = limits_from_moveit(write(tmp_path, text), robot)
    assert set(limits) == {"velocity"}
    assert limits["velocity"][1].tolist() == [3.15, 3.15, 1.0, 3.2, 3.2, 3.2]
    assert robot.velocity_limits[1, 2] == 3.15  # the robot's own are untouched


JOINT = "joint_limits:\n  elbow_joint:\n    has_velocity_limits: true\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1, 2]", "has no section joint_limits"),
        ("limits: 3", "has no section joint_limits"),
        ("a: [", "is no valid YAML"),
        ("joint_limits:\n  finger: {}\n", "names the joints finger, none of which robot 'ur5' has"),
        (JOINT, "joint 'elbow_joint' has no max_velocity though its switch is on"),
        (
            JOINT + "    max_velocity: fast\n",
            "max_velocity of joint 'elbow_joint' is 'fast', expected a finite number",
        ),
        (JOINT + "    max_velocity: .inf\n", "expected a finite number"),
        (JOINT + "    max_velocity: true\n", "expected a finite number"),
        (JOINT + "    max_velocity: -1.0\n", "expected lower <= upper with zero between them"),
        (JOINT + "    max_velocity: 1\ndefault_velocity_scaling_factor: 2\n", "above 0 and at most 1"),
        (JOINT + "    max_velocity: !degrees x\n", "is no valid YAML"),
    ],
)
def test_a_wrong_file_is_refused_with_joint_and_key(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        limits_from_moveit(write(tmp_path, text), load_robot("ur5"))


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nothing\.yaml cannot be read: No such file"):
        limits_from_moveit(tmp_path / "nothing.yaml", load_robot("ur5"))
