"""Running times, distributions and profiles, against hand-computed numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ocp_traj.comparison.report.profiles import (
    Course,
    best_at,
    course_of,
    data_profiles,
    distribution,
    expected_running_time,
    performance_profiles,
    simulate_restarts,
)
from ocp_traj.comparison.runs.record import RunRecord
from ocp_traj.comparison.runs.store import StoredRun

INF = np.inf
HISTORY: dict[str, Any] = {
    "evaluations": [10, 20, 30, 40],
    "cost": [1.0, 9.0, 6.0, 5.0],
    "violation": [0.3, 0.0, 0.0, 0.0],
    "seconds": [0.1, 0.2, 0.3, 0.4],
}


def row(**changes: Any) -> StoredRun:
    values: dict[str, Any] = {
        "status": "converged",
        "claimed": True,
        "feasible": True,
        "objective": 5.0,
        "evaluations": 50,
        "build_time": 1.0,
        "solve_time": 0.5,
        "history": HISTORY,
        **changes,
    }
    return StoredRun("c", "case", "s", "d", 1, 0, None, None, RunRecord(**values), None, 1)


def test_a_course_counts_feasible_points_only_and_adds_the_build_time() -> None:
    course = course_of(row(), 100)
    assert course.reach(9.0, "evaluations") == 20
    assert course.reach(6.5, "seconds") == pytest.approx(1.3)
    assert course.reach(4.9, "evaluations") == INF
    assert (course.spent("evaluations"), course.spent("seconds")) == (50, 1.5)


def test_a_refused_answer_reaches_nothing_but_costs_what_it_cost() -> None:
    course = course_of(row(feasible=False), 100)
    assert course.reach(1e9, "evaluations") == INF
    assert course.spent("evaluations") == 50


def test_a_run_that_died_costs_what_its_siblings_may() -> None:
    course = course_of(row(feasible=False, evaluations=None, solve_time=None, wall_time=7.0, history={}), 100)
    assert (course.spent("evaluations"), course.spent("seconds")) == (100, 7.0)


def test_a_cost_better_than_the_audited_one_does_not_count_as_such() -> None:
    course = course_of(row(objective=5.5), 100)
    assert course.reach(5.4, "evaluations") == INF
    assert course.reach(5.5, "evaluations") == 40


def fixed(reached: float, spent: float) -> Course:
    times = np.array([reached] if np.isfinite(reached) else [])
    return Course(times, times, np.zeros(times.size), spent, spent)


def test_the_expected_running_time_adds_failures() -> None:
    courses = [fixed(10, 50), fixed(INF, 50), fixed(20, 50)]
    assert expected_running_time(courses, 0.0, "evaluations") == (10 + 20 + 50) / 2
    assert expected_running_time(courses[1:2], 0.0, "evaluations") == INF


def test_simulated_restarts_have_the_expected_running_time_as_mean() -> None:
    courses = [fixed(10, 50), fixed(INF, 50), fixed(INF, 80), fixed(30, 50)]
    times = simulate_restarts(courses, 0.0, "evaluations", np.random.default_rng(0), draws=40_000)
    assert times.mean() == pytest.approx(expected_running_time(courses, 0.0, "evaluations"), rel=0.02)
    assert times.min() == 10


def test_restarts_of_a_hopeless_solver_never_end() -> None:
    assert np.isinf(simulate_restarts([fixed(INF, 5)], 0.0, "seconds", np.random.default_rng(0))).all()


def test_a_distribution_counts_what_never_comes() -> None:
    curve = distribution(np.array([3.0, INF, 1.0, 2.0]))
    np.testing.assert_array_equal(curve.x, [1, 2, 3])
    np.testing.assert_array_equal(curve.y, [0.25, 0.5, 0.75])


def test_performance_profiles_by_hand() -> None:
    first, second = performance_profiles(np.array([[1.0, 2.0], [4.0, 2.0], [INF, 3.0], [INF, INF]]))
    np.testing.assert_array_equal((first.x, first.y), ([1, 2], [0.25, 0.5]))
    np.testing.assert_array_equal((second.x, second.y), ([1, 1, 2], [0.25, 0.5, 0.75]))


def test_data_profiles_divide_by_the_simplex() -> None:
    (curve,) = data_profiles(np.array([[30.0], [INF]]), np.array([2.0, 5.0]))
    np.testing.assert_array_equal((curve.x, curve.y), ([10.0], [0.5]))


def test_the_best_after_a_budget() -> None:
    course = course_of(row(), 100)
    np.testing.assert_array_equal(
        best_at(course, np.array([15.0, 30.0, 1e9]), "evaluations"), [INF, 6.0, 5.0]
    )
