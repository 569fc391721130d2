"""Numerical edges: the smallest, the largest, the slowest, and problems that are feasible by a hair."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.audit import audit
from ocp_traj.solving import solve
from ocp_traj.task import Limits, Objective, TrajectoryTask


def double_integrator(amplitude: float, velocity: float, acceleration: float) -> float:
    """Shortest time from rest to rest over a distance with bounded velocity and acceleration."""
    if amplitude * acceleration <= velocity**2:
        return 2 * np.sqrt(amplitude / acceleration)
    return amplitude / velocity + velocity / acceleration


@pytest.mark.parametrize("seconds", [1e-6, 1e-3, 1.0, 86_400.0, 3e6])
def test_durations_from_microseconds_to_weeks_are_found(seconds):
    acceleration = 4.0 / seconds**2
    task = TrajectoryTask([[0.0], [1.0]], Limits(acceleration=acceleration), virtual_knots=3)
    result = solve(task)
    assert result.feasible, result
    assert result.duration == pytest.approx(double_integrator(1.0, np.inf, acceleration), rel=1e-4)


@pytest.mark.parametrize("size", [1e-9, 1e-6, 1e3])
def test_travels_from_nanometres_to_kilometres_are_found(size):
    task = TrajectoryTask([[0.0], [size]], Limits(velocity=2 * size, acceleration=8 * size), virtual_knots=7)
    result = solve(task)
    assert result.feasible, result
    assert result.duration == pytest.approx(double_integrator(1.0, 2.0, 8.0), rel=1e-3)


def test_thirty_joints_are_solved():
    rng = np.random.default_rng(0)
    task = TrajectoryTask(
        rng.uniform(-1, 1, (4, 30)), Limits(velocity=1.0, acceleration=2.0), virtual_knots=1
    )
    result = solve(task)
    assert result.feasible, result


@pytest.mark.slow
def test_a_thousand_waypoints_are_solved():
    rng = np.random.default_rng(0)
    waypoints = np.cumsum(rng.uniform(-0.2, 0.2, (1000, 2)), axis=0)
    result = solve(TrajectoryTask(waypoints, Limits(velocity=1.0, acceleration=2.0)))
    assert result.feasible, result


def test_waypoints_exactly_at_the_position_limits_are_allowed():
    position = np.array([[-1.0, -1.0], [1.0, 1.0]])
    limits = Limits(position=position, velocity=1.0, acceleration=1.0)
    task = TrajectoryTask([[-1.0, 1.0], [1.0, -1.0], [-1.0, 1.0]], limits, virtual_knots=1)
    result = solve(task)
    assert result.feasible, result


def test_a_start_that_is_already_optimal_stays():
    task = TrajectoryTask([[0.0], [1.0]], Limits(acceleration=4.0), virtual_knots=3)
    first = solve(task)
    again = solve(task, warm_start=first.trajectory)
    assert again.feasible
    assert again.duration <= first.duration


def test_a_duration_too_short_by_a_hair_is_infeasible_and_the_hair_longer_is_not():
    limits = Limits(acceleration=4.0)
    shortest = solve(TrajectoryTask([[0.0], [1.0]], limits, virtual_knots=1)).duration
    assert shortest == pytest.approx(np.sqrt(1.5), rel=1e-6)
    short = TrajectoryTask(
        [[0.0], [1.0]], limits, virtual_knots=1, objective=Objective(duration=(0.1, shortest * 0.999))
    )
    refused = solve(short)
    assert not refused.feasible
    assert "duration" in refused.message or "acceleration" in refused.message
    long = TrajectoryTask(
        [[0.0], [1.0]], limits, virtual_knots=1, objective=Objective(duration=(0.1, shortest * 1.001))
    )
    assert solve(long).feasible


def test_the_audit_refuses_what_is_over_by_more_than_its_tolerance_and_nothing_less():
    task = TrajectoryTask([[0.0], [1.0]], Limits(acceleration=4.0), virtual_knots=1)
    motion = solve(task).trajectory
    peak = float(np.abs(motion(motion.breakpoints, 2)).max())
    for excess, verdict in ((2e-6, False), (1e-7, True)):
        limit = Limits(acceleration=peak / (1 + excess))
        assert audit(TrajectoryTask([[0.0], [1.0]], limit, virtual_knots=1), motion).feasible is verdict


def test_two_equal_waypoints_in_a_row_are_passed():
    task = TrajectoryTask(
        [[0.0, 0.0], [1.0, 0.5], [1.0, 0.5], [2.0, 0.0]], Limits(velocity=1.0, acceleration=2.0)
    )
    result = solve(task)
    assert result.feasible, result


def test_a_joint_that_never_moves_may_have_zero_limits():
    limits = Limits(velocity=[1.0, 0.0], acceleration=[2.0, 0.0])
    result = solve(TrajectoryTask([[0.0, 0.3], [1.0, 0.3], [0.5, 0.3]], limits, virtual_knots=1))
    assert result.feasible, result
    assert np.ptp(result.trajectory(np.linspace(0, result.duration, 50))[:, 1]) == 0
