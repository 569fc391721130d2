"""A robot in its cell: which pairs count, which are left out and named, and what touches at a configuration."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from ocp_traj.collision import CollisionScene, Contact, Shape, Solid, cell_of
from ocp_traj.collision.summary import touching_left_out
from ocp_traj.exceptions import RobotError, TaskError
from ocp_traj.robot import load_robot, robot_names
from ocp_traj.robot.packaged import PACKAGED_ROBOTS, data_folder
from ocp_traj.task import Limits, TrajectoryTask

UPRIGHT = np.array([0.0, -np.pi / 2, 0.0, -np.pi / 2, 0.0, 0.0])
TABLE = Solid("table", Shape("box", (2.0, 2.0, 0.1)), (0, 0, -0.1, 0, 0, 0, 1))


@pytest.mark.parametrize("name", robot_names())
def test_every_named_robot_has_bodies_that_stand_where_pinocchio_puts_them(name: str) -> None:
    robot = load_robot(name)
    parts = cell_of(robot, CollisionScene()).parts
    if name == "two-dof":
        assert not parts
        return
    path = data_folder() / PACKAGED_ROBOTS[name].urdf
    model = pin.buildModelFromUrdf(str(path))
    shapes = pin.buildGeomFromUrdf(
        model, str(path), pin.GeometryType.COLLISION, package_dirs=[str(path.parents[4]), str(path.parents[3])]
    )
    assert len(parts) == len(shapes.geometryObjects)


def test_links_that_share_a_joint_are_left_out_and_named() -> None:
    cell = cell_of(load_robot("ur5"), CollisionScene())
    assert next(entry.bodies for entry in cell.left_out) == ("base_link", "shoulder_link")
    assert {entry.reason for entry in cell.left_out} == {"they share a joint"}
    judged = {frozenset(cell.names(pair)) for pair in cell.pairs}
    assert frozenset(("base_link", "shoulder_link")) not in judged
    assert frozenset(("forearm_link", "wrist_2_link")) in judged


def test_pairs_that_an_srdf_lists_keep_no_margin_but_may_not_touch() -> None:
    cell = cell_of(load_robot("ur5"), CollisionScene(pairs="srdf", self_margin=0.01))
    listed = {frozenset(cell.names(pair)): pair for pair in cell.pairs if pair.left_out}
    assert frozenset(("forearm_link", "wrist_3_link")) in listed
    assert all(pair.margin == 0.0 for pair in listed.values())
    assert {"listed in the SRDF", "they share a joint"} == {entry.reason for entry in cell.left_out}
    touching = {entry.bodies: share for entry, share in touching_left_out(cell)}
    assert 0.04 < touching["forearm_link", "wrist_3_link"] < 0.2


def test_a_robot_without_an_srdf_says_so() -> None:
    with pytest.raises(TaskError, match=r"collision\.pairs: 'srdf' given, but so100 has none of its own"):
        cell_of(load_robot("so100"), CollisionScene(pairs="srdf"))
    lost = load_robot("ur5", srdf=Path("nothing.srdf"))
    with pytest.raises(RobotError, match=r"nothing\.srdf does not exist"):
        cell_of(lost, CollisionScene(pairs="srdf"))


def test_ignored_pairs_are_named_and_not_judged() -> None:
    cell = cell_of(load_robot("ur5"), CollisionScene(ignore=(("wrist_2_link", "forearm_link"),)))
    assert ("forearm_link", "wrist_2_link") in [e.bodies for e in cell.left_out if e.reason == "ignored"]
    assert all({"forearm_link", "wrist_2_link"} != set(cell.names(pair)) for pair in cell.pairs)


def test_without_self_collision_only_obstacles_count() -> None:
    cell = cell_of(load_robot("ur5"), CollisionScene(obstacles=(TABLE,), with_itself=False))
    assert {cell.names(pair)[1] for pair in cell.pairs} == {"table"}
    assert len(cell.pairs) == 7


def test_what_touches_is_named_with_its_depth() -> None:
    ball = Solid("ball", Shape("sphere", (0.1,)), (0.0, 0.0, 1.1, 0, 0, 0, 1))
    cell = cell_of(load_robot("ur5"), CollisionScene(obstacles=(ball, TABLE)))
    found = cell.collisions(UPRIGHT)
    assert found and found[0].bodies[1] == "ball" and found[0].distance < 0
    assert "overlap by" in str(found[0])
    near = cell_of(load_robot("ur5"), CollisionScene(obstacles=(TABLE,), margin=0.2)).collisions(UPRIGHT)
    assert "mm apart, closer than 200 mm" in str(near[0])


def test_bodies_count_in_their_gaps_and_contact_at_its_waypoint() -> None:
    gripper = Solid("gripper", Shape("sphere", (0.05,)))
    part = Solid("part", Shape("box", (0.1, 0.1, 0.1)), gaps=(1,))
    robot = load_robot("ur5")
    where = robot.pose(UPRIGHT)[:3, 3] + [0.0, 0.0995, 0.0]
    ball = Solid("ball", Shape("sphere", (0.05,)), (*where, 0, 0, 0, 1), gaps=(0,))
    contact = Contact(("gripper", "ball"), 1, 0.1, 0.001)
    cell = cell_of(robot, CollisionScene((ball,), (gripper, part), with_itself=False, contact=(contact,)))
    assert {frozenset(cell.names(pair)) for pair in cell.pairs} >= {frozenset(("gripper", "ball"))}
    assert all(frozenset(("part", "ball")) != frozenset(cell.names(pair)) for pair in cell.pairs)
    assert [overlap.bodies for overlap in cell.collisions(UPRIGHT, 0)] == [("gripper", "ball")]
    assert cell.collisions(UPRIGHT, 1) == []
    assert cell.collisions(UPRIGHT, 0, waypoint=1) == []


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (CollisionScene(ignore=(("forearm", "wrist_2_link"),)), r"collision\.ignore: 'forearm' is no body"),
        (CollisionScene(contact=(Contact(("a", "b"), 0, 0.1, 0.1),)), r"collision\.contact: 'a' is no body"),
        (CollisionScene((Solid("base_link", Shape("sphere", (0.1,))),)), "is the name of a link"),
        (CollisionScene((Solid("x", Shape("sphere", (0.1,)), gaps=(3,)),)), r"gaps: 4 given, expected gaps 1 to 1"),
        (CollisionScene(contact=(Contact(("a", "b"), 2, 0.1, 0.1),)), "3 given, expected waypoints 1 to 2"),
    ],
)
def test_a_task_refuses_a_scene_that_does_not_fit_it(scene: CollisionScene, message: str) -> None:
    with pytest.raises(TaskError, match=message):
        TrajectoryTask([UPRIGHT, UPRIGHT + 0.1], Limits(acceleration=5.0), load_robot("ur5"), collision=scene)


def test_a_task_without_a_robot_cannot_collide() -> None:
    with pytest.raises(TaskError, match="collision: needs a robot"):
        TrajectoryTask([[0.0], [1.0]], Limits(velocity=1.0), collision=CollisionScene())
