"""Tasks that were once lost or solved badly, each the smallest of its kind, with the value that is right."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from helpers.small_tasks import plain_task
from ocp_traj.case import load_case
from ocp_traj.solving import solve
from ocp_traj.task import Boundary, Limits, Objective, TrajectoryTask

FAULTS = Path(__file__).resolve().parents[2] / "data" / "faults"
LEAST_JERK = {"minjerk-cubic": 21617.0}
"""Integral of squared jerk at best, a fine quadratic programme with free end accelerations."""


def fault(name: str) -> TrajectoryTask:
    return load_case(FAULTS / f"{name}.toml")


def alike(n: int, knots: int) -> TrajectoryTask:
    points = np.deg2rad([[0.0], [30.0], [10.0]]) * np.ones(n)
    return TrajectoryTask(points, Limits(velocity=1.3), virtual_knots=knots)


def test_joints_that_move_alike_with_velocity_limits_only() -> None:
    result = solve(fault("alike-joints"))
    assert result.feasible and result.status == "converged"
    least = np.deg2rad(30 + 20) / 1.3  # all the way at the velocity limit
    assert least <= result.duration <= 1.01 * least


@pytest.mark.parametrize("knots", [0, 1, 3])
@pytest.mark.parametrize("n", [1, 2, 4, 7, *(pytest.param(n, marks=pytest.mark.slow) for n in (3, 5, 6, 8))])
def test_as_many_joints_as_one_likes_move_alike_as_fast_as_one(n: int, knots: int) -> None:
    result, one = solve(alike(n, knots)), solve(alike(1, knots))
    assert result.feasible and result.status == "converged"
    assert result.duration == pytest.approx(one.duration, rel=1e-3)


def test_an_end_that_moves_is_reached_by_way_of_a_late_via_point_without_a_loop() -> None:
    result = solve(fault("moving-end-via-late"))
    assert result.feasible
    peak = np.sqrt((2 * 5.0 * 0.3 + 1.5**2) / 2)  # rest to 1.5 rad/s over 0.3 rad with 5 rad/s^2
    exact = peak / 5.0 + (peak - 1.5) / 5.0
    assert exact == pytest.approx(0.34807, abs=5e-6)
    assert exact * (1 - 1e-6) <= result.duration <= 1.005 * exact


@pytest.mark.parametrize("weight", [1e3, 1.0, 1e-3, 1e-6])
def test_least_jerk_within_position_limits_is_feasible_whatever_its_weight(weight: float) -> None:
    task = fault("minjerk-cubic")
    result = solve(task.changed(objective=replace(task.objective, jerk=weight)))
    assert result.feasible and result.status == "converged"
    assert LEAST_JERK["minjerk-cubic"] <= result.objective / weight <= 1.025 * LEAST_JERK["minjerk-cubic"]


@pytest.mark.parametrize("family", ["quintic", "septic"])
def test_other_families_keep_the_position_limit_at_given_times(family: str) -> None:
    result = solve(fault("minjerk-cubic").changed(family=family, virtual_knots=2))
    assert result.feasible, result


def test_given_durations_are_met_and_a_limit_that_is_just_reached_is_kept() -> None:
    result = solve(fault("fixed-septic"))
    assert result.feasible and result.objective < 25_000.0
    np.testing.assert_allclose(result.segment_durations, [1.3, 0.7], rtol=1e-12)


def test_lower_bounds_of_gaps_are_met_however_far_the_upper_ones() -> None:
    result = solve(fault("gap-bounds"))
    assert result.feasible and result.status == "converged"
    np.testing.assert_allclose(result.segment_durations, [1.7, 1.7], rtol=1e-7)


def test_gaps_of_half_a_millisecond_at_rest_are_solved() -> None:
    result = solve(fault("microseconds"))
    assert result.feasible and result.duration == pytest.approx(1e-3, rel=1e-6)


def rest_to_speed(rng: np.random.Generator, start_moves: bool) -> tuple[TrajectoryTask, float]:
    """Return one joint from rest to a speed, or back, by way of one to four points; and the exact duration, s."""
    distance, most = rng.uniform(0.2, 2.0), 5.0
    speed = rng.uniform(0.2, 0.98) * np.sqrt(2 * most * distance)
    passed = np.sort(rng.uniform(0.03, 0.97, rng.integers(1, 5))) * distance
    points = np.concatenate([[0.0], passed, [distance]])[:, None]
    points = distance - points[::-1] if start_moves else points
    ends = [[speed], [0.0]] if start_moves else [[0.0], [speed]]
    limits = Limits(velocity=50.0, acceleration=most)
    task = TrajectoryTask(points, limits, virtual_knots=3, boundary=Boundary(velocity=ends))
    peak = np.sqrt((2 * most * distance + speed**2) / 2)
    return task, (2 * peak - speed) / most


@pytest.mark.parametrize("count", [40, pytest.param(400, marks=pytest.mark.long)])
def test_random_tasks_of_one_joint_with_an_end_that_moves_take_the_exact_time(count: int) -> None:
    rng = np.random.default_rng(1)
    ratios = []
    for index in range(count):
        task, exact = rest_to_speed(rng, start_moves=bool(index % 2))
        result = solve(task)
        assert result.feasible, result
        ratios.append(result.duration / exact)
    assert min(ratios) > 1 - 1e-6
    assert np.mean(np.array(ratios) <= 1.005) >= 0.99, sorted(ratios)[-5:]


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"virtual_knots": 3},
        {"family": "quintic", "virtual_knots": 1},
        {"limits": Limits(velocity=2.0, acceleration=4.0, jerk=30.0), "virtual_knots": 2},
    ],
    ids=["cubic", "knots", "quintic", "jerk"],
)
@pytest.mark.parametrize("budget", [1, 3])
def test_a_solver_stopped_at_once_still_has_a_feasible_motion(budget: int, changes: dict[str, Any]) -> None:
    task = plain_task().changed(**changes)
    result = solve(task, budget=budget)
    assert result.status == "budget_exhausted"
    assert result.feasible, result
    assert result.duration < 5 * solve(task).duration


def test_a_solver_out_of_time_still_has_a_feasible_motion() -> None:
    result = solve(plain_task(virtual_knots=3), time_limit=1e-9)
    assert (result.status, result.feasible) == ("time_exhausted", True)


@pytest.mark.parametrize(("low", "high"), [(0.0, np.inf), (7.0, np.inf), (7.0, 7.5)])
def test_bounds_of_durations_are_kept_by_the_motion_of_a_solver_stopped_at_once(low: float, high: float) -> None:
    bounds = Objective(gap_durations=[[low, high], [0.0, np.inf]])
    result = solve(plain_task(virtual_knots=2, objective=bounds), budget=1)
    assert result.feasible and low * (1 - 1e-9) <= result.segment_durations[0] <= high * (1 + 1e-9)
