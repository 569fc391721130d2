"""A search that found no feasible motion says what stood in its way, and claims no proof."""

from __future__ import annotations

import numpy as np
import pytest

from metaheuristics import Status
from ocp_traj.solvers.population.explaining import outside_search
from ocp_traj.solving import solve
from ocp_traj.task import Limits, Objective, Search, TrajectoryTask

LIMITS = Limits(velocity=1.0, acceleration=2.0)


def task(duration: tuple[float, float], waypoints=(0.0, 0.5, 2.5), **changes) -> TrajectoryTask:
    points = np.array(waypoints)[:, None]
    return TrajectoryTask(points, LIMITS, search=Search(duration=duration), **changes)


@pytest.mark.parametrize("solver", ["pso", "de", "ssa"])
def test_a_box_that_is_too_small_is_named_for_what_it_is(solver: str) -> None:
    result = solve(task((0.05, 1.0)), solver, budget=300)
    assert result.solution.status is Status.STALLED and not result.feasible
    assert "search.duration binds" in result.message and "gap 2 takes joint 1 at least 2 s" in result.message
    assert solve(task((6.0, 20.0)), solver, budget=500).feasible


def test_gaps_are_named_by_the_numbers_of_the_task() -> None:
    result = solve(task((0.05, 1.0), (0.0, 0.0, 0.5, 2.5)), "pso", budget=100)
    assert "gap 3 takes joint 1 at least 2 s" in result.message


def test_a_gap_as_long_as_is_searched_is_named() -> None:
    result = solve(task((0.05, 2.2)), "pso", budget=2000)  # 2 s at full speed, and more to get there
    assert result.status == "stalled"
    assert "search.duration binds: its gap 2 lasts as long as is searched at most, 2.2 s" in result.message
    assert "breaks velocity, joint 1, gap 2" in result.message


def test_bounds_of_durations_that_lie_outside_the_search_are_named() -> None:
    total = outside_search(task((2.0, 5.0), objective=Objective(duration=(0.0, 3.0))))
    assert "gaps of at least 2 s are searched, together 4 s" in total and "at most 3 s" in total
    gap = outside_search(task((0.1, 5.0), objective=Objective(gap_durations=[[0.0, np.inf], [6.0, 7.0]])))
    assert "gap 2 has to last 6 to 7 s" in gap
    assert not outside_search(task((0.1, 5.0)))


def test_a_limit_that_no_candidate_kept_is_named_without_the_box() -> None:
    result = solve(task((0.05, 500.0), objective=Objective(duration=(0.0, 2.0))), "pso", budget=200)
    assert result.status == "stalled" and "No motion was found: the best candidate breaks" in result.message
    assert "search.duration" not in result.message
