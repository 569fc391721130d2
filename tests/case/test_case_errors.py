"""Every way a case file can be wrong has one sentence: the file, the key, what was given, what was expected."""

from __future__ import annotations

from pathlib import Path

import pytest

import ocp_traj as ot
from ocp_traj.case import load_case_text
from ocp_traj.exceptions import CaseError

GOOD = {
    "schema": "1",
    "name": '"small"',
    "waypoints.joints": "[[0.0, 0.0], [1.0, 0.5], [0.5, 1.0], [0.0, 0.0]]",
    "limits.velocity": "1.0",
}
UR5 = {**GOOD, "robot.model": '"ur5"', "waypoints.joints": "[[0, 0, 0, 0, 0, 0], [1, 0, 0, 0, 0, 0]]"}
DH = "{a = [0, 0], alpha = [0, 0], d = [0, 0], theta = [0, 0], convention = 'modified'}"
POSES = "[[0, 0, 1, 0, 0, 0, 1], [0, 0, 1, 0, 0, 0, 1]]"


def text_of(keys: dict[str, str | None]) -> str:
    return "\n".join(f"{key} = {value}" for key, value in keys.items() if value is not None)


def message(keys: dict[str, str | None], folder: Path | None = None) -> str:
    with pytest.raises(CaseError) as caught:
        load_case_text(text_of(keys), folder=folder)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"schema": None}, "schema: missing, expected a whole number"),
        ({"schema": "2"}, "schema: 2 given, this version reads schema 1"),
        ({"schema": "true"}, "schema: true given, expected a whole number from 0 to 1000000"),
        ({"name": None}, "name: missing, expected a text"),
        ({"name": '"two words"'}, "name: 'two words' given, expected 1 to 100 letters, digits, - and _"),
        ({"name": "3"}, "name: 3 given, expected a text"),
        ({"title": '"\\u001b[31m"'}, "title: holds the control character U+001B, expected plain text"),
        ({"waypoint.joints": "1"}, "waypoint: unknown key, expected one of"),
        ({"waypoint.joints": "1"}, "did you mean 'waypoints'?"),
        (
            {"limits.velocty": "1"},
            "limits.velocty: unknown key, expected one of acceleration, cartesian_speed",
        ),
        ({"limits.velocty": "1"}, "did you mean 'velocity'?"),
        ({"spline": "3"}, "spline: 3 given, expected a table"),
        ({"waypoints.joints": None}, "waypoints: neither joints nor poses given, expected joints or poses"),
        ({"waypoints.joints": "[[0.0, 0.0]]"}, "waypoints.joints: 1 waypoint given, expected 2 to 10000"),
        ({"waypoints.joints": "[0.0, 1.0]"}, "waypoints.joints: expected one row of numbers a waypoint"),
        (
            {"waypoints.joints": "[[0.0, 0.0], [1.0]]"},
            "waypoints.joints[2]: 1 number given, expected 2 numbers as in the first row",
        ),
        (
            {"waypoints.joints": "[[0.0, nan], [1.0, 1.0]]"},
            "waypoints.joints[1][2]: nan given, expected a finite number",
        ),
        (
            {"waypoints.joints": "[[0.0, 0.0], [inf, 1.0]]"},
            "waypoints.joints[2][1]: inf given, expected a finite number",
        ),
        (
            {"waypoints.joints": "[[0.0, 'a'], [1.0, 1.0]]"},
            "waypoints.joints[1][2]: the text 'a' given, expected a number",
        ),
        (
            {"waypoints.joints": "[[0.0, true], [1.0, 1.0]]"},
            "waypoints.joints[1][2]: true given, expected a number",
        ),
        ({"waypoints.joints": "[[], []]"}, "waypoints.joints: rows have 0 numbers, expected 1 to 100"),
        ({"waypoints.joints": "[[1e10], [0]]"}, "waypoints.joints: a coordinate is beyond 1e+09 rad or m"),
        (
            {"waypoints.joints": f"[[1{'0' * 400}], [0]]"},
            "waypoints.joints[1][1]: an enormous whole number given",
        ),
        ({"waypoints.joints": str([[0.0]] * 10_001)}, "10001 waypoints given, expected 2 to 10000"),
        ({"waypoints.joints": str([[0.0] * 101] * 2)}, "rows have 101 numbers, expected 1 to 100"),
        (
            {"waypoints.unit": '"degree"'},
            "waypoints.unit: the text 'degree' given, expected one of rad, deg, m, mm",
        ),
        ({"waypoints.unit": '["deg"]'}, "waypoints.unit: 1 given, expected one, or 2: one a joint"),
        ({"waypoints.start": "[0, 0]"}, "waypoints.start: belongs to poses, but joints are given"),
        ({"waypoints.tolerance": "-0.1"}, "waypoints.tolerance: -0.1 given, expected numbers of 0 or more"),
        (
            {"waypoints.tolerance": "[1]"},
            "waypoints.tolerance: 1 number given, expected a number or 2 numbers or",
        ),
        ({"waypoints.poses": POSES}, "waypoints: joints and poses given, expected joints or poses"),
        (
            {"waypoints.joints": None, "waypoints.poses": POSES},
            "waypoints.poses: need a robot, but the case has no",
        ),
        ({"limits.velocity": "-1.0"}, "limits.velocity: -1 given, expected a limit of 0 or more"),
        (
            {"limits.velocity": "[1, 2, 3]"},
            "limits.velocity: 3 numbers given, expected a number or 2 numbers or 2 rows of 2 numbers",
        ),
        ({"limits.velocity": "nan"}, "limits.velocity: nan given, expected a number"),
        ({"limits.velocity": "'fast'"}, "limits.velocity: the text 'fast' given, expected numbers"),
        ({"limits.velocity": "[]"}, "limits.velocity: 0 numbers given, expected"),
        (
            {"limits.jerk": "[[0, 5], [1, 4]]"},
            "limits.jerk: the lower limit of joint 2, 5, is above its upper, 4",
        ),
        (
            {"limits.jerk": "[[inf, 0], [inf, 1]]"},
            "limits.jerk: a lower limit of inf or an upper one of -inf",
        ),
        ({"limits.jerk": "[[1, 0], [2, 1]]"}, "limits.jerk: the range of every joint must contain 0"),
        ({"limits.position": "0.9"}, "waypoints.joints[2]: joint 1 is at 1, outside its range [-0.9, 0.9]"),
        ({"limits.torque": "1.0"}, "limits.torque: needs a robot with inertia, but this task has none"),
        ({"limits.unit": "['deg', 3]"}, "limits.unit: 3 given, expected one of rad, deg, m, mm"),
        ({"limits.gaps": "[{gap = 4}]"}, "limits.gaps[1].gap: 4 given, expected a whole number from 0 to 3"),
        ({"limits.gaps": "[{gap = 0}]"}, "limits.gaps[1].gap: 0 given, expected each of 1 to 3 at most once"),
        ({"limits.gaps": "[{velocity = 1}]"}, "limits.gaps[1].gap: missing, expected a whole number"),
        ({"limits.gaps": "3"}, "limits.gaps: 3 given, expected a list of tables"),
        ({"limits.gaps": "[3]"}, "limits.gaps[1]: 3 given, expected a table"),
        (
            {"limits.moveit": "'x.yaml'"},
            "limits.moveit: names joints of a robot, but the case has no [robot]",
        ),
        (
            {"limits.cartesian_speed": "[{frame = 'a', speed = 1}]"},
            "limits.cartesian_speed[1].frame: needs a robot",
        ),
        (
            {"limits.cartesian_speed": "[{frame = 'a', speed = 0}]"},
            "speed: 0 given, expected a positive speed, m/s",
        ),
        (
            {"spline.family": "'cubik'"},
            "spline.family: the text 'cubik' given, expected one of cubic, quintic, septic",
        ),
        (
            {"spline.virtual_knots": "-1"},
            "spline.virtual_knots: -1 given, expected a whole number from 0 to 1000",
        ),
        (
            {"spline.virtual_knots": "1.5"},
            "spline.virtual_knots: 1.5 given, expected a whole number from 0 to 1000",
        ),
        (
            {"spline.family": "'3-5-3'", "spline.virtual_knots": "1"},
            "spline.virtual_knots: 1 given, but 3-5-3 takes",
        ),
        (
            {
                "spline.virtual_knots": "1",
                "boundary.acceleration": "'zero'",
                "waypoints.joints": "[[0, 0], [1, 1]]",
            },
            "spline.virtual_knots: 1 leaves fewer free coefficients than conditions, 5 against 6 per joint",
        ),
        (
            {"boundary.velocity": "'free'"},
            "boundary.velocity: 'free' given, expected 'zero' or two rows (start, end)",
        ),
        ({"boundary.jerk": "'none'"}, "boundary.jerk: 'none' given, expected 'zero' or 'free' or two rows"),
        ({"boundary.velocity": "[0, 0]"}, "boundary.velocity: 2 numbers given, expected 2 rows of 2 numbers"),
        (
            {"boundary.velocity": "[[0, inf], [0, 0]]"},
            "boundary.velocity[1][2]: inf given, expected a finite number",
        ),
        ({"objective.time": "-1"}, "objective.time: -1 given, expected a weight of 0 or more"),
        ({"objective.time": "inf"}, "objective.time: inf given, expected a finite number"),
        ({"objective.energy": "1.0"}, "objective.energy: needs a robot with inertia, but this task has none"),
        ({"objective.bounds.duration": "[2, 1]"}, "objective.bounds.duration: expected 0 <= lower <= upper"),
        ({"objective.bounds.duration": "1"}, "objective.bounds.duration: a number given, expected 2 numbers"),
        (
            {"objective.bounds.gap_durations": "[[1, 2]]"},
            "1 row of 2 numbers given, expected 3 rows of 2 numbers",
        ),
        ({"search.duration": "[0, 1]"}, "search.duration: expected two finite positive numbers"),
        ({"search.offset": "0"}, "search.offset: 0.0 given, expected a finite positive number"),
        ({"search.offset": "inf"}, "search.offset: inf given, expected a finite"),
        (
            {"search.protocol": "'each'"},
            "search.protocol: the text 'each' given, expected one of shared, per-joint",
        ),
    ],
)
def test_a_wrong_case_is_refused_with_one_sentence(changes: dict[str, str | None], sentence: str) -> None:
    found = message({**GOOD, **changes})
    assert found.startswith("<text>: ")
    assert sentence in found


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"robot.model": "'ur55'"}, "robot.model: robot 'ur55' is unknown, expected one of "),
        ({"robot.model": "'ur55'"}, "did you mean 'ur5'?"),
        ({"robot.model": None}, "waypoints"),
        ({"robot.urdf": "'a.urdf'"}, "robot: model and urdf given, expected exactly one of model, urdf, dh"),
        (
            {"robot.model": None, "robot.tool": "'x'"},
            "robot: none given, expected exactly one of model, urdf, dh",
        ),
        ({"robot.lock": "['x']"}, "joint 'x' does not exist in 'ur5', its joints are shoulder_pan_joint, "),
        ({"robot.modell": "'ur5'"}, "robot.modell: unknown key"),
        ({"robot.tool": "'nothing'"}, "robot.tool: "),
        ({"robot.base": "'nothing'"}, "robot.base: "),
        ({"robot.gravity": "[0, 0]"}, "robot.gravity: 2 numbers given, expected 3 numbers"),
        ({"robot.payload": "{com = [0, 0, 0]}"}, "robot.payload.mass: missing, expected a number"),
        ({"robot.payload": "{mass = -1}"}, "robot.payload: payload mass is -1.0 kg"),
        (
            {"robot.friction": "{viscous = [1]}"},
            "robot.friction.viscous: 1 number given, expected a number or 6 numbers",
        ),
        ({"robot.friction": "{viscous = -1}"}, "robot.friction: viscous friction is"),
        (
            {"robot.motor": "{torque_constant = 0, resistance = 1}"},
            "robot.motor.torque_constant: 0 given, expected positive numbers",
        ),
        ({"objective.motor_loss": "1"}, "objective.motor_loss: needs the motors' parameters in robot.motor"),
        ({"limits.cartesian_speed": "[{frame = 'x', speed = 1}]"}, "limits.cartesian_speed[1].frame: "),
        (
            {"waypoints.unit": "'m'"},
            "waypoints.unit: 'm' does not fit joint 1, which turns: expected a list with 'rad'",
        ),
        (
            {"waypoints.joints": "[[0], [1]]"},
            "waypoints.joints: rows have 1 numbers, expected 6, the joints of ur5",
        ),
        (
            {"waypoints.joints": None, "waypoints.poses": "[[0], [1]]"},
            "rows have 1 numbers, expected 7: x, y, z, qx",
        ),
    ],
)
def test_a_wrong_robot_is_refused_with_one_sentence(changes: dict[str, str | None], sentence: str) -> None:
    keys = {**UR5, **changes}
    if keys["robot.model"] is None and len(changes) == 1:
        keys["waypoints.joints"] = "[[0], []]"
    assert sentence in message(keys)


@pytest.mark.parametrize(
    ("dh", "sentence"),
    [
        (
            DH.replace("modified", "craig"),
            "robot.dh.convention: the text 'craig' given, expected one of standard",
        ),
        (DH.replace("d = [0, 0]", "d = [0]"), "robot.dh.d: 1 number given, expected 2 numbers"),
        (
            DH.replace("a = [0, 0]", "a = 0", 1),
            "robot.dh.a: expected a list of 1 to 100 numbers, one a joint",
        ),
        (DH.replace("{", "{unit = 'mm', "), "robot.dh.unit: the text 'mm' given, expected one of rad, deg"),
        (
            DH.replace("{", "{joints = ['turn', 'slide'], "),
            "robot.dh.joints: expected 2 of 'revolute' or 'prismatic'",
        ),
        (DH.replace("{", "{offset = [0, 0], "), "robot.dh.offset: unknown key"),
        ("3", "robot.dh: 3 given, expected a table"),
    ],
)
def test_a_wrong_dh_table_is_refused_with_one_sentence(dh: str, sentence: str) -> None:
    assert sentence in message({**GOOD, "robot.dh": dh})


def test_a_case_that_does_not_exist_lists_those_that_do(tmp_path: Path) -> None:
    with pytest.raises(
        CaseError, match=r"ur5-palletising: does not exist; .*did you mean 'ur5-palletizing'\?"
    ):
        ot.load_case("ur5-palletising")
    with pytest.raises(CaseError, match="is not a regular file"):
        ot.load_case(tmp_path)
    with pytest.raises(CaseError, match="is no path, it holds a null character"):
        ot.load_case("a\0b")
    with pytest.raises(CaseError, match=r"cannot be read \(File name too long\)"):
        ot.load_case("a" * 5000)


def test_a_file_that_is_no_toml_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_bytes(b"schema = 1\n\xff\xfe")
    with pytest.raises(CaseError, match=r"case\.toml: is not UTF-8 text \(byte 11\)"):
        ot.load_case(path)
    path.write_text("schema = 1\nname = \n")
    with pytest.raises(CaseError, match=r"case\.toml: is not TOML: .*line 2"):
        ot.load_case(path)
    path.write_text("name = " + "[" * 100_000)
    with pytest.raises(CaseError, match=r"case\.toml: is n"):
        ot.load_case(path)
    path.write_bytes(b"#" * 10_000_001)
    with pytest.raises(CaseError, match=r"case\.toml: is larger than 10 MB"):
        ot.load_case(path)


@pytest.mark.parametrize("path", ["/etc/hostname", "../arm.urdf", "a/../../arm.urdf"])
def test_a_path_that_leads_out_of_the_folder_is_refused(path: str, tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text("<robot name='x'/>")
    folder = tmp_path / "inner"
    folder.mkdir()
    found = message({**UR5, "robot.model": None, "robot.urdf": f"'{path}'"}, folder)
    assert (
        f"robot.urdf: '{path}' leads out of the case's folder, expected a path relative to and below it"
        in found
    )


def test_a_link_that_leads_out_of_the_folder_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "inner"
    folder.mkdir()
    (folder / "arm.urdf").symlink_to("/etc/hostname")
    found = message({**UR5, "robot.model": None, "robot.urdf": "'arm.urdf'"}, folder)
    assert "leads out of the case's folder" in found


def test_a_urdf_that_cannot_be_used_is_refused(tmp_path: Path) -> None:
    keys = {**UR5, "robot.model": None, "robot.urdf": "'arm.urdf'"}
    assert "robot.urdf: 'arm.urdf' does not exist beside the case" in message(keys, tmp_path)
    (tmp_path / "arm.urdf").write_text("<not a urdf")
    assert "robot.urdf: robot description" in message(keys, tmp_path)


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        (
            f"waypoints.poses={[[0.4, 0.1, 0.3, 0, 0, 0, 1], [5, 0, 0, 0, 0, 0, 1]]}",
            "waypoints.poses: waypoint 2 at (5, 0, 0) m is out of reach",
        ),
        (
            f"waypoints.poses={[[0.4, 0.1, 0.3, 0, 0, 0, 1], [0.4, 0, 0.3, 0, 0, 0, 2]]}",
            "waypoint 2 has norm 2",
        ),
        (
            f"waypoints.poses={[[0.4, 0.1, 0.3, 0, 0, 0, 1], [1e12, 0, 0.3, 0, 0, 0, 1]]}",
            "a coordinate is beyond 1e+09 m",
        ),
        ("waypoints.start=[0.0]", "waypoints.start: 1 number given, expected 6 numbers"),
        ("waypoints.weights=[1, 1, 1, 1, 1, 0]", "waypoints.weights: 0 given, expected positive numbers"),
        ("waypoints.unit='deg'", "waypoints.unit: belongs to joints, but poses are given"),
        (
            "limits.position=[[230, 4, 4, 4, 4, 4], [340, 8, 8, 8, 8, 8]]",
            "is reached only outside of the joint limits",
        ),
        (
            "limits.position=[[700, 7, 7, 7, 7, 7], [800, 8, 8, 8, 8, 8]]",
            "limits.position: the range of joint 1 and the",
        ),
    ],
)
def test_a_wrong_pose_is_refused_with_one_sentence(override: str, sentence: str) -> None:
    with pytest.raises(CaseError) as caught:
        ot.load_case("ur5-helix", [override])
    assert sentence in str(caught.value)
