"""Robots from URDF files and by hand: dynamics of any chain, payload, gravity, friction, errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from ocp_traj.exceptions import RobotError
from ocp_traj.robot import Friction, Payload, Robot, load_robot, robot_from_dh, robot_from_urdf

URDF = """<?xml version="1.0"?>
<robot name="pair">
  <link name="root"/>
  <link name="one"><inertial><origin xyz="0 0 0.2"/><mass value="2"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="two"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="swing" type="{first}"><parent link="root"/><child link="one"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" effort="5" velocity="3"/><dynamics damping="0.5" friction="0.25"/></joint>
  <joint name="slide" type="prismatic"><parent link="one"/><child link="two"/><origin xyz="0 0 0.4"/>
    <axis xyz="0 0 1"/><limit lower="{low}" upper="0.3" effort="0" velocity="0"/></joint>
</robot>
"""


def write_urdf(folder: Path, first: str = "revolute", low: float = 0.0) -> Path:
    path = folder / "pair.urdf"
    path.write_text(URDF.format(first=first, low=low))
    return path


def random_chain(rng: np.random.Generator, n: int) -> Robot:
    """A random tree of n links with revolute and prismatic joints, aligned and not, some with armature."""
    model = pin.Model()
    model.name = "random"
    aligned = [getattr(pin, f"JointModel{kind}{axis}") for kind in "RP" for axis in "XYZ"]
    unaligned = [pin.JointModelRevoluteUnaligned, pin.JointModelPrismaticUnaligned]
    kinds = []
    for index in range(n):
        if rng.random() < 0.5:
            joint = aligned[rng.integers(6)]()
        else:
            axis = rng.standard_normal(3)
            joint = unaligned[rng.integers(2)](axis / np.linalg.norm(axis))
        kinds.append("prismatic" if "P" in joint.shortname().replace("JointModel", "")[:1] else "revolute")
        parent = index if rng.random() < 0.8 else int(rng.integers(0, index + 1))
        model.addJoint(parent, joint, pin.SE3.Random(), f"j{index}")
        model.appendBodyToJoint(index + 1, pin.Inertia.Random(), pin.SE3.Random())
    model.armature = rng.uniform(0.0, 0.3, n)
    model.addFrame(pin.Frame("tip", n, 0, pin.SE3.Random(), pin.FrameType.BODY))
    free = np.array([[-np.inf] * n, [np.inf] * n])
    names = tuple(f"j{index}" for index in range(n))
    return Robot("random", names, tuple(kinds), free, free, free, model, tool="tip", base="universe")


@pytest.mark.parametrize("n", range(1, 9))
def test_random_chains_agree_with_pinocchio(n: int) -> None:
    rng = np.random.default_rng(n)
    pin.seed(n)
    for _ in range(5):
        robot = random_chain(rng, n).with_changes(gravity=rng.standard_normal(3))
        q, v, a = rng.uniform(-2.0, 2.0, (3, 20, n))
        expected = robot.torque(q, v, a)
        found = np.array(robot.symbolic.inverse_dynamics(q.T, v.T, a.T)).T
        np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10 * np.max(np.abs(expected)))
        for position in q[:5]:
            pose = np.array(robot.symbolic.pose()(position))
            np.testing.assert_allclose(pose, robot.pose(position), atol=1e-10)


def test_a_pendulum_has_the_torque_of_the_textbook(tmp_path: Path) -> None:
    robot = robot_from_urdf(write_urdf(tmp_path), lock=["slide"])
    angle, rate, acceleration = 0.3, 0.7, -1.1
    # 2 kg at 0.2 m and 1 kg at (0.1, 0, 0.4) m about a horizontal y axis; tau = I a - gravity's moment.
    inertia = 0.1 + 2 * 0.04 + 0.03 + 1 * (0.01 + 0.16)
    first_z, first_x = 2 * 0.2 + 1 * 0.4, 1 * 0.1
    moment = 9.81 * (first_z * np.sin(angle) + first_x * np.cos(angle))
    tau = robot.torque([[angle]], [[rate]], [[acceleration]])[0, 0]
    assert tau == pytest.approx(inertia * acceleration - moment, rel=1e-12)


def test_payload_acts_as_a_body_at_the_tool() -> None:
    bare = load_robot("ur5")
    payload = Payload(2.0, np.array([0.01, -0.02, 0.05]), np.array([0.02, 0.03, 0.04, 0.001, -0.002, 0.003]))
    robot = bare.with_changes(payload=payload)
    tool = bare.model.frames[bare.model.getFrameId("tool0", pin.FrameType.BODY)]
    model = bare.bare_model.copy()
    model.appendBodyToJoint(6, pin.Inertia(2.0, np.array(payload.com), payload.tensor), tool.placement)
    rng = np.random.default_rng(0)
    q, v, a = rng.standard_normal((3, 50, 6))
    expected = np.array([pin.rnea(model, model.createData(), *row) for row in zip(q, v, a, strict=True)])
    np.testing.assert_allclose(robot.torque(q, v, a), expected, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(robot.batch.torque(q, v, a), expected, rtol=1e-10, atol=1e-10)
    assert bare.model.inertias[6].mass == pytest.approx(0.1879)


def test_payload_follows_the_tool_when_the_tool_changes() -> None:
    payload = Payload(1.0)
    at_tool = load_robot("ur5").with_changes(payload=payload)
    at_elbow = at_tool.with_changes(tool="forearm_link")
    assert at_elbow.model.inertias[6].mass == pytest.approx(0.1879)
    assert at_elbow.model.inertias[3].mass == pytest.approx(2.275 + 1.0)


def test_the_static_torque_of_a_payload_is_its_weight_times_the_lever() -> None:
    robot = load_robot("ur5")
    q = np.array([0.3, -1.0, 1.2, -0.4, 0.5, 0.1])
    still = np.zeros((1, 6))
    loaded = robot.with_changes(payload=Payload(3.0))
    difference = (loaded.torque(q[None], still, still) - robot.torque(q[None], still, still))[0]
    step = 1e-6
    height = [
        (robot.pose(q + step * unit)[2, 3] - robot.pose(q - step * unit)[2, 3]) / (2 * step)
        for unit in np.eye(6)
    ]
    np.testing.assert_allclose(difference, 3.0 * 9.81 * np.array(height), atol=1e-7)


def test_gravity_is_given_in_the_base_frame() -> None:
    robot = load_robot("ur5")
    # "base" is "base_link" turned by pi about z.
    turned = robot.with_changes(base="base", gravity=[1.0, 2.0, -3.0])
    np.testing.assert_allclose(turned.model.gravity.linear, [-1.0, -2.0, -3.0], atol=1e-11)
    q = np.random.default_rng(1).standard_normal((5, 6))
    zero = np.zeros_like(q)
    expected = robot.with_changes(gravity=[-1.0, -2.0, -3.0]).torque(q, zero, zero)
    np.testing.assert_allclose(turned.torque(q, zero, zero), expected, atol=1e-9)
    np.testing.assert_allclose(turned.batch.torque(q, zero, zero), expected, atol=1e-9)


def test_a_ceiling_mount_reverses_the_static_torque() -> None:
    robot = load_robot("ur5")
    q = np.random.default_rng(2).standard_normal((5, 6))
    zero = np.zeros_like(q)
    ceiling = robot.with_changes(gravity=[0.0, 0.0, 9.81])
    np.testing.assert_allclose(ceiling.torque(q, zero, zero), -robot.torque(q, zero, zero), atol=1e-12)


def test_friction_is_viscous_plus_coulomb() -> None:
    robot = load_robot("ur5")
    friction = Friction(viscous=np.arange(6.0), coulomb=0.5 * np.arange(6.0))
    rubbing = robot.with_changes(friction=friction)
    q, v, a = np.random.default_rng(3).standard_normal((3, 20, 6))
    v[0] = 0.0
    expected = robot.torque(q, v, a) + friction.viscous * v + friction.coulomb * np.sign(v)
    np.testing.assert_allclose(rubbing.torque(q, v, a), expected, rtol=1e-13)
    np.testing.assert_allclose(rubbing.batch.torque(q, v, a), expected, rtol=1e-10, atol=1e-10)


def test_the_base_frame_moves_poses() -> None:
    robot = load_robot("ur5")
    q = np.random.default_rng(4).standard_normal(6)
    turned = robot.with_changes(base="base")
    expected = np.diag([-1.0, -1.0, 1.0, 1.0]) @ robot.pose(q)
    np.testing.assert_allclose(turned.pose(q), expected, atol=1e-10)
    np.testing.assert_allclose(np.array(turned.symbolic.pose()(q)), expected, atol=1e-10)
    v = np.random.default_rng(5).standard_normal(6)
    velocity = np.array(turned.symbolic.velocity()(q, v)).ravel()
    step = 1e-6
    numeric = (turned.pose(q + step * v)[:3, 3] - turned.pose(q - step * v)[:3, 3]) / (2 * step)
    np.testing.assert_allclose(velocity, numeric, atol=1e-8)


def test_the_digest_sees_every_change() -> None:
    robot = load_robot("ur5")
    changed = [
        robot.with_changes(payload=Payload(1.0)),
        robot.with_changes(gravity=[0.0, 0.0, 9.81]),
        robot.with_changes(friction=Friction(np.ones(6), np.zeros(6))),
        robot.with_changes(friction=Friction(np.zeros(6), np.ones(6))),
        robot.with_changes(tool="ee_link"),
        robot.with_changes(base="base"),
    ]
    digests = {robot.digest(), *(item.digest() for item in changed)}
    assert len(digests) == 7
    assert robot == load_robot("ur5")
    assert robot != changed[0]
    assert robot.with_changes() == robot
    assert len({robot, load_robot("ur5")}) == 1


def test_urdf_limits_are_read_and_absent_ones_are_infinite(tmp_path: Path) -> None:
    robot = robot_from_urdf(write_urdf(tmp_path))
    assert robot.name == "pair"
    assert robot.joint_types == ("revolute", "prismatic")
    np.testing.assert_array_equal(robot.position_limits, [[-1.0, 0.0], [2.0, 0.3]])
    np.testing.assert_array_equal(robot.velocity_limits, [[-3.0, -np.inf], [3.0, np.inf]])
    np.testing.assert_array_equal(robot.torque_limits, [[-5.0, -np.inf], [5.0, np.inf]])
    assert (robot.tool, robot.base) == ("two", "universe")


def test_a_continuous_joint_is_one_number_without_range(tmp_path: Path) -> None:
    robot = robot_from_urdf(write_urdf(tmp_path, "continuous"))
    assert robot.joint_types == ("continuous", "prismatic")
    np.testing.assert_array_equal(robot.position_limits[:, 0], [-np.inf, np.inf])
    q, v, a = np.random.default_rng(6).standard_normal((3, 10, 2))
    expected = robot_from_urdf(write_urdf(tmp_path)).torque(q, v, a)
    np.testing.assert_allclose(robot.torque(q, v, a), expected, atol=1e-13)


def test_friction_tags_are_used_on_request_only(tmp_path: Path) -> None:
    path = write_urdf(tmp_path)
    assert robot_from_urdf(path).friction.is_zero
    friction = robot_from_urdf(path, urdf_friction=True).friction
    np.testing.assert_array_equal(friction.viscous, [0.5, 0.0])
    np.testing.assert_array_equal(friction.coulomb, [0.25, 0.0])


def test_a_joint_whose_range_excludes_zero_is_locked_mid_range(tmp_path: Path) -> None:
    robot = robot_from_urdf(write_urdf(tmp_path, low=0.1), lock=["slide"])
    np.testing.assert_allclose(robot.pose([0.0], "two")[:3, 3], [0.0, 0.0, 0.4 + 0.2], atol=1e-15)


def test_keep_locks_all_others(tmp_path: Path) -> None:
    assert robot_from_urdf(write_urdf(tmp_path), keep=["slide"]).joint_names == ("slide",)


def test_a_robot_without_masses_has_no_torque() -> None:
    robot = robot_from_dh("modified", [0.0, 1.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0])
    assert not robot.has_inertia
    for use in (
        lambda: robot.symbolic.inverse_dynamics,
        lambda: robot.torque([[0.0, 0.0]], [[0.0, 0.0]], [[0.0, 0.0]]),
    ):
        with pytest.raises(RobotError, match="has no link masses"):
            use()


def test_robot_arrays_are_read_only() -> None:
    robot = load_robot("ur5")
    for array in (robot.position_limits, robot.velocity_limits, robot.torque_limits, robot.gravity):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0


def test_urdf_errors_are_clear(tmp_path: Path) -> None:
    path = write_urdf(tmp_path)
    with pytest.raises(RobotError, match=r"missing\.urdf does not exist"):
        robot_from_urdf(tmp_path / "missing.urdf")
    (tmp_path / "bad.urdf").write_text("<robot>")
    with pytest.raises(RobotError, match="is not a valid URDF"):
        robot_from_urdf(tmp_path / "bad.urdf")
    with pytest.raises(RobotError, match=r"joint 'finger' does not exist.*swing, slide"):
        robot_from_urdf(path, lock=["finger"])
    with pytest.raises(RobotError, match=r"frame 'hand' does not exist.*root, one, two"):
        robot_from_urdf(path, tool="hand")
    with pytest.raises(RobotError, match="base frame 'one' is moved by joint 'swing'"):
        robot_from_urdf(path, base="one")
    with pytest.raises(RobotError, match="no joint left that moves"):
        robot_from_urdf(path, lock=["swing", "slide"])
    with pytest.raises(RobotError, match="type planar is not supported"):
        robot_from_urdf(write_urdf(tmp_path, "planar"))


def test_wrong_arguments_are_refused() -> None:
    robot = load_robot("ur5")
    with pytest.raises(RobotError, match=r"q, v, a have shapes .* expected \(N, 6\) each"):
        robot.torque(np.zeros((2, 6)), np.zeros((2, 6)), np.zeros((2, 5)))
    with pytest.raises(RobotError, match=r"q has shape \(5,\), expected \(6,\)"):
        robot.pose(np.zeros(5))
    with pytest.raises(RobotError, match="friction has 2 entries, expected 6"):
        robot.with_changes(friction=Friction.none(2))
    with pytest.raises(RobotError, match=r"gravity has shape \(2,\), expected \(3,\)"):
        robot.with_changes(gravity=[0.0, 1.0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((-1.0,), "mass is -1.0 kg"),
        ((float("nan"),), "mass is nan kg"),
        ((1.0, np.zeros(2)), r"com has shape \(2,\)"),
        ((1.0, np.array([0.0, np.inf, 0.0])), "expected finite numbers"),
        ((1.0, np.zeros(3), np.zeros(3)), r"inertia has shape \(3,\)"),
        ((1.0, np.zeros(3), np.array([-1.0, 1.0, 1.0, 0.0, 0.0, 0.0])), "principal moments"),
        ((1.0, np.zeros(3), np.array([3.0, 1.0, 1.0, 0.0, 0.0, 0.0])), "principal moments"),
    ],
)
def test_an_impossible_payload_is_refused(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(RobotError, match=message):
        Payload(*arguments)  # type: ignore[arg-type]


def test_negative_friction_is_refused() -> None:
    with pytest.raises(RobotError, match=r"coulomb friction is \[-1.0\]"):
        Friction(np.array([0.0]), np.array([-1.0]))
