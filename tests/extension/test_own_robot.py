"""A robot of one's own, a URDF from outside or one entry in the list, is solved, audited, compared and drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ocp_traj as ot
from ocp_traj.cli.main import run
from ocp_traj.comparison.report.report import write_report
from ocp_traj.comparison.runs.compare import compare
from ocp_traj.comparison.runs.plan import CaseChoice, Plan
from ocp_traj.robot.packaged import DATA_VARIABLE, PACKAGED_ROBOTS, PackagedRobot

LINK = """<link name="{name}"><inertial><origin xyz="0.2 0 0"/><mass value="{mass}"/>
<inertia ixx="0.01" iyy="0.05" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><mesh filename="{name}.obj"/></geometry></visual></link>"""
JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="{x} 0 0"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" velocity="2" effort="{effort}"/></joint>"""
URDF = (
    '<robot name="elbow"><link name="base"/>'
    + LINK.format(name="upper", mass=2.0)
    + LINK.format(name="lower", mass=1.0)
    + JOINT.format(name="shoulder", parent="base", child="upper", x=0.0, effort=30)
    + JOINT.format(name="elbow", parent="upper", child="lower", x=0.4, effort=15)
    + "</robot>"
)
TETRAHEDRON = "v 0 0 0\nv 0.4 0 0\nv 0 0.05 0\nv 0 0 0.05\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
CASE = """
schema = 1
name = "elbow"
[robot]
urdf = "elbow.urdf"
[waypoints]
joints = [[0.0, 0.0], [0.5, -0.8], [1.0, 0.2]]
[limits]
acceleration = 10.0
[spline]
virtual_knots = 1
"""


@pytest.fixture
def case(tmp_path: Path) -> Path:
    """Write the robot, its meshes and a case that moves it."""
    (tmp_path / "elbow.urdf").write_text(URDF)
    for name in ("upper", "lower"):
        (tmp_path / f"{name}.obj").write_text(TETRAHEDRON)
    (tmp_path / "case.toml").write_text(CASE)
    return tmp_path / "case.toml"


def test_a_urdf_from_outside_is_solved_audited_and_drawn(case: Path) -> None:
    task = ot.load_case(case)
    result = ot.solve(task, "ipopt")
    verdict = ot.audit(task, result.trajectory)
    assert verdict.feasible and {"velocity", "acceleration", "torque"} <= set(verdict.limits)
    assert result.energy > 0
    answer, picture = case.with_name("answer.csv"), case.with_name("answer.svg")
    ot.write_csv(answer, result.trajectory)
    assert run(["plot", str(answer), "--case", str(case), "--output", str(picture)]) == 0
    assert "torque" in picture.read_text(encoding="utf-8")


def test_a_urdf_from_outside_is_compared_and_moves_in_the_report(case: Path, tmp_path: Path) -> None:
    compare(
        Plan((CaseChoice(str(case)),), ("ipopt",), seeds=1, references=False, time_limit=30.0), tmp_path / "out"
    )
    files = write_report(tmp_path / "out")
    (group,) = files.judgement.of_solver("ipopt")
    assert group.successes == 1 and group.best.record.energy > 0
    assert '<div class="viewer">' in files.html.read_text(encoding="utf-8")


def test_one_entry_makes_it_a_robot_by_name(case: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(DATA_VARIABLE, str(case.parent))
    monkeypatch.setitem(PACKAGED_ROBOTS, "elbow", PackagedRobot("elbow.urdf", "lower"))
    assert "elbow" in ot.robot_names()
    named = ot.load_robot("elbow")
    q = np.array([0.3, -0.4])
    from_file = ot.load_case(case).robot
    np.testing.assert_array_equal(named.torque(q, q, q), from_file.torque(q, q, q))
    task = ot.load_case(case).changed(robot=named)
    ot.write_case(task, case.with_name("named.toml"))
    assert 'model = "elbow"' in case.with_name("named.toml").read_text(encoding="utf-8")
    assert ot.load_case(case.with_name("named.toml")).robot == named
