"""Tasks made and changed in code."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ocp_traj.exceptions import TaskError
from ocp_traj.robot import load_robot
from ocp_traj.task import Boundary, Limits, Motor, Objective, Search, TrajectoryTask

POINTS = [[0.0], [1.0], [0.5], [2.0]]


def test_another_family_brings_its_own_end_conditions():
    task = TrajectoryTask(POINTS, Limits(velocity=1.0), family="3-5-3")
    assert task.boundary.acceleration is not None
    assert task.changed(family="cubic").boundary.acceleration is None
    septic = task.changed(family="septic")
    assert septic.boundary.jerk is not None


def test_given_end_conditions_stay_with_another_family():
    task = TrajectoryTask(POINTS, Limits(velocity=1.0), virtual_knots=2, boundary=Boundary(acceleration=0.0))
    assert np.array_equal(task.changed(family="quintic").boundary.acceleration, np.zeros((2, 1)))


@pytest.mark.parametrize(("family", "knots"), [("cubic", 3), ("quintic", 0), ("septic", 0), ("3-5-3", 0)])
def test_virtual_knots_follow_the_family_unless_they_are_given(family: str, knots: int) -> None:
    assert TrajectoryTask(POINTS, family=family).virtual_knots == knots
    assert TrajectoryTask(POINTS, family=family, virtual_knots=0).virtual_knots == 0
    assert TrajectoryTask(POINTS, family="quintic").changed(family=family).virtual_knots == knots
    kept = TrajectoryTask(POINTS, virtual_knots=2)
    assert kept.changed(family="septic").virtual_knots == 2


@pytest.mark.parametrize(
    ("points", "knots", "jerk", "given"),
    [
        (POINTS, 3, 5.0, True),
        (POINTS, 1, [np.inf], False),
        (POINTS, 1, 5.0, True),
        (POINTS, 0, 5.0, False),
        (POINTS, 3, None, False),
        (POINTS[:2], 1, 5.0, False),
        (POINTS[:2], 2, 5.0, True),
    ],
)
def test_a_cubic_starts_and_ends_without_acceleration_where_jerk_is_limited(
    points: list[list[float]], knots: int, jerk: Any, given: bool
) -> None:
    task = TrajectoryTask(points, Limits(velocity=1.0, jerk=jerk), virtual_knots=knots)
    assert (task.boundary.acceleration is not None) == given
    assert task.boundary.jerk is None


def test_end_accelerations_by_default_follow_what_is_changed() -> None:
    task = TrajectoryTask(POINTS, Limits(velocity=1.0, jerk=5.0))
    assert task.changed(virtual_knots=0).boundary.acceleration is None
    assert task.changed(limits=Limits(velocity=1.0)).boundary.acceleration is None
    free = task.changed(boundary=Boundary(acceleration=None))
    assert free.changed(name="other").boundary.acceleration is None
    moving = task.changed(boundary=Boundary(acceleration=[[1.0], [0.0]]))
    assert moving.changed(limits=Limits(velocity=1.0)).boundary.acceleration is not None


def test_one_knot_between_two_waypoints_leaves_no_freedom_for_end_accelerations() -> None:
    with pytest.raises(TaskError, match="1 leaves fewer free coefficients than conditions, 5 against 6 per joint"):
        TrajectoryTask(POINTS[:2], virtual_knots=1, boundary=Boundary(acceleration=0.0))


def test_an_unknown_field_is_refused_by_name():
    with pytest.raises(TaskError, match="familly"):
        TrajectoryTask(POINTS).changed(familly="cubic")


PAIR = [[0.0, 0.0], [1.0, 0.5], [2.0, 0.0]]
"""Two joints, two gaps."""


@pytest.mark.parametrize(
    ("given", "expanded"),
    [
        (2.0, [[-2.0, -2.0], [2.0, 2.0]]),
        ([1.0, 3.0], [[-1.0, -3.0], [1.0, 3.0]]),
        ([[-1.0, -2.0], [3.0, 0.0]], [[-1.0, -2.0], [3.0, 0.0]]),
        (None, [[-np.inf] * 2, [np.inf] * 2]),
        (0.0, [[0.0, 0.0], [0.0, 0.0]]),
    ],
)
@pytest.mark.parametrize("name", ["velocity", "acceleration", "jerk"])
def test_limits_become_lower_and_upper_ones_of_every_gap(name: str, given: Any, expanded: Any) -> None:
    task = TrajectoryTask(PAIR, Limits(**{name: given}))
    np.testing.assert_array_equal(task.limits.get(name), [expanded] * 2)
    assert task.limited(name) is bool(np.isfinite(expanded).any())


def test_limits_of_single_gaps_stay_as_they_are() -> None:
    given = np.array([[[-1.0, -2.0], [3.0, 4.0]], [[-5.0, -6.0], [7.0, np.inf]]])
    np.testing.assert_array_equal(TrajectoryTask(PAIR, Limits(jerk=given)).limits.get("jerk"), given)


def test_a_robot_gives_only_the_limits_that_were_left_out() -> None:
    robot = load_robot("ur5")
    task = TrajectoryTask(np.zeros((2, 6)), Limits(velocity=1.0), robot=robot)
    np.testing.assert_array_equal(task.limits.get("torque")[0], robot.torque_limits)
    np.testing.assert_array_equal(task.limits.get("position")[0], robot.position_limits)
    np.testing.assert_array_equal(task.limits.get("velocity")[0], [[-1.0] * 6, [1.0] * 6])
    assert not task.limited("acceleration")


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"velocity": [1.0, -2.0]}, "limits.velocity: -2 is negative, expected a limit of 0 or more"),
        ({"velocity": "fast"}, "limits.velocity: 'fast' is not a number, 2 numbers or two rows of 2 numbers"),
        ({"velocity": np.nan}, "limits.velocity: contains nan"),
        ({"velocity": [1.0, 2.0, 3.0]}, r"limits.velocity: has shape \(3,\), expected a number, 2 numbers"),
        ({"velocity": np.ones((3, 2, 2))}, r"limits.velocity: has shape \(3, 2, 2\)"),
        ({"position": [[0.0, 1.0], [2.0, 0.5]]}, "limits.position: the lower limit of joint 2 is above"),
        ({"position": [[2.0, 1.0], [2.0, 0.5]]}, "limits.position: the lower limit of joint 2 is above"),
        ({"position": [[3.0, 0.0], [2.0, 0.5]]}, "limits.position: the lower limit of joint 1 is above"),
        ({"velocity": [[0.5, -1.0], [1.0, 1.0]]}, "limits.velocity: the range of every joint must contain 0"),
        ({"velocity": [[-1.0, -1.0], [1.0, -0.5]]}, "limits.velocity: the range of every joint must contain"),
        ({"cartesian_speed": (("tool0", 0.0),)}, "limits.cartesian_speed: 0.0 for frame 'tool0'"),
        ({"torque": 1.0}, "limits.torque: needs a robot with inertia"),
        ({"torque_rate": 1.0}, "limits.torque_rate: needs a robot with inertia"),
    ],
)
def test_limits_that_cannot_be_are_refused(limits: dict[str, Any], message: str) -> None:
    with pytest.raises(TaskError, match=message):
        TrajectoryTask(PAIR, Limits(**limits))


def test_ranges_may_end_at_zero_and_positions_anywhere() -> None:
    task = TrajectoryTask(
        PAIR, Limits(position=[[-3.0, -0.5], [2.0, 0.5]], velocity=[[0.0, -1.0], [1.0, 0.0]])
    )
    assert task.limited("velocity")
    TrajectoryTask([[2.0], [3.0]], Limits(position=[[2.0], [3.0]]))


@pytest.mark.parametrize(
    ("gap", "limit", "problem"),
    [
        (0, [0.5, 9.0], r"joints\[2\]: joint 1 is at 1, outside its range \[-9, 0.5\]"),
        (1, [0.5, 9.0], r"joints\[2\]: joint 1 is at 1, outside its range \[-9, 0.5\]"),
        (1, [1.5, 9.0], r"joints\[3\]: joint 1 is at 2, outside its range \[-9, 1.5\]"),
        (0, [9.0, 0.4], r"joints\[2\]: joint 2 is at 0.5, outside its range \[-9, 0.4\]"),
    ],
)
def test_a_waypoint_lies_in_the_ranges_of_both_its_gaps(gap: int, limit: list[float], problem: str) -> None:
    position = np.tile([[-9.0, -9.0], [9.0, 9.0]], (2, 1, 1))
    position[gap, 1] = limit
    with pytest.raises(TaskError, match=problem):
        TrajectoryTask(PAIR, Limits(position=position))
    with pytest.raises(TaskError, match=problem.split(":")[0]):
        TrajectoryTask(-np.array(PAIR), Limits(position=-position[:, ::-1]))
    TrajectoryTask(PAIR, Limits(position=position), tolerance=1.5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"waypoints": [[0.0, 1.0], [np.inf, 2.0]]}, "waypoint 2, joint 1 is inf, expected a finite number"),
        ({"waypoints": [[0.0, np.nan], [1.0, 2.0]]}, "waypoint 1, joint 2 is nan"),
        ({"waypoints": [[0.0, 1.0]]}, "waypoints: 1 given, expected at least 2"),
        ({"waypoints": [0.0, 1.0]}, r"waypoints: have shape \(2,\), expected \(K, n\)"),
        ({"waypoints": [[], []]}, r"waypoints: have shape \(2, 0\)"),
        ({"waypoints": [[0.0], [1.0, 2.0]]}, "waypoints: rows differ in length"),
        ({"family": "bezier"}, "spline.family: 'bezier' is unknown"),
        ({"family": ["cubic"]}, r"spline.family: \['cubic'\] is unknown"),
        ({"virtual_knots": -1}, "spline.virtual_knots: -1 given"),
        ({"virtual_knots": True}, "spline.virtual_knots: True given"),
        ({"virtual_knots": 1.0}, "spline.virtual_knots: 1.0 given"),
        ({"family": "3-5-3", "virtual_knots": 1}, "but 3-5-3 takes none"),
        ({"family": "3-5-3"}, "3-5-3 needs at least 4 waypoints, 3 given"),
        ({"tolerance": -0.1}, "waypoints.tolerance: expected one, 2 or"),
        ({"tolerance": [0.1, 0.1, 0.1]}, "waypoints.tolerance"),
        (
            {"boundary": Boundary(acceleration=0.0), "virtual_knots": 0},
            "0 leaves fewer free coefficients than conditions, 5 against 7 per joint",
        ),
        ({"boundary": Boundary(velocity=None)}, "boundary.velocity: must be given"),
        ({"boundary": Boundary(velocity=[0.0, 0.0, 0.0])}, r"expected two rows \(start, end\) of 2 finite"),
        ({"boundary": Boundary(velocity=np.inf)}, r"expected two rows \(start, end\) of 2 finite"),
        ({"robot": load_robot("ur5")}, "waypoints: rows have 2 numbers, expected 6, the joints of ur5"),
        ({"objective": Objective(time=-1.0)}, "objective.time: -1.0 is not a weight"),
        ({"objective": Objective(jerk=np.inf)}, "objective.jerk: inf is not a weight"),
        ({"objective": Objective(energy=1.0)}, "objective.energy: needs a robot with inertia"),
        ({"objective": Objective(motor_loss=1.0)}, "objective.motor_loss: needs the motors"),
        ({"objective": Objective(duration=(2.0, 1.0))}, "expected 0 <= lower <= upper with upper above 0"),
        ({"objective": Objective(duration=(-1.0, 1.0))}, "expected 0 <= lower <= upper"),
        ({"objective": Objective(duration=(0.0, 0.0))}, "expected 0 <= lower <= upper"),
        (
            {"objective": Objective(gap_durations=[[0.0, 0.0], [0.0, 1.0]])},
            "bounds.gap_durations: expected 0",
        ),
        (
            {"objective": Objective(gap_durations=[[0.0, 1.0], [2.0, 1.0]])},
            "bounds.gap_durations: expected 0",
        ),
        (
            {"objective": Objective(gap_durations=[[0.0, 1.0], [-1.0, 1.0]])},
            "bounds.gap_durations: expected 0",
        ),
        ({"objective": Objective(gap_durations=[[0.0, 1.0]])}, r"has shape \(1, 2\), expected \(2, 2\)"),
        (
            {"objective": Objective(gap_durations=[[0.0, 1.0], [0.0, np.nan]])},
            "bounds.gap_durations: has shape",
        ),
        ({"search": Search((0.0, 1.0))}, "search.duration: expected two finite positive numbers"),
        ({"search": Search((0.1, np.inf))}, "search.duration: expected two finite positive numbers"),
        ({"search": Search(protocol="alone")}, "search.protocol: 'alone' is unknown"),
    ],
)
def test_tasks_that_cannot_be_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(TaskError, match=message):
        TrajectoryTask(**{"waypoints": PAIR, **changes})


def test_free_ends_and_rest_are_told_from_given_ones() -> None:
    free = TrajectoryTask(PAIR, boundary=Boundary(0.0, None)).boundary
    assert (free.acceleration, free.jerk, free.is_rest) == (None, None, True)
    for boundary in (Boundary([[0.0, 0.1], [0.0, 0.0]]), Boundary(0.0, [[0.0, 0.0], [0.2, 0.0]])):
        assert not TrajectoryTask(PAIR, boundary=boundary, virtual_knots=1).boundary.is_rest
    quintic = TrajectoryTask(PAIR, family="quintic").boundary
    np.testing.assert_array_equal(quintic.acceleration, np.zeros((2, 2)))  # type: ignore[arg-type]
    assert quintic.jerk is None


def test_time_has_weight_when_nothing_else_has() -> None:
    assert TrajectoryTask(PAIR).objective.weights == {"time": 1.0}
    assert TrajectoryTask(PAIR, objective=Objective(jerk=0.5)).objective.weights == {"jerk": 0.5}
    motor = Motor(1.0, 1.0)
    assert Objective(motor_loss=1.0, motor=motor).needs_torque
    assert not Objective(time=1.0, acceleration=1.0, jerk=1.0).needs_torque


def test_torques_are_needed_by_limits_and_costs_that_have_them() -> None:
    robot, points = load_robot("ur5"), np.zeros((2, 6))
    for limits, needed in (
        (Limits(torque=np.inf), False),
        (Limits(torque=[1.0, *[np.inf] * 5]), True),
        (Limits(torque=np.inf, torque_rate=5.0), True),
    ):
        assert TrajectoryTask(points, limits, robot=robot).needs_torque is needed
