"""Motions whose files do not say when the waypoints are passed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from helpers.audit_motions import clamped_cubic
from ocp_traj.audit import audit
from ocp_traj.audit.waypoints import with_waypoint_times
from ocp_traj.exceptions import InputError
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory


def nameless(trajectory: Trajectory) -> Trajectory:
    """Drop the inner waypoint times."""
    return replace(trajectory, waypoint_times=trajectory.waypoint_times[[0, -1]])


@pytest.mark.parametrize("seed", range(8))
def test_waypoints_are_found_where_they_are(seed: int) -> None:
    rng = np.random.default_rng(seed)
    waypoints = rng.normal(size=(int(rng.integers(3, 9)), 3))
    trajectory = clamped_cubic(waypoints, rng.uniform(0.2, 1.0, len(waypoints) - 1))
    found = with_waypoint_times(TrajectoryTask(waypoints), nameless(trajectory))
    assert found.waypoint_times == pytest.approx(trajectory.waypoint_times, abs=1e-7)


def test_waypoints_inside_pieces_become_breakpoints_of_the_same_curve() -> None:
    waypoints = np.array([[0.0, 0.0], [0.5, 0.5], [1.0, 1.0]])
    trajectory = clamped_cubic(waypoints[[0, 2]], np.array([2.0]))
    task = TrajectoryTask(waypoints, Limits(velocity=[[[-1, -1], [1, 1]], [[-0.5, -1], [0.5, 1]]]))
    found = with_waypoint_times(task, trajectory)
    assert found.breakpoints == pytest.approx([0.0, 1.0, 2.0])
    times = np.linspace(0, 2, 77)
    for order in range(4):
        assert found(times, order) == pytest.approx(trajectory(times, order), abs=1e-12)
    verdict = audit(task, trajectory)
    assert verdict.waypoint_error < 1e-12
    assert verdict.limits["velocity"].gap == 1
    assert verdict.limits["velocity"].ratio == pytest.approx(1.5)


def test_waypoints_that_repeat_are_told_apart_by_their_order() -> None:
    waypoints = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
    trajectory = clamped_cubic(waypoints, np.array([0.5, 0.7, 0.4, 0.9]))
    found = with_waypoint_times(TrajectoryTask(waypoints), nameless(trajectory))
    assert found.waypoint_times == pytest.approx(trajectory.waypoint_times, abs=1e-7)


def test_a_motion_that_misses_a_waypoint_is_told_so() -> None:
    waypoints = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    trajectory = clamped_cubic(waypoints, np.array([1.0, 1.0]))
    asked = np.array([[0.0, 0.0], [1.2, -0.1], [1.0, 1.0]])
    verdict = audit(TrajectoryTask(asked), nameless(trajectory))
    assert not verdict.feasible
    assert 0.05 < verdict.waypoint_error < 0.3
    assert verdict.findings[0].startswith("waypoint 2: joint ")


def test_waypoint_times_that_are_no_breakpoints_are_cut_in() -> None:
    trajectory = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    middle = replace(trajectory, waypoint_times=[0.0, 0.25, 1.0])
    verdict = audit(TrajectoryTask([[0.0], trajectory(0.25), [1.0]], Limits(velocity=2.0)), middle)
    assert verdict.feasible
    assert verdict.waypoint_error < 1e-15


def test_waypoints_that_cannot_be_told_apart_in_time_are_an_error() -> None:
    trajectory = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    with pytest.raises(InputError, match="cannot be told from its shape"):
        audit(TrajectoryTask([[0.0], [0.6], [0.4], [1.0]]), trajectory)
