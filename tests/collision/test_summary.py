"""What is said of a cell before anything moves: its bodies, what is left out, and waypoints that touch something."""

from __future__ import annotations

import numpy as np

from ocp_traj.collision import CollisionScene, Contact, Shape, Solid, cell_of
from ocp_traj.collision.summary import describe_cell, waypoint_conflict
from ocp_traj.robot import load_robot, robot_from_dh
from ocp_traj.solving import solve
from ocp_traj.task import Limits, TrajectoryTask

FREE = np.array([0.0, -1.0, 1.0, 0.0, 0.5, 0.0])
SWAY = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
WAYPOINTS = np.array([FREE, FREE + 0.5 * SWAY, FREE + SWAY])


def ball_at(q: np.ndarray, **changes: object) -> Solid:
    where = load_robot("ur5").pose(q)[:3, 3]
    return Solid("ball", Shape("sphere", (0.05,)), (*where, 0, 0, 0, 1), **changes)  # type: ignore[arg-type]


def test_a_cell_is_described_with_all_that_is_left_out() -> None:
    scene = CollisionScene((ball_at(WAYPOINTS[1]),), pairs="srdf", ignore=(("base_link", "ee_link"),))
    text = "\n".join(describe_cell(cell_of(load_robot("ur5"), scene), WAYPOINTS))
    assert "8 links, 0 bodies at the tool, 1 obstacles; 9 convex pieces, up to 114 where" in text
    assert "left out, they share a joint: base_link - shoulder_link," in text
    assert "left out, ignored: base_link - ee_link" in text
    assert "forearm_link - wrist_3_link are left out, yet touch at" in text
    assert "waypoint 2: wrist_3_link and ball overlap by" in text
    assert "waypoint 1:" not in text and "waypoint 3:" not in text


def test_a_robot_without_shapes_says_so() -> None:
    robot = robot_from_dh("standard", [0.3, 0.3], [0, 0], [0, 0], [0, 0])
    text = "\n".join(describe_cell(cell_of(robot, CollisionScene()), np.zeros((2, 2))))
    assert "has no collision geometry" in text


def test_a_waypoint_that_touches_is_named_before_anything_is_solved() -> None:
    scene = CollisionScene((ball_at(WAYPOINTS[1]),))
    task = TrajectoryTask(WAYPOINTS, Limits(acceleration=5.0), load_robot("ur5"), collision=scene)
    result = solve(task, "ipopt")
    assert result.status == "infeasible"
    assert "collision: waypoint 2: wrist_3_link and ball overlap by" in result.message


def test_bodies_of_other_gaps_and_contact_on_purpose_do_not_forbid_a_waypoint() -> None:
    robot = load_robot("ur5")
    here = ball_at(WAYPOINTS[2], gaps=(0,))
    assert waypoint_conflict(robot, CollisionScene((here,)), WAYPOINTS) == ""
    at_the_edge = ball_at(WAYPOINTS[1], gaps=(1,))
    assert "waypoint 2" in waypoint_conflict(robot, CollisionScene((at_the_edge,)), WAYPOINTS)
    links = [part.owner for part in cell_of(robot, CollisionScene()).parts]
    meant = tuple(Contact((name, "ball"), 1, 0.1, 0.3) for name in links)
    assert waypoint_conflict(robot, CollisionScene((at_the_edge,), contact=meant), WAYPOINTS) == ""
