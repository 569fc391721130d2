"""Equal waypoints that follow one another are one point; times that a file does not name are noted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from helpers.bounds_guard import unguarded
from ocp_traj.audit import audit
from ocp_traj.case import load_case
from ocp_traj.task import Boundary, Limits, Objective, TrajectoryTask
from ocp_traj.trajectory import Trajectory

FAULTS = Path(__file__).parents[1] / "data" / "faults"
WAYPOINTS = [[0.0], [1.0], [1.0], [2.0]]
FASTEST = Trajectory(
    [0.0, 0.5, 1.0, 1.5],
    [[[0.0, 0.0, 2.0]], [[0.5, 2.0, 0.0]], [[1.5, 2.0, -2.0]]],
    [0.0, 0.75, 0.75, 1.5],
)
"""From 0 to 2 with 4 rad/s^2 and 2 rad/s."""


def free(**settings: object) -> TrajectoryTask:
    boundary = Boundary(velocity=0.0, acceleration=None)
    return TrajectoryTask(WAYPOINTS, boundary=boundary, **settings)  # type: ignore[arg-type]


@pytest.mark.parametrize("named", [True, False])
def test_a_doubled_waypoint_is_passed_at_full_speed(named: bool) -> None:
    task = load_case(FAULTS / "dup-middle.toml").changed(boundary=Boundary(velocity=0.0, acceleration=None))
    motion = FASTEST if named else replace(FASTEST, waypoint_times=[0.0, 1.5])
    verdict = audit(task, motion)
    assert verdict.feasible, verdict.findings
    assert verdict.duration == 1.5
    assert verdict.smallest_feasible_scale == pytest.approx(1.0)
    assert len(verdict.notes) == (0 if named else 1)


def test_limits_of_a_gap_without_duration_bind_nothing() -> None:
    limits = np.array([[[-2.0], [2.0]], [[-1e-3], [1e-3]], [[-2.0], [2.0]]])
    # by itself: the bound that the tests hold verdicts against asks for the limits of such a gap at its ends
    with unguarded():
        verdict = audit(free(limits=Limits(velocity=limits, acceleration=4.0)), FASTEST)
    assert verdict.feasible
    later = audit(free(limits=Limits(velocity=limits[[0, 0, 1]], acceleration=4.0)), FASTEST)
    assert not later.feasible
    assert later.limits["velocity"].gap == 2
    assert later.limits["velocity"].time >= 0.75
    earlier = audit(free(limits=Limits(velocity=limits[[1, 0, 0]], acceleration=4.0)), FASTEST)
    assert earlier.limits["velocity"].gap == 0


def test_a_gap_with_a_bound_of_its_duration_lasts_as_long() -> None:
    bounds = Objective(gap_durations=[[0.0, 9.0], [0.5, 9.0], [0.0, 9.0]])
    verdict = audit(free(limits=Limits(velocity=2.0), objective=bounds), FASTEST)
    assert verdict.findings == ("duration of gap 2: 0 s, expected between 0.5 and 9 s",)
    assert verdict.smallest_feasible_scale is None


def test_waypoints_that_differ_are_not_passed_at_one_time() -> None:
    task = TrajectoryTask([[0.0], [1.0], [1.0 + 1e-9], [2.0]], boundary=Boundary(velocity=0.0, acceleration=None))
    assert audit(task, FASTEST).findings == ("waypoints 2 and 3 differ, but both are passed at 0.75 s",)


@pytest.mark.parametrize(
    ("waypoints", "times"),
    [
        ([[0.0], [0.0], [2.0]], [0.0, 0.0, 1.5]),
        ([[0.0], [2.0], [2.0]], [0.0, 1.5, 1.5]),
        ([[0.0], [0.0], [2.0], [2.0], [2.0]], [0.0, 0.0, 1.5, 1.5, 1.5]),
    ],
)
@pytest.mark.parametrize("named", [True, False])
def test_the_first_or_the_last_waypoint_may_be_doubled(
    waypoints: list[list[float]], times: list[float], named: bool
) -> None:
    motion = replace(FASTEST, waypoint_times=times if named else [0.0, 1.5])
    gaps = len(waypoints) - 1
    limits = np.full((gaps, 2, 1), [[-2.0], [2.0]])
    task = TrajectoryTask(
        waypoints, Limits(velocity=limits, acceleration=4.0), boundary=Boundary(velocity=0.0, acceleration=None)
    )
    assert audit(task, motion).feasible


def test_a_rest_is_a_motion() -> None:
    still = Trajectory([0.0, 1.0], [[[0.5]]], [0.0, 1.0])
    for count in (2, 3, 4):
        verdict = audit(TrajectoryTask([[0.5]] * count, Limits(velocity=1.0, acceleration=1.0)), still)
        assert verdict.feasible, verdict.findings


def test_a_gap_between_equal_waypoints_may_jump_by_rounding() -> None:
    pieces = [[[0.5, 0.0]], [[0.5 + 1e-13, 0.0]]]
    still = Trajectory([0.0, 1.0, 2.0], pieces, [0.0, 1.0, 2.0])
    assert audit(TrajectoryTask([[0.5]] * 3, Limits(velocity=1.0, acceleration=1.0)), still).feasible


def test_times_that_are_not_named_may_cost_the_verdict_and_that_is_noted() -> None:
    """0 to 1 and back, twice: the gap after the waypoint at 0.5 allows 0.9 rad/s, kept at the second passing only."""
    fast = [[0.0, 0.0, 3.0, -2.0]], [[1.0, 0.0, -3.0, 2.0]]
    slow = [[0.0, 0.0, 0.75, -0.25]], [[1.0, 0.0, -0.75, 0.25]]
    motion = Trajectory([0.0, 1.0, 2.0, 4.0, 6.0], [*fast, *slow], [0.0, 6.0])
    limits = np.array([[[-2.0], [2.0]], [[-0.9], [0.9]]])
    boundary = Boundary(velocity=0.0, acceleration=None)
    task = TrajectoryTask([[0.0], [0.5], [0.0]], Limits(velocity=limits), boundary=boundary)
    unnamed = audit(task, motion)
    assert not unnamed.feasible
    assert unnamed.notes == (
        "the trajectory does not name the times at which it passes the waypoints; they were taken where it comes "
        "nearest (0.5 s), and other times may keep limits of gaps or tolerances that these do not",
    )
    named = audit(task, replace(motion, waypoint_times=[0.0, 3.0, 6.0]))
    assert named.feasible
    assert named.notes == ()


def test_a_box_touched_in_its_corner_needs_its_time_named() -> None:
    """Past the box around (0, 0): the nearest point is outside it, a corner is touched a little later."""
    motion = Trajectory([0.0, 2.0], [[[-1.0, 1.0], [0.6, -0.3]]], [0.0, 2.0])
    boundary = Boundary(velocity=[[1.0, -0.3], [1.0, -0.3]], acceleration=None)
    box = [[0.0, 0.0], [0.3, 0.22], [0.0, 0.0]]
    task = TrajectoryTask(motion([0.0, 1.0, 2.0]) * [[1], [0], [1]], tolerance=box, boundary=boundary)
    unnamed = audit(task, motion)
    assert not unnamed.feasible
    assert len(unnamed.notes) == 1
    assert audit(task, replace(motion, waypoint_times=[0.0, 1.28, 2.0])).feasible
