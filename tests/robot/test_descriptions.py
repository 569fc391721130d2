"""Descriptions as they come: what a URDF may leave out, say oddly or get wrong, and which joints belong to the task."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from ocp_traj.exceptions import RobotError
from ocp_traj.robot import load_robot, robot_from_urdf
from ocp_traj.robot.description import xacro
from ocp_traj.robot.description.srdf import srdf_beside

BODY = (
    '<inertial><origin xyz="0.02 0 0.1"/><mass value="1.5"/>'
    '<inertia ixx="0.02" iyy="0.03" izz="0.01" ixy="0.001" ixz="0" iyz="0"/></inertial>'
)
LIMIT = '<limit lower="-2" upper="2" effort="20" velocity="2"/>'


def link(name: str, inside: str = BODY) -> str:
    return f'<link name="{name}">{inside}</link>'


def joint(
    name: str, parent: str, child: str, kind: str = "revolute", axis: str = "0 0 1", inside: str = LIMIT
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 0.3" rpy="0.2 0 0"/><axis xyz="{axis}"/>{inside}</joint>'
    )


def write(folder: Path, *parts: str, name: str = "arm.urdf") -> Path:
    path = folder / name
    path.write_text(f'<robot name="arm">{"".join(parts)}</robot>', encoding="utf-8")
    return path


def hand(*, mimic: str = '<mimic joint="finger_1"/>') -> list[str]:
    """Parts of an arm of two joints with two fingers and a fixed flange."""
    stroke = '<limit lower="0" upper="0.04" effort="5" velocity="0.1"/>'
    return [
        link("base", ""),
        link("upper"),
        link("lower"),
        link("tool0", ""),
        link("left"),
        link("right"),
        joint("shoulder", "base", "upper", axis="0 1 0"),
        joint("elbow", "upper", "lower", axis="0 1 0"),
        joint("mount", "lower", "tool0", "fixed"),
        joint("finger_1", "tool0", "left", "prismatic", "0 1 0", stroke),
        joint("finger_2", "tool0", "right", "prismatic", "0 -1 0", stroke + mimic),
    ]


@pytest.mark.parametrize("axis", ["0 0 -1", "0 -1 0", "-1 0 0", "1 2 -3", "0 0 5", "1 0 0"])
def test_a_continuous_joint_turns_about_any_axis(tmp_path: Path, axis: str) -> None:
    robot = robot_from_urdf(
        write(tmp_path, link("a", ""), link("b"), joint("j", "a", "b", "continuous", axis, ""))
    )
    direction = np.array([float(word) for word in axis.split()])
    expected = pin.exp3(0.7 * direction / np.linalg.norm(direction))
    np.testing.assert_allclose(
        robot.pose([0.0])[:3, :3].T @ robot.pose([0.7])[:3, :3], expected, atol=1e-12
    )
    states = np.random.default_rng(0).standard_normal((3, 5, 1))
    np.testing.assert_allclose(robot.batch.torque(*states), robot.torque(*states), atol=1e-12)
    assert robot.joint_types == ("continuous",)


@pytest.mark.parametrize(
    ("inside", "limits"),
    [
        ("", {}),
        ("<limit/>", {}),
        ('<limit lower="0" upper="0" effort="0" velocity="0"/>', {}),
        ('<limit lower="-inf" upper="inf" effort="inf" velocity="-1"/>', {}),
        ('<limit upper="2"/>', {"position": (0.0, 2.0)}),
        ('<limit lower="1" upper="1"/>', {"position": (1.0, 1.0)}),
        ('<limit effort="3" velocity="4"/>', {"torque": (-3.0, 3.0), "velocity": (-4.0, 4.0)}),
        (
            '<limit acceleration="5" jerk="60" deceleration="4"/>',
            {"acceleration": (-4.0, 4.0), "jerk": (-60.0, 60.0)},
        ),
    ],
)
def test_zero_and_absent_limits_are_not_given(
    tmp_path: Path, inside: str, limits: dict[str, tuple[float, float]]
) -> None:
    robot = robot_from_urdf(write(tmp_path, link("a", ""), link("b"), joint("j", "a", "b", inside=inside)))
    for quantity in ("position", "velocity", "torque", "acceleration", "jerk"):
        expected = limits.get(quantity, (-np.inf, np.inf))
        assert tuple(getattr(robot, f"{quantity}_limits")[:, 0]) == expected


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ([joint("j", "a", "b", axis="0 0 0")], "joint 'j' has the axis '0 0 0', expected a direction"),
        ([joint("j", "a", "b", axis="0 1")], "joint 'j': <axis xyz='0 1'> given, expected 3 finite numbers"),
        (
            [joint("j", "a", "b", inside='<limit lower="2" upper="-2"/>')],
            "joint 'j' has the lower limit 2 above its upper limit -2",
        ),
        (
            [joint("j", "a", "b", inside='<limit effort="much"/>')],
            "joint 'j': <limit effort='much'> given, expected a number",
        ),
        ([joint("j", "a", "b", "hinge")], "joint 'j' has the type 'hinge', expected one of revolute"),
        ([joint("", "a", "b")], "a <joint> has no name"),
        ([joint("j", "", "b")], "joint 'j' has no <parent"),
        ([joint("j", "a", "nowhere")], "joint 'j' names the link 'nowhere', which does not exist"),
        ([joint("j", "a", "b"), joint("j", "a", "b")], "joint 'j' is there twice"),
        ([joint("j", "a", "b"), joint("k", "a", "b")], "link 'b' hangs on two joints, 'j' and 'k': closed chains"),
        ([joint("j", "a", "b"), joint("k", "b", "a")], "form a circle, expected a tree"),
        ([joint("j", "a", "b"), link("c")], "links 'a', 'c' hang on no joint, expected one root"),
        ([joint("j", "a", "b", inside='<mimic joint="j"/>')], "'j' mimic each other in a circle"),
        ([joint("j", "a", "b", inside="<mimic/>")], 'joint \'j\' has <mimic> without joint="..."'),
        ([link("", "")], "a <link> has no name"),
        ([link("c", "<inertial/>")], "link 'c': <inertial> has no <mass>"),
        (
            [link("c", '<inertial><mass value="1"/><inertia ixx="1"/></inertial>')],
            "link 'c': <inertia> has no ixy",
        ),
    ],
)
def test_what_cannot_be_is_refused_by_name(tmp_path: Path, parts: list[str], sentence: str) -> None:
    with pytest.raises(RobotError) as caught:
        robot_from_urdf(write(tmp_path, link("a", ""), link("b"), *parts))
    assert sentence in str(caught.value) and "arm.urdf" in str(caught.value)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "is empty, expected a URDF"),
        (b" \n", "is empty, expected a URDF"),
        (b"<sdf/>", "its root is <sdf>, expected <robot>"),
        (b"no xml", "is not a valid URDF"),
        (b"\x00\x01\x02", "is not a valid URDF"),
        (b"<robot name='r'/>", "has no links, expected an arm"),
    ],
)
def test_what_is_no_description_is_refused(tmp_path: Path, content: bytes, sentence: str) -> None:
    (tmp_path / "arm.urdf").write_bytes(content)
    with pytest.raises(RobotError, match=sentence):
        robot_from_urdf(tmp_path / "arm.urdf")


@pytest.mark.parametrize("encoding", ["latin-1", "utf-8", "utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize("declared", [True, False])
def test_names_keep_their_letters_in_any_encoding(tmp_path: Path, encoding: str, declared: bool) -> None:
    head = f'<?xml version="1.0" encoding="{encoding.removesuffix("-sig")}"?>' if declared else ""
    text = f'{head}<robot name="Größe">{link("a", "")}{link("b")}{joint("Drehgelenk für B", "a", "b")}</robot>'
    (tmp_path / "arm.urdf").write_bytes(text.encode(encoding))
    robot = robot_from_urdf(tmp_path / "arm.urdf")
    assert (robot.name, robot.joint_names) == ("Größe", ("Drehgelenk für B",))


@pytest.mark.parametrize(("kind", "length"), [("fixed", 5000), ("fixed", 301), ("floating", 150)])
def test_chains_too_deep_for_the_stack_are_refused(tmp_path: Path, kind: str, length: int) -> None:
    names = [f"l{number}" for number in range(length + 1)]
    parts = [link(name, "") for name in names]
    parts += [joint(f"to_{b}", a, b, kind) for a, b in zip(names, names[1:])]
    path = write(tmp_path, *parts)
    code = f"from ocp_traj.robot import robot_from_urdf; robot_from_urdf({str(path)!r})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 1  # an exception, no signal
    last = done.stderr.splitlines()[-1]
    expected = "has a chain of" if kind == "fixed" else "type floating is not supported"
    assert last.startswith("ocp_traj.exceptions.RobotError: ") and expected in last


def test_the_deepest_chain_that_is_read_moves_its_tip(tmp_path: Path) -> None:
    names = [f"l{number}" for number in range(300)]
    parts = [link(name) for name in names] + [joint("j", "l0", "l1")]
    parts += [joint(f"to_{b}", a, b, "fixed") for a, b in zip(names[1:], names[2:])]
    robot = robot_from_urdf(write(tmp_path, *parts))
    assert robot.model.inertias[1].mass == pytest.approx(299 * 1.5)
    assert np.linalg.norm(robot.pose([0.0], "l299")[:3, 3]) > 0.1


def test_all_joints_of_a_hand_are_free_but_those_that_follow(tmp_path: Path) -> None:
    robot = robot_from_urdf(write(tmp_path, *hand()))
    assert robot.joint_names == ("shoulder", "elbow", "finger_1")
    assert robot.followers == {"finger_2": ("finger_1", 1.0, 0.0)}


@pytest.mark.parametrize(
    ("chosen", "held"),
    [
        ({"lock": ["finger_1"]}, {"finger_1": 0.0, "finger_2": 0.0}),
        ({"lock": {"finger_1": 0.02}}, {"finger_1": 0.02, "finger_2": 0.02}),
        ({"lock": {"finger_1": 0.02, "finger_2": 0.01}}, {"finger_1": 0.02, "finger_2": 0.01}),
        ({"keep": ["elbow", "shoulder"]}, {"finger_1": 0.0, "finger_2": 0.0}),
        ({"keep": ["elbow", "shoulder"], "lock": {"finger_1": 0.03}}, {"finger_1": 0.03, "finger_2": 0.03}),
    ],
)
def test_fingers_are_held_where_they_are_locked(
    tmp_path: Path, chosen: dict[str, list[str]], held: dict[str, float]
) -> None:
    robot = robot_from_urdf(write(tmp_path, *hand()), **chosen)
    assert robot.joint_names == ("shoulder", "elbow") and robot.coupling is None
    assert robot.source is not None and dict(robot.source.lock) == held
    open_hand = robot.pose([0.0, 0.0], "left")[:3, 3] - robot.pose([0.0, 0.0], "right")[:3, 3]
    assert np.linalg.norm(open_hand) == pytest.approx(sum(held.values()), abs=1e-12)


@pytest.mark.parametrize(
    ("chosen", "sentence"),
    [
        ({"lock": ["finger_3"]}, "joint 'finger_3' does not exist in 'arm', its joints are shoulder, elbow"),
        ({"lock": ["finger_3"]}, "did you mean 'finger_"),
        ({"lock": ["mount"]}, "joint 'mount' does not move in 'arm'"),
        ({"keep": ["elbow"], "lock": ["elbow"]}, "joint 'elbow' is both kept and locked"),
        ({"keep": ["finger_2"]}, "joint 'finger_2' cannot be kept, it follows 'finger_1': keep that one"),
        ({"lock": {"finger_1": 0.05}}, "locked at 0.05, expected a position in its range [0, 0.04]"),
        ({"lock": {"finger_1": float("nan")}}, "locked at nan"),
        ({"group": "arm"}, "group 'arm' needs an SRDF, and none lies beside arm.urdf"),
        ({"group": "arm", "keep": ["elbow"]}, "keep and group are both given"),
    ],
)
def test_a_wrong_choice_of_joints_is_refused(
    tmp_path: Path, chosen: dict[str, list[str]], sentence: str
) -> None:
    with pytest.raises(RobotError) as caught:
        robot_from_urdf(write(tmp_path, *hand()), **chosen)
    assert sentence in str(caught.value)


SRDF = """<robot name="arm">
<group name="chain"><chain base_link="base" tip_link="tool0"/></group>
<group name="by joints"><joint name="elbow"/><joint name="mount"/></group>
<group name="by links"><link name="base"/><link name="upper"/><link name="right"/></group>
<group name="both"><group name="chain"/><group name="fingers"/></group>
<group name="fingers"><joint name="finger_1"/><joint name="finger_2"/></group>
<group name="round"><group name="about"/></group><group name="about"><group name="round"/></group>
<group name="backwards"><chain base_link="tool0" tip_link="base"/></group>
<group name="strange"><joint name="knee"/></group><group name="stranger"><link name="foot"/></group>
</robot>"""


@pytest.mark.parametrize(
    ("group", "joints"),
    [
        ("chain", ("shoulder", "elbow")),
        ("by joints", ("elbow",)),
        ("by links", ("shoulder",)),
        ("both", ("shoulder", "elbow", "finger_1")),
        ("fingers", ("finger_1",)),
    ],
)
def test_a_group_names_the_joints_of_the_task(tmp_path: Path, group: str, joints: tuple[str, ...]) -> None:
    path = write(tmp_path, *hand())
    (tmp_path / "arm.srdf").write_text(SRDF)
    (tmp_path / "other.srdf").write_text(SRDF)
    for srdf in (None, tmp_path / "other.srdf"):
        robot = robot_from_urdf(path, group=group, srdf=srdf)
        assert robot.joint_names == joints
        assert robot.tool == {"shoulder": "tool0", "elbow": "tool0", "finger_1": "left"}[joints[-1]]


def test_the_srdf_that_belongs_to_a_description_is_found(tmp_path: Path) -> None:
    (tmp_path / "urdf").mkdir()
    (tmp_path / "srdf").mkdir()
    urdf = tmp_path / "urdf" / "ur5_robot.urdf"
    assert srdf_beside(urdf) is None
    for name in ("manipulation", "ur5", "ur5_rob", "ur5_gripper"):
        (tmp_path / "srdf" / f"{name}.srdf").touch()
        found = srdf_beside(urdf)
        assert found is not None
        assert found.stem == {"ur5_gripper": "ur5_rob"}.get(name, name)
    assert srdf_beside(urdf.with_name("other.urdf")) is None
    urdf.with_suffix(".srdf").touch()
    assert srdf_beside(urdf) == urdf.with_suffix(".srdf")


@pytest.mark.parametrize(
    ("group", "sentence"),
    [
        ("cain", "group 'cain' does not exist, its groups are chain, .*; did you mean 'chain'"),
        ("round", "hold each other in a circle"),
        ("backwards", "has a chain from 'tool0' to 'base', which arm.urdf has not"),
        ("strange", "names the joint 'knee', which arm.urdf has not"),
        ("stranger", "names the link 'foot', which arm.urdf has not"),
    ],
)
def test_a_group_that_cannot_be_is_refused(tmp_path: Path, group: str, sentence: str) -> None:
    (tmp_path / "arm.srdf").write_text(SRDF)
    with pytest.raises(RobotError, match=rf"arm\.srdf: .*{sentence}"):
        robot_from_urdf(write(tmp_path, *hand()), group=group)


@pytest.mark.parametrize(
    ("frames", "tool"),
    [
        (["ft_frame", "flange", "tool0"], "tool0"),
        (["ee_link", "gripper_tcp", "flange"], "flange"),
        (["ee_link", "gripper_tcp", "camera"], "gripper_tcp"),
        (["camera", "ee_link"], "ee_link"),
        (["left_tool0", "left_ft_frame"], "left_tool0"),
        (["camera", "ft_frame", "laser"], "b"),
    ],
)
def test_the_default_tool_is_the_flange_of_the_last_joint(tmp_path: Path, frames: list[str], tool: str) -> None:
    parts = [link("a", ""), link("b"), joint("j", "a", "b")]
    parts += [link(frame, "") + joint(f"to_{frame}", "b", frame, "fixed") for frame in frames]
    parts += [link("tcp", "") + joint("elsewhere", "a", "tcp", "fixed")]
    assert robot_from_urdf(write(tmp_path, *parts)).tool == tool


def test_named_robots_take_the_same_choices() -> None:
    panda = load_robot("panda")
    assert load_robot("panda", group="arm").joint_names == panda.joint_names
    elbow = load_robot("panda", keep=["panda_joint4", "panda_joint2"])
    assert elbow.joint_names == ("panda_joint2", "panda_joint4") and elbow.tool == panda.tool
    q = np.zeros(7)
    q[[1, 3]] = 0.3, -0.9
    rest = dict(panda.source.lock)
    held = load_robot("panda", lock={f"panda_joint{number}": 0.0 for number in (1, 3, 5, 7)} | {"panda_joint6": 0.5})
    assert dict(held.source.lock)["panda_joint6"] == 0.5 and rest.items() <= dict(held.source.lock).items()
    q[5] = 0.5
    np.testing.assert_allclose(held.pose(q[[1, 3]]), panda.pose(q), atol=1e-12)
    assert load_robot("baxter-left", keep=["right_s0", "right_s1"]).tool == "right_lower_shoulder"
    assert load_robot("ur3", lock=["wrist_3_joint"]).torque_limits[1].tolist() == [56.0, 56.0, 28.0, 12.0, 12.0]


XACRO = """<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:include filename="{include}"/><link name="a"/><xacro:tip/></robot>"""
MACRO = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:property name="n" value="2"/><xacro:macro name="tip">
<link name="b"/><joint name="j${n + 1}" type="revolute"><parent link="a"/><child link="b"/>
<limit lower="-1" upper="${n}"/></joint></xacro:macro></robot>"""


def test_xacro_is_recognised_and_its_absence_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xacro", None)
    for name, text in (("arm.urdf", XACRO), ("arm.urdf.xacro", "<robot/>"), ("arm.xacro", "<robot/>")):
        (tmp_path / name).write_text(text)
        with pytest.raises(RobotError, match=r"is xacro, which `pip install 'ocp-traj\[xacro\]'` lets .*> arm\.urdf`"):
            robot_from_urdf(tmp_path / name)


def test_a_description_made_from_xacro_is_none_any_more(tmp_path: Path) -> None:
    text = '<!-- <xacro:macro/> "${a}" --><robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    (tmp_path / "arm.urdf").write_text(f"{text}{link('a', '')}{link('b')}{joint('j', 'a', 'b')}</robot>")
    assert robot_from_urdf(tmp_path / "arm.urdf").n == 1


def test_xacro_is_expanded_where_the_extra_is_installed(tmp_path: Path) -> None:
    pytest.importorskip("xacrodoc")
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "tip.xacro").write_text(MACRO)
    (tmp_path / "arm.xacro").write_text(XACRO.format(include="parts/tip.xacro"))
    robot = robot_from_urdf(tmp_path / "arm.xacro")
    assert robot.joint_names == ("j3",)
    np.testing.assert_array_equal(robot.position_limits, [[-1.0], [2.0]])
    (tmp_path / "arm.xacro").write_text(XACRO.format(include="nothing.xacro"))
    with pytest.raises(RobotError, match=r"arm\.xacro is xacro that cannot be expanded: No such file"):
        robot_from_urdf(tmp_path / "arm.xacro")


def test_expressions_make_a_file_xacro_only_where_it_says_so() -> None:
    plain = '<robot><plugin filename="$(find x)/y"/></robot>'
    assert not xacro.is_xacro(Path("arm.urdf"), plain)
    assert xacro.is_xacro(Path("arm.urdf"), plain.replace("<robot>", '<robot xmlns:xacro="http://x">'))
