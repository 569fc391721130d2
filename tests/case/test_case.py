"""Case files: what is read, what is refused and in which words, and that writing and reading agree."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ocp_traj as ot
from ocp_traj.case import case_template, case_title, dumps, load_case_text
from ocp_traj.exceptions import CaseError, TaskError

SMALL = """
schema = 1
name = "small"
[waypoints]
joints = [[0.0, 0.0], [1.0, 0.5], [0.5, 1.0]]
[limits]
velocity = 1.0
"""

DH = """
schema = 1
name = "slider"
[robot.dh]
convention = "modified"
unit = "deg"
a = [0.0, 0.5, 0.0]
alpha = [0.0, -90.0, 90.0]
d = [0.3, 0.0, 0.1]
theta = [0.0, 30.0, 0.0]
joints = ["revolute", "revolute", "prismatic"]
[waypoints]
unit = ["deg", "rad", "mm"]
joints = [[0.0, 0.0, 0.0], [90.0, 0.5, 250.0]]
"""

URDF = """<robot name="one"><link name="base"/><link name="arm"><inertial><mass value="2"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" velocity="2" effort="10"/></joint></robot>
"""


def read(text: str, *overrides: str, folder: Path | None = None) -> ot.TrajectoryTask:
    return load_case_text(text, overrides, folder)


@pytest.mark.parametrize("name", ot.case_names())
def test_every_packaged_case_loads_under_its_own_name(name: str) -> None:
    task = ot.load_case(name)
    assert task.name == name
    assert case_title(name) == task.title != ""
    assert task.source


@pytest.mark.parametrize("name", ot.case_names())
def test_a_written_case_reads_back_as_the_same_task(name: str, tmp_path: Path) -> None:
    task = ot.load_case(name)
    ot.write_case(task, tmp_path / "copy.toml")
    copy = ot.load_case(tmp_path / "copy.toml")
    assert ot.task_digest(copy) == ot.task_digest(task)
    assert (copy.title, copy.source) == (task.title, task.source)
    np.testing.assert_array_equal(copy.waypoints, task.waypoints)


def test_the_template_is_a_case() -> None:
    task = load_case_text(case_template())
    assert (task.robot.name, task.gaps, task.virtual_knots) == ("ur5", 2, 3)


def test_units_become_si() -> None:
    task = ot.load_case("machines-2024-490")
    np.testing.assert_allclose(task.waypoints[1], np.deg2rad([0, -30, -30, 30, 0, 0]), rtol=1e-15)
    velocity = np.deg2rad([150.0, 180, 210, 360, 360, 450])
    np.testing.assert_allclose(task.limits.velocity, np.broadcast_to([-velocity, velocity], (3, 2, 6)))
    np.testing.assert_allclose(np.asarray(task.limits.position)[0, 0, 0], np.deg2rad(-150.0))
    assert not task.limited("jerk")
    assert not task.has_inertia


def test_a_list_of_units_serves_turning_and_sliding_joints() -> None:
    task = read(DH)
    assert task.robot.joint_types == ("revolute", "revolute", "prismatic")
    np.testing.assert_allclose(task.waypoints[1], [np.pi / 2, 0.5, 0.25])
    assert ot.task_digest(read(dumps(task))) == ot.task_digest(task)


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_a_dh_table_survives_writing(convention: str) -> None:
    task = read(DH, f"robot.dh.convention={convention}", "robot.base=base", "robot.gravity=[0, 0, 9.81]")
    copy = read(dumps(task))
    q = np.array([0.3, -0.7, 0.2])
    np.testing.assert_allclose(copy.robot.pose(q), task.robot.pose(q), atol=1e-14)
    assert copy.robot.digest() == task.robot.digest()


def test_what_a_case_leaves_out_comes_from_the_robot() -> None:
    task = ot.load_case("ur5-palletizing")
    np.testing.assert_array_equal(np.asarray(task.limits.torque)[3], task.robot.torque_limits)
    np.testing.assert_array_equal(np.asarray(task.limits.position)[3], task.robot.position_limits)
    unlimited = ot.load_case("ur5-palletizing", ["limits.torque=inf"])
    assert task.limited("torque")
    assert not unlimited.limited("torque")
    assert not read(dumps(unlimited)).limited("torque")


def test_the_robot_stands_in_the_cell_as_the_case_says() -> None:
    overrides = [
        "robot.payload={mass = 2.0, com = [0.0, 0.0, 0.05]}",
        "robot.gravity=[0.0, 0.0, 9.81]",
        "robot.friction={viscous = 0.5, coulomb = [1, 1, 1, 0, 0, 0]}",
        "robot.tool=ee_link",
        "robot.motor={torque_constant = 0.1, resistance = 1.0, gear_ratio = 100}",
        "objective.motor_loss=0.5",
    ]
    task = ot.load_case("ur5-torque-limited", overrides)
    assert (task.robot.payload.mass, task.robot.tool) == (2.0, "ee_link")
    np.testing.assert_array_equal(task.robot.gravity, [0.0, 0.0, 9.81])
    np.testing.assert_array_equal(task.robot.friction.viscous, np.full(6, 0.5))
    np.testing.assert_array_equal(task.robot.friction.coulomb, [1, 1, 1, 0, 0, 0])
    np.testing.assert_array_equal(task.objective.motor.gear_ratio, np.full(6, 100.0))
    copy = read(dumps(task))
    assert ot.task_digest(copy) == ot.task_digest(task)
    assert ot.task_digest(task) != ot.task_digest(ot.load_case("ur5-torque-limited"))


def test_single_gaps_have_limits_of_their_own() -> None:
    text = SMALL + "[[limits.gaps]]\ngap = 2\nvelocity = [0.5, 0.25]\njerk = 9.0\n"
    task = read(text)
    velocity = np.asarray(task.limits.velocity)
    np.testing.assert_array_equal(velocity[0], [[-1, -1], [1, 1]])
    np.testing.assert_array_equal(velocity[1], [[-0.5, -0.25], [0.5, 0.25]])
    np.testing.assert_array_equal(np.asarray(task.limits.jerk)[:, 1, 0], [np.inf, 9.0])
    assert ot.task_digest(read(dumps(task))) == ot.task_digest(task)


def test_a_gap_s_limit_leaves_the_other_gaps_to_the_robot_if_it_has_one() -> None:
    robot = '[robot]\nmodel = "ur5"\n'
    rows = "[[0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.1, 0.1, 0.1, 0.1, 0.1, 0.1], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]"
    head = f'schema = 1\nname = "small"\n{robot}[waypoints]\njoints = {rows}\n[limits]\n'
    task = read(head + "[[limits.gaps]]\ngap = 1\ntorque = 20.0\nacceleration = 3.0\nvelocity = 0.5\n")
    for name, default in (("torque", task.robot.torque_limits), ("velocity", task.robot.velocity_limits)):
        np.testing.assert_array_equal(task.limits.get(name)[1], default)
    assert task.limits.get("torque")[0].tolist() == [[-20.0] * 6, [20.0] * 6]
    assert task.limits.get("velocity")[0].tolist() == [[-0.5] * 6, [0.5] * 6]
    np.testing.assert_array_equal(task.limits.get("acceleration")[:, 1], [[3.0] * 6, [np.inf] * 6])
    bare = read(SMALL.replace("velocity = 1.0", "[[limits.gaps]]\ngap = 1\nvelocity = 0.5"))
    np.testing.assert_array_equal(bare.limits.get("velocity")[:, 0], [[-0.5] * 2, [-np.inf] * 2])


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("velocity = [[-1.0, 2.0], [1.0, 1.0]]", "the lower limit of joint 2, 2, is above its upper, 1"),
        ("velocity = [[1.0, 2.0], [1.0, 1.0]]", "the lower limit of joint 2, 2, is above its upper, 1"),
        ("velocity = [[2.0, 1.0], [1.0, 1.0]]", "the lower limit of joint 1, 2, is above its upper, 1"),
        ("velocity = [1.0, -2.0]", "-2 given, expected a limit of 0 or more"),
        (
            "position = [[inf, -1.0], [inf, 2.0]]",
            "a lower limit of inf or an upper one of -inf leaves nothing",
        ),
        (
            "position = [[-inf, -1.0], [-inf, 2.0]]",
            "a lower limit of inf or an upper one of -inf leaves nothing",
        ),
    ],
)
def test_sides_of_limits_that_leave_nothing_are_refused(line: str, problem: str) -> None:
    with pytest.raises(ot.CaseError, match=problem):
        read(SMALL.replace("velocity = 1.0", line))


def test_tolerances_duration_bounds_and_moving_ends_are_read_and_written() -> None:
    text = SMALL.replace("joints", "tolerance = 0.01\njoints") + (
        "[boundary]\nunit = 'deg'\nvelocity = [[0, 90], [0, 0]]\nacceleration = 'zero'\njerk = 'free'\n"
        "[objective]\nacceleration = 0.5\n[objective.bounds]\nduration = [1, 20]\n"
        "gap_durations = [[0, 1], [0.5, 0.5]]\n[search]\nprotocol = 'per-joint'\n"
        "[spline]\nfamily = 'quintic'\nvirtual_knots = 2"
    )
    task = read(text)
    np.testing.assert_array_equal(task.tolerance, np.full((3, 2), 0.01))
    np.testing.assert_allclose(task.boundary.velocity, [[0, np.pi / 2], [0, 0]])
    np.testing.assert_array_equal(task.boundary.acceleration, np.zeros((2, 2)))
    assert task.boundary.jerk is None
    assert (task.objective.time, task.objective.acceleration) == (0.0, 0.5)
    np.testing.assert_array_equal(task.objective.gap_durations, [[0, 1], [0.5, 0.5]])
    assert (task.family, task.virtual_knots, task.search.protocol) == ("quintic", 2, "per-joint")
    assert ot.task_digest(read(dumps(task))) == ot.task_digest(task)


def test_the_speed_of_a_frame_is_limited_by_name() -> None:
    task = ot.load_case("ur5-torque-limited", ["limits.cartesian_speed=[{frame = 'tool0', speed = 0.25}]"])
    assert task.limits.cartesian_speed == (("tool0", 0.25),)
    assert ot.task_digest(read(dumps(task))) == ot.task_digest(task)


def test_a_urdf_lies_beside_the_case(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(URDF)
    text = 'schema = 1\nname = "one"\nrobot.urdf = "arm.urdf"\nwaypoints.joints = [[0.0], [1.0]]\n'
    (tmp_path / "one.toml").write_text(text)
    task = ot.load_case(tmp_path / "one.toml")
    assert task.robot.joint_names == ("turn",)
    np.testing.assert_array_equal(np.asarray(task.limits.velocity)[0], [[-2.0], [2.0]])
    ot.write_case(task, tmp_path / "copy.toml")
    assert ot.task_digest(ot.load_case(tmp_path / "copy.toml")) == ot.task_digest(task)
    (tmp_path / "elsewhere").mkdir()
    with pytest.raises(TaskError, match=r"arm\.urdf does not lie below the folder of the case file"):
        ot.write_case(task, tmp_path / "elsewhere" / "copy.toml")


def test_locked_joints_of_a_urdf_survive_writing(tmp_path: Path) -> None:
    second = URDF.replace("</robot>", "").replace('"one"', '"two"') + (
        '<link name="hand"/><joint name="grip" type="prismatic"><parent link="arm"/><child link="hand"/>'
        '<axis xyz="0 0 1"/><limit lower="0" upper="1" velocity="1" effort="1"/></joint></robot>'
    )
    (tmp_path / "arm.urdf").write_text(second)
    text = 'schema = 1\nname = "two"\nwaypoints.joints = [[0.0], [1.0]]\n'
    text += '[robot]\nurdf = "arm.urdf"\nlock = ["grip"]\n'
    task = read(text, folder=tmp_path)
    copy = read(dumps(task, tmp_path), folder=tmp_path)
    assert copy.robot.joint_names == ("turn",)
    assert ot.task_digest(copy) == ot.task_digest(task)


def test_an_arm_of_a_file_is_written_as_such_whatever_its_name(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(URDF)
    robot = replace(ot.robot_from_urdf(tmp_path / "arm.urdf"), name="ur5")
    task = ot.TrajectoryTask(np.array([[0.0], [1.0]]), robot=robot)
    assert 'urdf = "arm.urdf"' in dumps(task, tmp_path)


def test_limits_that_the_named_arm_has_not_are_written() -> None:
    weak = replace(ot.load_robot("ur5"), torque_limits=np.array([[-9.0] * 6, [9.0] * 6]))
    task = ot.TrajectoryTask(np.array([np.zeros(6), np.ones(6)]), robot=weak)
    np.testing.assert_array_equal(read(dumps(task)).limits.torque, task.limits.torque)


def test_an_arm_put_together_by_hand_cannot_be_written() -> None:
    task = ot.TrajectoryTask(
        np.array([np.zeros(6), np.ones(6)]), robot=replace(ot.load_robot("ur5"), source=None)
    )
    with pytest.raises(TaskError, match="'ur5' came neither by name nor from a URDF nor from a DH table"):
        dumps(task)


def test_limits_come_from_a_moveit_file_unless_the_case_has_its_own(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(URDF)
    (tmp_path / "limits.yaml").write_text(
        "joint_limits:\n  turn: {has_velocity_limits: true, max_velocity: 1.5,"
        " has_acceleration_limits: true, max_acceleration: 4.0}\n"
    )
    text = 'schema = 1\nname = "one"\nrobot.urdf = "arm.urdf"\nwaypoints.joints = [[0.0], [1.0]]\n'
    text += '[limits]\nmoveit = "limits.yaml"\nunit = "deg"\n'
    task = read(text, folder=tmp_path)
    assert np.asarray(task.limits.velocity)[0, 1, 0] == 1.5
    assert np.asarray(task.limits.acceleration)[0, 0, 0] == -4.0
    own = read(text + "velocity = 45.0\n", folder=tmp_path)
    assert np.asarray(own.limits.velocity)[0, 1, 0] == np.deg2rad(45.0)
    assert np.asarray(own.limits.acceleration)[0, 1, 0] == 4.0
    (tmp_path / "limits.yaml").write_text("joint_limits: {bend: {max_velocity: 1}}")
    with pytest.raises(CaseError, match=r"limits\.moveit: .*names the joints bend, none of which"):
        read(text, folder=tmp_path)
    with pytest.raises(CaseError, match=r"limits\.moveit: '\.\./x\.yaml' leads out of the case's folder"):
        read(text.replace("limits.yaml", "../x.yaml"), folder=tmp_path)


def test_a_path_set_by_hand_may_lead_anywhere(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(URDF)
    (tmp_path / "case").mkdir()
    text = 'schema = 1\nname = "one"\nwaypoints.joints = [[0.0], [1.0]]\n'
    task = read(text, f"robot.urdf='{tmp_path / 'arm.urdf'}'", folder=tmp_path / "case")
    assert task.robot.n == 1


@pytest.mark.parametrize(
    ("override", "look"),
    [
        ("spline.virtual_knots=3", lambda task: task.virtual_knots == 3),
        ("spline.family=cubic", lambda task: task.family == "cubic"),
        ("spline.family='quintic'", lambda task: task.family == "quintic"),
        ("limits.velocity = 1.5", lambda task: np.asarray(task.limits.velocity).max() == np.deg2rad(1.5)),
        ("limits.jerk=[1, 1, 1, 1, 1, 2]", lambda task: task.limited("jerk")),
        ("objective.bounds.duration=[1, 2]", lambda task: list(task.objective.duration) == [1, 2]),
        ("search.protocol=per-joint", lambda task: task.search.protocol == "per-joint"),
        ("boundary.velocity=zero", lambda task: task.boundary.is_rest),
        ("name=other", lambda task: task.name == "other"),
        ("robot.dh.a=[0, 0.3, 0.7, 0.2, 0, 0]", lambda task: task.robot.pose(np.zeros(6))[0, 3] > 1.19),
    ],
)
def test_any_key_can_be_set_by_hand(override: str, look) -> None:
    overrides = [override]
    if "virtual_knots" in override:
        overrides.append("spline.family=cubic")
    task = ot.load_case("machines-2024-490", overrides)
    assert look(task)
    assert override == "boundary.velocity=zero" or not look(ot.load_case("machines-2024-490"))


@pytest.mark.parametrize(
    ("override", "problem"),
    [
        ("spline.virtual_knots", "override 'spline.virtual_knots' is not key=value, for instance"),
        ("=3", "override '=3' is not key=value"),
        ("spline..family=cubic", "is not key=value"),
        ("name.first=3", "name.first: name is no table, it has no keys"),
        ("limits.velocity=[1, ", "limits.velocity: '[1,' is not a TOML value"),
        ("limits.velocity=1\nname = 'x'", "limits.velocity: \"1\\nname = 'x'\" is more than one TOML value"),
        ("spline.knots=3", "spline.knots: unknown key, expected one of family, virtual_knots"),
    ],
)
def test_a_wrong_override_says_what_is_wrong(override: str, problem: str) -> None:
    with pytest.raises(CaseError) as caught:
        read(SMALL, override)
    assert problem in str(caught.value)


def test_the_digest_changes_with_everything_that_matters_and_with_nothing_else() -> None:
    base = read(SMALL)
    same = read(SMALL, "title='another title'", "source='x'", "limits.velocity=[1.0, 1.0]")
    assert ot.task_digest(same) == ot.task_digest(base)
    overrides = [
        "name=other",
        "waypoints.joints=[[0.0, 0.0], [1.0, 0.5], [0.5, 1.0001]]",
        "waypoints.tolerance=0.1",
        "limits.velocity=1.0001",
        "limits.jerk=5",
        "spline.virtual_knots=1",
        "boundary.acceleration=zero",
        "objective.jerk=0.1",
        "objective.bounds.duration=[0, 9]",
        "search.duration=[0.1, 9]",
        "search.offset=0.5",
        "search.protocol=per-joint",
    ]
    digests = {ot.task_digest(read(SMALL, "spline.family=quintic", override)) for override in overrides}
    assert len(digests) == len(overrides)
    assert ot.task_digest(base) not in digests


def test_a_function_of_ones_own_enters_the_digest_and_cannot_be_written() -> None:
    casadi = pytest.importorskip("casadi")
    q, v, a, tau = (casadi.SX.sym(name, 2) for name in ("q", "v", "a", "tau"))
    small, large = (
        ot.CustomObjective("sum", casadi.Function("f", [q, v, a, tau], [factor * casadi.sumsqr(v)]))
        for factor in (1, 2)
    )
    base = read(SMALL)
    tasks = [base.changed(objective=ot.Objective(custom=(term,))) for term in (small, large)]
    assert len({ot.task_digest(task) for task in (base, *tasks)}) == 3
    with pytest.raises(TaskError, match="objective: a function of one's own cannot be written"):
        dumps(tasks[0])


def test_poses_become_joint_waypoints_on_the_branch_of_the_start() -> None:
    task = ot.load_case("ur5-helix")
    assert np.ptp(task.waypoints[:, 5]) < 1e-6  # joint 6 is still
    np.testing.assert_allclose(task.waypoints[0], [1.731, -2.032, 2.096, -0.065, -1.410, 1.571], atol=2e-3)
    np.testing.assert_allclose(
        task.robot.pose(task.waypoints[3])[:3, 3], [-0.242426, 0.142426, 0.35375], atol=1e-9
    )
