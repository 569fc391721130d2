"""A scene goes where its task goes, through results and `check`; proofs refuse it; slowing minds contact."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from helpers.collision.cells import clamped
from ocp_traj.audit import audit
from ocp_traj.case import task_from_json, task_to_json
from ocp_traj.cli.main import run
from ocp_traj.collision import CollisionScene, Contact, Shape, Solid
from ocp_traj.proofs import NotProved, prove
from ocp_traj.robot import load_robot
from ocp_traj.task import Limits, TrajectoryTask

REACH = np.array([0.0, -0.6, 0.5, 0.0, 1.2, 0.0])
SCENE = CollisionScene((Solid("ball", Shape("sphere", (0.1,)), (0, 0, 2.0, 0, 0, 0, 1)),), margin=0.01)

CASE = """
schema = 1
name = "cell"
[robot]
model = "ur5"
[waypoints]
joints = [[0, -1, 1, 0, 0.5, 0], [0.5, -1, 1, 0, 0.5, 0]]
[limits]
acceleration = 5
[collision]
pairs = "srdf"
obstacles = [{ name = "post", cylinder = { radius = 0.1, length = 2 }, pose = [0.45, 0, 0, 0, 0, 0, 1] }]
"""


def task(scene: CollisionScene) -> TrajectoryTask:
    return TrajectoryTask([REACH, REACH + 0.2], Limits(velocity=3.0), load_robot("ur5"), collision=scene)


def test_a_scene_of_plain_shapes_travels_with_a_result() -> None:
    carried = task_to_json(task(SCENE))
    assert carried is not None
    assert task_from_json(carried, "result").collision == SCENE


def test_a_scene_with_a_mesh_does_not_travel(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text("solid m\nendsolid m\n", encoding="utf-8")
    mesh = Solid("vise", Shape("mesh", mesh=tmp_path / "m.stl"))
    assert task_to_json(task(CollisionScene((mesh,)))) is None


def test_no_proof_file_is_made_of_a_task_with_a_scene() -> None:
    with pytest.raises(NotProved, match="its scene"):
        prove(task(SCENE), clamped([REACH, REACH + 0.2], [0.0, 1.0]))


def test_check_names_what_is_left_out_and_what_touches(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "cell.toml").write_text(CASE, encoding="utf-8")
    assert run(["check", str(tmp_path / "cell.toml")]) == 0
    shown = capsys.readouterr().out
    assert "1 obstacles" in shown and "left out, listed in the SRDF: base_link - upper_arm_link" in shown
    assert "forearm_link - wrist_3_link are left out, yet touch at" in shown
    assert "waypoint 1:" in shown and "post overlap by" in shown


def test_a_motion_with_contact_is_not_slowed_out_of_its_window() -> None:
    robot = load_robot("ur5")
    ends = np.array([REACH, REACH + np.array([0.4, 0, 0, 0, 0, 0])])
    motion = clamped(ends, [0.0, 0.5])
    where = robot.pose(ends[1])[:3, 3]
    ball = Solid("ball", Shape("sphere", (0.05,)), (*where, 0, 0, 0, 1))
    names = ("ee_link", "wrist_3_link", "wrist_2_link", "wrist_1_link")
    contact = tuple(Contact((name, "ball"), 1, 0.3, 0.3) for name in names)
    scene = CollisionScene((ball,), with_itself=False, contact=contact)
    tight = TrajectoryTask(ends, Limits(velocity=0.2, torque=np.inf), robot, collision=scene)
    loose = tight.changed(limits=Limits(velocity=10.0, torque=np.inf))
    assert audit(loose, motion).feasible
    verdict = audit(tight, motion)
    assert not verdict.feasible and verdict.smallest_feasible_scale is None
