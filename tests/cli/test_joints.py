"""``ocp-traj list joints`` and ``check``: joints by name, the numbers of their limits and where each comes from."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import ocp_traj as ot
from helpers.folders import ROOT
from ocp_traj.cli.main import run

FAULTS = ROOT / "tests" / "data" / "faults"

FINGERS = """<robot name="grasper"><link name="base"/>{links}
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="9" velocity="2"/></joint>
<joint name="left" type="prismatic"><parent link="arm"/><child link="l"/><axis xyz="0 1 0"/>
<limit lower="0" upper="0.1" effort="9" velocity="2"/></joint>
<joint name="right" type="prismatic"><parent link="arm"/><child link="r"/><axis xyz="0 -1 0"/>
<limit lower="0" upper="0.1" effort="9" velocity="2"/></joint></robot>""".format(
    links="".join(
        f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        "</inertial></link>"
        for name in ("arm", "l", "r")
    )
)


def printed(capsys: pytest.CaptureFixture[str], *arguments: str, status: int = 0) -> str:
    assert run(list(arguments)) == status
    out, err = capsys.readouterr()
    return err if status else out


def case(folder: Path, robot: str, rows: str, *more: str) -> str:
    path = folder / "case.toml"
    lines = ["schema = 1", 'name = "own"', f"waypoints.joints = {rows}", *more, "[robot]", robot]
    path.write_text("\n".join(lines) + "\n")
    return str(path)


def test_joints_of_a_case_come_with_numbers_and_their_source(capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "list", "joints", "ur5-palletizing")
    assert text == "".join(
        line[2:] + "\n"
        for line in printed(capsys, "check", "ur5-palletizing").splitlines()
        if line[:2] == "  " and (line[2:3].isdigit() or line.startswith("  tool"))
    )
    first = text.splitlines()[0]
    assert first.startswith("1 shoulder_pan_joint (revolute): position ±6.28319 rad (robot), velocity ±3.14159 rad/s")
    assert "torque ±150 N m (robot), torque rate not given" in first
    assert "tool tool0, base " in text


def test_joints_as_json_are_the_limits_of_the_task(capsys: pytest.CaptureFixture[str]) -> None:
    found = json.loads(printed(capsys, "list", "joints", "ur5-palletizing", "--json"))
    task = ot.load_case("ur5-palletizing")
    assert found["schema"] == 1 and (found["tool"], found["robot"]) == ("tool0", "ur5")
    for index, joint in enumerate(found["joints"]):
        assert (joint["number"], joint["name"]) == (index + 1, task.robot.joint_names[index])
        for name in task.limits.names:
            limit, (lower, upper) = joint["limits"][name], task.limits.get(name)[0, :, index]
            if limit["from"] == "not given":
                assert limit["lower"] is limit["upper"] is None and np.isinf([lower, upper]).all()
            else:
                assert (limit["lower"], limit["upper"]) == (lower, upper)
    assert joint["limits"]["torque"]["unit"] == "N m" and joint["limits"]["torque"]["from"] == "robot"


def test_joints_of_a_description_and_of_a_named_robot(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "arm.urdf").write_text(FINGERS)
    found = json.loads(printed(capsys, "list", "joints", str(tmp_path / "arm.urdf"), "--json"))
    assert [joint["name"] for joint in found["joints"]] == ["turn", "left", "right"]
    assert found["joints"][1]["limits"]["position"] == {"lower": 0.0, "upper": 0.1, "unit": "m", "from": "robot"}
    assert found["joints"][0]["limits"]["jerk"]["from"] == "not given"
    panda = json.loads(printed(capsys, "list", "joints", "panda", "--json"))
    assert panda["held"] == {"panda_finger_joint1": 0.0, "panda_finger_joint2": 0.0}
    text = printed(capsys, "list", "joints", "panda")
    assert "held still: panda_finger_joint1 at 0, panda_finger_joint2 at 0" in text


def test_a_case_without_a_robot_has_numbered_joints(capsys: pytest.CaptureFixture[str]) -> None:
    task = ot.load_case("yu-2025-four-points")
    text = printed(capsys, "list", "joints", "yu-2025-four-points")
    if task.robot is None:
        assert text.startswith("1 joint: ")
    assert len([line for line in text.splitlines() if line[:1].isdigit()]) == task.n


def test_limits_of_single_gaps_and_those_left_open_say_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = "[[0, 0, 0, 0, 0, 0], [1, 0, 0, 0, 0, 0], [2, 0, 0, 0, 0, 0]]"
    limits = ("limits.velocity = 3.15", "limits.torque = inf", "limits.gaps = [{ gap = 2, velocity = 1.0 }]")
    text = printed(capsys, "check", case(tmp_path, 'model = "ur5"', rows, *limits))
    assert "velocity ±3.15 rad/s (case, differs between gaps)" in text and "torque none (case)" in text


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["list", "joints"], "list joints: expected a case or a robot description"),
        (["list", "joints", "nothing"], "nothing: does not exist"),
        (["list", "joints", "nothing.urdf"], "robot description nothing.urdf does not exist"),
        (["list", "cases", "ur5"], "ur5 given, which belongs to `list joints CASE|URDF`"),
    ],
)
def test_wrong_arguments_are_one_sentence(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = printed(capsys, *arguments, status=2)
    assert text.startswith(f"ocp-traj: {sentence}") and text.count("\n") == 1


def test_rows_of_a_wrong_length_name_the_joints_and_the_way_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "arm.urdf").write_text(FINGERS)
    text = printed(capsys, "check", case(tmp_path, 'urdf = "arm.urdf"', "[[0.0], [1.0]]"), status=2)
    assert (
        "waypoints.joints: rows have 1 numbers, expected 3, the joints of grasper: turn, left, right; hold those "
        'that do not belong to the task with robot.lock, for instance ["left", "right"], or name those that do in '
        "robot.keep"
    ) in text
    robot = 'urdf = "arm.urdf"\nlock = ["left", "right"]'
    assert "held still: left at 0, right at 0" in printed(capsys, "check", case(tmp_path, robot, "[[0.0], [1.0]]"))
    text = printed(capsys, "check", case(tmp_path, robot, "[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]"), status=2)
    assert "rows have 3 numbers, expected 1, the joints of grasper: turn; left, right are held still" in text


@pytest.mark.parametrize(
    "robot",
    [
        'urdf = "arm.urdf"\nkeep = ["turn"]\nlock = { left = 0.05 }',
        'urdf = "arm.urdf"\nlock = { left = 0.05, right = 0.0 }',
        'urdf = "arm.urdf"\nsrdf = "groups.srdf"\ngroup = "arm"\nlock = { left = 0.05 }',
    ],
)
def test_chosen_joints_survive_writing(tmp_path: Path, robot: str) -> None:
    (tmp_path / "arm.urdf").write_text(FINGERS)
    (tmp_path / "groups.srdf").write_text('<robot name="g"><group name="arm"><joint name="turn"/></group></robot>')
    task = ot.load_case(case(tmp_path, robot, "[[0.0], [1.0]]"))
    assert task.robot.joint_names == ("turn",) and task.robot.pose([0.0], "l")[1, 3] == 0.05
    ot.write_case(task, tmp_path / "copy.toml")
    assert ot.load_case(tmp_path / "copy.toml").robot == task.robot


def test_chosen_joints_of_a_named_robot_survive_writing(tmp_path: Path) -> None:
    robot = 'model = "panda"\nlock = { panda_joint3 = 0.4, panda_finger_joint1 = 0.02 }'
    task = ot.load_case(case(tmp_path, robot, "[[0, 0, -1, 0, 1, 0], [0, 0.1, -1, 0, 1, 0]]"))
    assert task.n == 6
    ot.write_case(task, tmp_path / "copy.toml")
    copy = ot.load_case(tmp_path / "copy.toml")
    assert copy.robot == task.robot and dict(copy.robot.source.lock) == dict(task.robot.source.lock)


@pytest.mark.parametrize(
    ("robot", "sentence"),
    [
        ('model = "ur5"\nlock = ["elbow"]', "robot.model: .*joint 'elbow' does not exist"),
        ('model = "ur5"\nlock = 3', "robot.lock: 3 given, expected a list of texts"),
        ('model = "ur5"\nlock = { elbow_joint = "x" }', "robot.lock.elbow_joint: the text 'x' given"),
        ('model = "ur5"\nsrdf = "no.srdf"\ngroup = "a"', "robot.srdf: 'no.srdf' does not exist beside the case"),
        (
            'dh = { convention = "standard", a = [1], alpha = [0], d = [0], theta = [0] }\nkeep = ["joint_1"]',
            "robot.keep: chooses joints of a urdf or model",
        ),
    ],
)
def test_wrong_choices_name_the_key(tmp_path: Path, robot: str, sentence: str) -> None:
    with pytest.raises(ot.CaseError, match=sentence):
        ot.load_case(case(tmp_path, robot, "[[0.0], [1.0]]"))


# What each description of tests/data/faults is for, and what `check` says of it.
CHECKED = {
    "continuous-minus-z": "j1 (continuous): position not given, velocity ±2 rad/s (robot)",
    "no-inertia": "torque limits of the robot are left out: j1, j2 move no mass, so torques are not known",
    "velocity-zero": "1 j1 (revolute): position ±2 rad (robot), velocity not given",
    "effort-zero": "torque not given",
    "mimic": "j2 follows j1: -1 times its position, plus 0",
}
REFUSED = {
    "zero-axis": "joint 'j1' has the axis '0 0 0', expected a direction",
    "lower-above-upper2": "joint 'j1' has the lower limit 2 above its upper limit -2",
}


@pytest.mark.parametrize("name", CHECKED)
def test_odd_descriptions_are_checked_solved_and_audited(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(FAULTS / f"{name}.toml")
    assert CHECKED[name] in printed(capsys, "check", path)
    result = ot.solve(ot.load_case(path), "ipopt")
    assert result.audit.feasible


@pytest.mark.parametrize("name", REFUSED)
def test_impossible_descriptions_are_refused(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("check", "solve"):
        text = printed(capsys, command, str(FAULTS / f"{name}.toml"), status=2)
        assert REFUSED[name] in text and text.count("\n") == 1


def test_torque_limits_that_the_case_names_need_masses(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ot.CaseError, match=r"limits\.torque: needs a robot with inertia"):
        ot.load_case(FAULTS / "no-inertia.toml", ["limits.torque=5.0"])
    left_out = json.loads(printed(capsys, "list", "joints", str(FAULTS / "no-inertia.toml"), "--json"))
    assert left_out["joints"][0]["limits"]["torque"]["from"] == "left out"
    robot = ot.load_case(FAULTS / "no-inertia.toml").robot
    assert not ot.TrajectoryTask(np.array([[0.0, 0.0], [1.0, 1.0]]), robot=robot).limited("torque")


def test_a_continuous_joint_goes_the_short_way_when_asked(capsys: pytest.CaptureFixture[str]) -> None:
    path = str(FAULTS / "continuous-minus-z.toml")
    hint = "j1 is continuous and goes 4 rad from waypoint 1 to 2; the short way is -2.283 rad"
    assert f'{hint}: waypoints.continuous = "short"' in printed(capsys, "check", path)
    short = ["--set", "waypoints.continuous=short"]
    assert "short way" not in printed(capsys, "check", path, *short)
    task = ot.load_case(path, ["waypoints.continuous=short"])
    np.testing.assert_allclose(task.waypoints, [[0.0, 0.0], [4.0 - 2.0 * np.pi, 1.0]])
    many = ["waypoints.joints=[[3.1, 0.0], [-3.1, 1.0], [3.1, 0.0], [9.0, 0.0]]", "waypoints.continuous=short"]
    turns = ot.load_case(path, many).waypoints
    np.testing.assert_allclose(turns[:, 0], [3.1, 2 * np.pi - 3.1, 3.1, 9.0 - 2 * np.pi])
    np.testing.assert_array_equal(turns[:, 1], [0.0, 1.0, 0.0, 0.0])
    with pytest.raises(ot.CaseError, match="'short' given, but the case has no robot with a continuous joint"):
        ot.load_case("ur5-palletizing", ["waypoints.continuous=short"])


def test_limits_of_acceleration_and_jerk_in_a_description_hold(tmp_path: Path) -> None:
    text = FINGERS.replace('lower="-1"', 'acceleration="3" jerk="40" lower="-1"')
    (tmp_path / "arm.urdf").write_text(text)
    robot = 'urdf = "arm.urdf"\nkeep = ["turn"]'
    task = ot.load_case(case(tmp_path, robot, "[[0.0], [1.0]]", "spline.virtual_knots = 3"))
    assert task.limits.acceleration[0, :, 0].tolist() == [-3.0, 3.0]
    assert task.limits.jerk[0, :, 0].tolist() == [-40.0, 40.0]
    verdict = ot.solve(task, "ipopt").audit
    assert verdict.feasible and verdict.limits["acceleration"].ratio > 0.99
