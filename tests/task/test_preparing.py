"""A task made ready for solvers: equal consecutive waypoints are one point, positions count from near the motion."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.exceptions import TaskError
from ocp_traj.robot import load_robot
from ocp_traj.task import Limits, Objective, TrajectoryTask, passed_once, prepare
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription import trajectory_from_durations, transcribe

LIMITS = Limits(velocity=2.0, acceleration=4.0)


def one_joint(*waypoints: float, **changes) -> TrajectoryTask:
    return TrajectoryTask(np.array(waypoints)[:, None], changes.pop("limits", LIMITS), **changes)


@pytest.mark.parametrize(
    ("waypoints", "points", "kept"),
    [
        ((0.0, 1.0, 1.0, 2.0), (0, 1, 1, 2), (0, 2)),
        ((0.0, 0.0, 1.0, 2.0), (0, 0, 1, 2), (1, 2)),
        ((0.0, 1.0, 2.0, 2.0), (0, 1, 2, 2), (0, 1)),
        ((0.0, 1.0, 1.0, 1.0, 2.0), (0, 1, 1, 1, 2), (0, 3)),
        ((0.0, 0.0, 1.0, 1.0), (0, 0, 1, 1), (1,)),
        ((0.0, 1.0, 0.0), (0, 1, 2), (0, 1)),
        ((0.0, 0.0, 0.0), (0, 0, 1), (1,)),
        ((0.0, 0.0), (0, 1), (0,)),
    ],
)
def test_equal_consecutive_waypoints_are_one_point(waypoints, points, kept) -> None:
    ready = prepare(one_joint(*waypoints))
    assert tuple(ready.points) == points
    assert tuple(ready.kept) == kept
    np.testing.assert_array_equal(ready.task.waypoints[ready.points, 0], waypoints)


def test_a_task_that_is_ready_is_left_alone() -> None:
    task = one_joint(0.0, 1.0, 0.5)
    ready = prepare(task)
    assert ready.task is task and ready.changes_nothing


def test_a_bound_of_the_gaps_duration_makes_two_instants() -> None:
    for bound in ([0.0, 10.0], [0.5, np.inf], [0.5, 0.5]):
        bounds = [[0.0, np.inf], bound, [0.0, np.inf]]
        task = one_joint(0.0, 1.0, 1.0, 2.0, objective=Objective(gap_durations=bounds))
        assert not passed_once(task).any()
        assert prepare(task).task is task


def test_limits_and_bounds_of_the_other_gaps_stay_with_them() -> None:
    velocity = np.array([2.0, 0.0, 1.0])[:, None, None] * np.array([[-1.0], [1.0]])
    bounds = [[0.0, 3.0], [0.0, np.inf], [0.1, 5.0]]
    task = one_joint(
        0.0, 1.0, 1.0, 2.0, limits=Limits(velocity=velocity), objective=Objective(gap_durations=bounds)
    )
    ready = prepare(task).task
    np.testing.assert_array_equal(ready.limits.get("velocity")[:, 1, 0], [2.0, 1.0])
    np.testing.assert_array_equal(ready.objective.gap_durations, [[0.0, 3.0], [0.1, 5.0]])


def test_boxes_around_one_point_are_cut_with_each_other() -> None:
    tolerance = [[0.0, 0.0], [0.1, 0.3], [0.2, 0.2], [0.0, 0.0]]
    waypoints = [[0.0, 0.0], [1.0, 1.0], [1.0, 1.0], [2.0, 0.0]]
    ready = prepare(TrajectoryTask(np.array(waypoints), LIMITS, tolerance=np.array(tolerance))).task
    np.testing.assert_array_equal(ready.tolerance, [[0.0, 0.0], [0.1, 0.2], [0.0, 0.0]])


def test_motions_go_there_and_back() -> None:
    task = one_joint(5.0, 5.5, 5.5, 5.25)
    ready = prepare(task)
    np.testing.assert_array_equal(ready.task.waypoints[:, 0], [0.0, 0.5, 0.25])
    motion = trajectory_from_durations(ready.task, [1.0, 2.0])
    restored = ready.restored(motion)
    np.testing.assert_array_equal(restored.waypoint_times, [0.0, 1.0, 1.0, 3.0])
    np.testing.assert_array_equal(restored.segment_durations, [1.0, 0.0, 2.0])
    np.testing.assert_array_equal(restored(restored.waypoint_times)[:, 0], task.waypoints[:, 0])
    again = ready.prepared(restored)
    np.testing.assert_array_equal(again.waypoint_times, motion.waypoint_times)
    np.testing.assert_allclose(again.coefficients, motion.coefficients, rtol=0, atol=1e-15)


def test_a_motion_that_rests_at_a_doubled_waypoint_is_a_start_too() -> None:
    line = np.zeros((3, 1, 2))
    line[:, 0] = [[0.0, 1.0], [1.0, 0.0], [1.0, 1.0]]
    rests = Trajectory([0.0, 1.0, 2.0, 3.0], line, [0.0, 1.0, 2.0, 3.0])
    np.testing.assert_array_equal(prepare(one_joint(0.0, 1.0, 1.0, 2.0)).prepared(rests).waypoint_times, [0, 1, 3])
    ended = prepare(one_joint(0.0, 1.0, 2.0, 2.0))
    np.testing.assert_array_equal(ended.prepared(rests).waypoint_times, [0, 1, 3])


def test_far_positions_count_from_the_first_waypoint_exactly() -> None:
    near, far = 0.3, 0.3 + 1e-12
    task = TrajectoryTask(np.array([[near, -0.1], [far, 0.4]]), Limits(position=[[-1.0, -1.0], [far, 0.4]]))
    ready = prepare(task)
    np.testing.assert_array_equal(ready.origin, [near, 0.0])
    np.testing.assert_array_equal(ready.task.waypoints, [[0.0, -0.1], [far - near, 0.4]])
    np.testing.assert_array_equal(ready.task.limits.get("position")[0, 1], [far - near, 0.4])


def test_rounding_puts_no_box_beside_its_position_limit() -> None:
    rng = np.random.default_rng(5)
    for _ in range(200):
        waypoint, half = rng.uniform(1.0, 2.0), rng.uniform(0.0, 0.5)
        touched = Limits(position=[[waypoint + half], [3.0]])
        task = one_joint(waypoint, waypoint, limits=touched, tolerance=half)
        assert prepare(task).origin[0] == waypoint


def test_positions_stay_where_a_robot_stands_on_them() -> None:
    robot = load_robot("ur5")
    waypoints = np.full((2, robot.n), 1.0)
    waypoints[1] += 1e-6
    assert prepare(TrajectoryTask(waypoints, Limits(), robot)).changes_nothing


def test_sentences_keep_the_numbers_of_the_task() -> None:
    ready = prepare(one_joint(0.0, 0.0, 1.0, 1.0, 2.0))
    said = ready.in_original_numbers("velocity: joint 1, gap 1 and gap 2, waypoint 3, 12 % into gap 9")
    assert said == "velocity: joint 1, gap 2 and gap 4, waypoint 5, 12 % into gap 9"
    untouched = "velocity: gap 1"
    assert prepare(one_joint(0.0, 1.0)).in_original_numbers(untouched) == untouched


def test_too_few_points_for_the_spline_are_refused_with_the_reason() -> None:
    task = one_joint(0.0, 1.0, 1.0, 2.0, family="3-5-3")
    with pytest.raises(TaskError, match=r"at least 4 waypoints, 3 given \(equal consecutive waypoints are one point"):
        prepare(task)
    assert len(prepare(one_joint(0.0, 1.0, 1.0, 2.0, 1.5, family="3-5-3")).task.waypoints) == 4


def test_published_durations_may_be_0_between_equal_waypoints_only() -> None:
    task = one_joint(0.0, 1.0, 1.0, 2.0)
    once = trajectory_from_durations(task, [1.0, 0.0, 1.0])
    np.testing.assert_array_equal(once.waypoint_times, [0.0, 1.0, 1.0, 2.0])
    assert len(trajectory_from_durations(task, [1.0, 0.5, 1.0]).breakpoints) == 4
    with pytest.raises(ValueError, match="expected positive numbers"):
        trajectory_from_durations(task, [0.0, 0.0, 1.0])


@pytest.mark.parametrize("form", ["condensed", "lifted"])
def test_a_problem_to_look_at_gives_motions_of_the_task_itself(form: str) -> None:
    task = one_joint(5.0, 5.5, 5.5, 5.25, virtual_knots=1)
    nlp = transcribe(task, form)
    motion = nlp.decode(np.asarray(nlp.guess))
    assert len(motion.waypoint_times) == 4 and motion.segment_durations[1] == 0.0
    np.testing.assert_allclose(motion(motion.waypoint_times)[:, 0], task.waypoints[:, 0], atol=1e-12)
    assert any("gap 3" in nlp.label(row) for row in range(len(nlp.g_lower)))
    if form == "condensed":
        np.testing.assert_allclose(nlp.encode(motion), nlp.guess, atol=1e-9)
