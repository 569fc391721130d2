"""A task without a motion is explained: by a proof, or by what stood in the way; a feasible one never is."""

from __future__ import annotations

import numpy as np
import pytest

from helpers.small_tasks import ARM_POINTS, arm_task
from ocp_traj.exceptions import TaskError
from ocp_traj.robot import load_robot
from ocp_traj.solvers.gradient.reasons.diagnosis import certain_conflict
from ocp_traj.solvers.gradient.recovery import NOT_FOUND
from ocp_traj.solving import SolveResult, solve
from ocp_traj.task import Boundary, Limits, Objective, TrajectoryTask

STRONG = np.array([150.0, 150.0, 150.0, 28.0, 28.0, 28.0])


@pytest.fixture(scope="module")
def ur5():
    return load_robot("ur5")


def weakened(joint: int, most: float):
    torque = STRONG.copy()
    torque[joint] = most
    return torque


def weak_arm(torque, **changes) -> TrajectoryTask:
    limits = {"torque": torque, **changes.pop("limits", {})}
    return arm_task(limits=limits, **{"virtual_knots": 1, **changes})


def explanation(result: SolveResult) -> str:
    assert result.status == "infeasible", result
    assert not result.feasible
    return result.diagnosis


def finding(result: SolveResult) -> str:
    """Return what stood in the way where nothing is proved."""
    assert result.status == "stalled", result
    assert not result.feasible
    assert result.diagnosis.startswith(NOT_FOUND)
    return result.diagnosis.removeprefix(NOT_FOUND)


# Before anything is solved -----------------------------------------------------------------------------------

CERTAIN = {
    "a velocity limit of zero on a joint that moves": (
        {"limits": Limits(velocity=[1.0, 0.0])},
        "velocity: joint 2, gap 1: the limit is 0, but the joint must move by 0.5.",
    ),
    "limits of one gap that forbid its direction": (
        {
            "limits": Limits(
                velocity=np.array([[[-1.0, -1.0], [1.0, 1.0]], [[-1.0, -1.0], [0.0, 1.0]], [[-1.0, -1.0], [1.0, 0.0]]])
            ),
        },
        "velocity: joint 2, gap 3: the limit is 0, but the joint must move by 0.25.",
    ),
    "a fixed duration below travel over speed": (
        {"limits": Limits(velocity=1.0), "objective": Objective(duration=(2.0, 2.0))},
        "duration: at most 2 s are allowed in total, but the velocity limits alone need 2.75 s.",
    ),
    "a gap with too little time": (
        {
            "limits": Limits(velocity=1.0),
            "objective": Objective(gap_durations=[[0.0, np.inf], [0.0, 0.5], [0.0, np.inf]]),
        },
        "duration: gap 2: at most 0.5 s are allowed, but joint 1 needs 1 s at its velocity limit.",
    ),
    "a start velocity over the limit": (
        {"limits": Limits(velocity=1.0), "boundary": Boundary(velocity=[[0.0, 1.5], [0.0, 0.0]])},
        "velocity: joint 2, gap 1: 1.5 rad/s is asked for at the start, outside the limits -1 to 1.",
    ),
    "an end acceleration over the limit": (
        {"limits": Limits(acceleration=2.0), "boundary": Boundary(acceleration=[[0.0, 0.0], [-3.0, 0.0]])},
        "acceleration: joint 1, gap 3: -3 rad/s^2 is asked for at the end, outside the limits -2 to 2.",
    ),
    "a start too fast to stop before a position limit": (
        {
            "limits": Limits(position=[[-3.0, -3.0], [1.0, 3.0]], acceleration=0.4),
            "boundary": Boundary(velocity=[[-2.0, 0.0], [1.0, 0.0]]),
        },
        "position: joint 1, gap 1: with -2 rad/s (m/s) at the start the acceleration limit takes it to -4.99998 at "
        "least, beyond the limit -3.",
    ),
    "an end too fast for the way to it": (
        {
            "limits": Limits(position=[[-0.2, -3.0], [1.0, 3.0]], acceleration=0.4),
            "boundary": Boundary(velocity=[[0.0, 0.0], [1.0, 0.0]]),
        },
        "position: joint 1, gap 3: with 1 rad/s (m/s) at the end the acceleration limit takes it to -0.499996 at "
        "least, beyond the limit -0.2.",
    ),
    "given durations that the acceleration limits forbid": (
        {
            "limits": Limits(acceleration=2.0),
            "objective": Objective(gap_durations=[[2.0, 2.0], [1.0, 1.0], [1.0, 1.0]]),
        },
        "duration: joint 1, gap 3: no motion within the velocity and acceleration limits has durations in their "
        "bounds up to there.",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CERTAIN)
def test_a_certain_conflict_is_told_with_its_numbers_and_without_solving(name: str) -> None:
    changes, sentence = CERTAIN[name]
    points = [[0.0, 0.0], [1.0, 0.5], [0.0, 0.25], [0.75, 0.5]]
    task = TrajectoryTask(points, virtual_knots=1, **changes)
    result = solve(task)
    assert explanation(result) == sentence
    assert result.solution.evaluations == 0


def test_torques_that_do_not_hold_the_arm_at_rest_at_the_end_are_named(ur5) -> None:
    needed = ur5.torque(ARM_POINTS, 0 * ARM_POINTS, 0 * ARM_POINTS)[0, 1]
    task = weak_arm(weakened(1, 0.9 * abs(needed)), boundary=Boundary(acceleration=0.0))
    limit = 0.9 * abs(needed)
    assert explanation(solve(task)) == (
        f"torque: joint 2, gap 1: {needed:.6g} N m are needed at waypoint 1, "
        f"outside the limits {-limit:.6g} to {limit:.6g}."
    )


def test_a_start_from_rest_may_fall_as_fast_as_its_acceleration_limits_allow_and_no_faster(ur5) -> None:
    held = ur5.torque(ARM_POINTS, 0 * ARM_POINTS, 0 * ARM_POINTS)[0]
    inertia = np.array([ur5.torque(ARM_POINTS[:1], np.zeros((1, 6)), a[None])[0] - held for a in np.eye(6)]).T
    reach = 0.01 * np.abs(inertia[1]).sum()  # acceleration limit 0.01: the least torque in closed form
    for margin, possible in ((1e-3, True), (-1e-3, False)):
        torque = weakened(1, abs(held[1]) - reach + margin)
        sentence = certain_conflict(weak_arm(torque, limits={"acceleration": 0.01}))
        named = (
            "joint 2, gap 1" in sentence
            and "at waypoint 1 whatever the acceleration within its limits" in sentence
        )
        assert named is not possible, sentence


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        (
            {"boundary": Boundary(acceleration=0.0)},
            "spline.virtual_knots",
            "fewer free coefficients than conditions, 6 against 8",
        ),
        (
            {"limits": Limits(position=[[-1.0, 0.0], [0.9, 1.0]])},
            "waypoints.joints[2]",
            "joint 1 is at 1, outside",
        ),
    ],
)
def test_what_no_spline_can_be_is_refused_when_the_task_is_made(changes: dict, key: str, words: str) -> None:
    points = [[0.0, 0.0], [1.0, 0.5], [0.0, 0.25], [0.75, 0.5]]
    with pytest.raises(TaskError) as caught:
        TrajectoryTask(points, virtual_knots=0, **changes)
    assert key in str(caught.value)
    assert words in str(caught.value)


# By the elastic phase ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("family", ["cubic", pytest.param("septic", marks=pytest.mark.slow)])
def test_torques_that_cannot_pass_a_waypoint_are_named_with_the_waypoint(family: str) -> None:
    task = weak_arm(weakened(1, 25.0), family=family, virtual_knots=1 if family == "cubic" else 0)
    sentence = finding(solve(task))
    assert sentence.startswith("torque: joint 2, gap ")
    assert "% over its limit" in sentence
    assert "the torque limit of joint 2 does not hold the arm at waypoint 3" in sentence
    assert "where gravity alone needs -58.44" in sentence


def test_a_duration_between_bound_and_optimum_names_the_shortest_motion() -> None:
    task = TrajectoryTask(
        [[0.0], [1.0]], Limits(acceleration=4.0), virtual_knots=1, objective=Objective(duration=(0.1, 1.1))
    )
    sentence = finding(solve(task))
    assert sentence.startswith("duration: at most 1.1 s are allowed")
    assert f"takes {np.sqrt(1.5):.6g} s" in sentence


def test_a_cartesian_speed_that_leaves_too_little_time_is_told() -> None:
    limits = {"cartesian_speed": (("tool0", 0.05),)}
    task = weak_arm(np.inf, limits=limits, objective=Objective(duration=(0.0, 4.0)))
    sentence = finding(solve(task))
    assert sentence.startswith("duration: at most 4 s are allowed, even with limits kept at samples only")


def test_limits_in_conflict_without_a_bound_on_time_are_told_by_joint_and_gap() -> None:
    moving = Boundary(velocity=[[1.0], [0.0]])
    limits = Limits(position=[[-1.0], [1.0]], jerk=1.0)
    task = TrajectoryTask([[0.9], [0.0]], limits, boundary=moving, virtual_knots=3)  # braking needs more than 0.1 rad
    sentence = finding(solve(task))
    assert "joint 1, gap 1" in sentence
    assert "position" in sentence or "acceleration" in sentence
    assert "% over its limit in the motion that breaks limits least" in sentence


def test_a_task_that_is_hard_but_possible_is_solved_and_not_explained() -> None:
    result = solve(weak_arm(weakened(1, 65.0)))
    assert result.feasible, result
    assert result.diagnosis == ""
