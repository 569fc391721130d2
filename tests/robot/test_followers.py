"""Joints that follow others move with them, carry their load, and narrow their limits."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ocp_traj as ot
from ocp_traj.case import task_from_json, task_to_json
from ocp_traj.proofs.not_proved import NotProved
from ocp_traj.proofs.resolve import resolve_task
from ocp_traj.robot import Robot, robot_from_urdf
from ocp_traj.robot.inverse_kinematics.damped_least_squares import DampedLeastSquares

BODY = (
    '<inertial><origin xyz="0.02 0 0.1" rpy="0.3 0 0.2"/><mass value="1.5"/>'
    '<inertia ixx="0.02" iyy="0.03" izz="0.01" ixy="0.001" ixz="0" iyz="0"/></inertial>'
)
MIMIC = {"j3": ("j1", -1.5, 0.2), "j4": ("j3", 0.5, -0.1), "j5": ("j2", 2.0, 0.0)}
AXES = {"j1": "0 0 1", "j2": "0 1 0", "j3": "0 1 0", "j4": "1 0 0", "j5": "0.6 0 0.8", "j6": "1 0 0"}


def urdf(mimic: dict[str, tuple[str, float, float]]) -> str:
    text = '<link name="l0"/>'
    for number, (name, axis) in enumerate(AXES.items(), start=1):
        tag = ""
        if name in mimic:
            driver, multiplier, offset = mimic[name]
            tag = f'<mimic joint="{driver}" multiplier="{multiplier}" offset="{offset}"/>'
        kind = "prismatic" if name == "j4" else "revolute"
        text += (
            f'<link name="l{number}">{BODY}</link><joint name="{name}" type="{kind}"><parent link="l{number - 1}"/>'
            f'<child link="l{number}"/><origin xyz="0.05 0 0.2" rpy="0.3 0.1 0"/><axis xyz="{axis}"/>'
            f'<limit lower="-2.4" upper="1.8" effort="90" velocity="3"/>{tag}</joint>'
        )
    return f'<robot name="coupled">{text}</robot>'


@pytest.fixture
def pair(tmp_path: Path) -> tuple[Robot, Robot]:
    """Return the arm with followers and the same arm with all joints free."""
    (tmp_path / "coupled.urdf").write_text(urdf(MIMIC))
    (tmp_path / "free.urdf").write_text(urdf({}))
    return robot_from_urdf(tmp_path / "coupled.urdf"), robot_from_urdf(tmp_path / "free.urdf")


def full(q: np.ndarray, *, rate: bool = False) -> np.ndarray:
    """Return all six joints from j1, j2, j6, by the rules above and not by the library."""
    one, two, six = np.moveaxis(q, -1, 0)
    three = -1.5 * one + (0.0 if rate else 0.2)
    return np.stack([one, two, three, 0.5 * three - (0.0 if rate else 0.1), 2.0 * two, six], axis=-1)


def test_only_the_others_are_joints_of_the_task(pair: tuple[Robot, Robot]) -> None:
    robot, _ = pair
    assert robot.joint_names == ("j1", "j2", "j6")
    assert robot.followers["j3"] == ("j1", -1.5, 0.2)
    assert robot.followers["j4"] == ("j1", -0.75, pytest.approx(0.0))
    assert robot.n == 3 and robot.has_inertia


def test_frames_move_as_with_the_joints_set_by_hand(pair: tuple[Robot, Robot]) -> None:
    robot, free = pair
    for q in np.random.default_rng(0).uniform(-1.0, 1.0, (20, 3)):
        for name in ("l3", "l4", "l6"):
            np.testing.assert_allclose(robot.pose(q, name), free.pose(full(q), name), atol=1e-12)
            np.testing.assert_allclose(np.array(robot.symbolic.pose(name)(q)), robot.pose(q, name), atol=1e-12)
        v = np.array([0.4, -0.3, 0.9])
        numeric = (robot.pose(q + 1e-6 * v)[:3, 3] - robot.pose(q - 1e-6 * v)[:3, 3]) / 2e-6
        np.testing.assert_allclose(np.array(robot.symbolic.velocity()(q, v)).ravel(), numeric, atol=1e-7)


def test_a_joint_bears_the_power_of_those_that_follow_it(pair: tuple[Robot, Robot]) -> None:
    robot, free = pair
    q, v, a = np.random.default_rng(1).uniform(-1.0, 1.0, (3, 30, 3))
    torque = free.torque(full(q), full(v, rate=True), full(a, rate=True))
    for direction in np.eye(3):
        power = (torque * full(np.tile(direction, (30, 1)), rate=True)).sum(axis=1)
        np.testing.assert_allclose(robot.torque(q, v, a) @ direction, power, atol=1e-11)
    np.testing.assert_allclose(robot.batch.torque(q, v, a), robot.torque(q, v, a), atol=1e-10)


def test_limits_of_followers_narrow_those_of_their_joint(pair: tuple[Robot, Robot]) -> None:
    robot, _ = pair
    # j1 in [-2.4, 1.8]; j3 = 0.2 - 1.5 j1 in [-2.4, 1.8]: j1 in [-16/15, 26/15]; j4 = -0.75 j1: j1 in [-2.4, 3.2].
    np.testing.assert_allclose(robot.position_limits[:, 0], [-16 / 15, 26 / 15])
    np.testing.assert_allclose(robot.position_limits[:, 1], [-1.2, 0.9])
    np.testing.assert_allclose(robot.velocity_limits[1], [2.0, 1.5, 3.0])
    np.testing.assert_allclose(robot.torque_limits[1], [90.0, 90.0, 90.0])


def test_inverse_kinematics_goes_through_the_coupling(pair: tuple[Robot, Robot]) -> None:
    robot, _ = pair
    q = np.array([0.4, -0.5, 0.6])
    end = DampedLeastSquares(robot).descend(robot.pose(q), q + 0.2)
    assert end.converged
    np.testing.assert_allclose(robot.pose(end.q), robot.pose(q), atol=1e-8)


def test_a_motion_with_followers_is_solved_and_audited_by_its_torque(pair: tuple[Robot, Robot]) -> None:
    robot, free = pair
    points = np.array([[0.0, 0.0, 0.0], [0.8, -0.5, 0.7]])
    task = ot.TrajectoryTask(points, ot.Limits(torque=80.0), robot, virtual_knots=2)
    result = ot.solve(task, "ipopt")
    assert result.audit.feasible and result.audit.worst is not None
    t = np.linspace(0.0, result.duration, 300)
    q, v, a = (result.trajectory(t, derivative) for derivative in range(3))
    torque = free.torque(full(q), full(v, rate=True), full(a, rate=True)) @ full(np.eye(3), rate=True).T
    assert 0.97 < np.abs(torque).max() / 80.0 < 1.0 + 1e-6
    assert result.energy == pytest.approx(np.trapezoid(np.abs(torque * v).sum(axis=1), t), rel=1e-3)


def test_followers_travel_with_a_task(pair: tuple[Robot, Robot], tmp_path: Path) -> None:
    robot, _ = pair
    hasty = replace(robot, acceleration_limits=np.array([[-5.0, -6.0, -np.inf], [5.0, 6.0, np.inf]]))
    for arm in (robot, hasty):
        task = ot.TrajectoryTask(np.array([[0.0] * 3, [0.3, 0.2, 0.1]]), ot.Limits(jerk=90.0), arm)
        data = json.loads(json.dumps(task_to_json(task), allow_nan=False))
        back = task_from_json(data, "task.json")
        assert back.robot == arm and back.robot.followers == arm.followers
        assert ot.task_digest(back) == ot.task_digest(task)
    data["robot"]["chain"]["joints"][2]["follows"]["joint"] = "j9"
    with pytest.raises(ot.CaseError, match="joint 'j3' follows 'j9', expected one of j1, j2, j6"):
        task_from_json(data, "task.json")


def test_torques_with_followers_are_not_proved(pair: tuple[Robot, Robot]) -> None:
    task = ot.TrajectoryTask(np.array([[0.0] * 3, [0.3] * 3]), ot.Limits(torque=200.0), pair[0], virtual_knots=2)
    with pytest.raises(NotProved, match="torques of 'coupled', whose joints follow one another"):
        resolve_task(task)


def test_equal_arms_differ_by_how_their_joints_follow(tmp_path: Path, pair: tuple[Robot, Robot]) -> None:
    (tmp_path / "other.urdf").write_text(urdf({**MIMIC, "j5": ("j2", 2.0, 0.1)}))
    other = robot_from_urdf(tmp_path / "other.urdf")
    assert other.digest() != pair[0].digest() == robot_from_urdf(tmp_path / "coupled.urdf").digest()


def test_a_joint_that_follows_one_that_is_not_there_is_held(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(urdf({"j3": ("missing", 1.0, 0.0)}))
    robot = robot_from_urdf(tmp_path / "arm.urdf")
    assert "j3" not in robot.joint_names and robot.source is not None and dict(robot.source.lock) == {"j3": 0.0}
    assert robot_from_urdf(tmp_path / "arm.urdf", keep=["j3"]).joint_names == ("j3",)
