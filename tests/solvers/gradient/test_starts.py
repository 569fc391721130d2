"""Other motions to start from: their order, their number, and what decides their durations."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.solvers import Request, parse_solver
from ocp_traj.solvers.gradient.starts import (
    DURATION_STRETCH,
    centripetal_durations,
    other_starts,
    random_factors,
    toppra_durations,
)
from ocp_traj.solvers.outcomes import run_from_each
from ocp_traj.task import Boundary, Limits, TrajectoryTask
from ocp_traj.transcription.guess import closed_form_durations, initial_guess

LIMITS = Limits(velocity=2.0, acceleration=4.0)


def task(**changes: object) -> TrajectoryTask:
    return TrajectoryTask([[0.0, 0.0], [1.0, 0.5], [0.5, 1.0]], LIMITS, **{"virtual_knots": 0, **changes})  # type: ignore[arg-type]


@pytest.mark.parametrize("count", [0, 1, 2, 5])
def test_there_are_as_many_starts_as_asked_for(count: int) -> None:
    assert len(list(other_starts(task(), np.random.default_rng(0), count))) == count


def test_centripetal_timing_comes_first_then_toppra_then_random_proportions() -> None:
    first, second, *others = other_starts(task(), np.random.default_rng(7), 5)
    np.testing.assert_allclose(
        first.segment_durations, initial_guess(task(), centripetal_durations(task())).segment_durations
    )
    timed = toppra_durations(task())
    assert timed is not None
    np.testing.assert_allclose(second.segment_durations, initial_guess(task(), timed).segment_durations)
    factors = list(random_factors(task(), np.random.default_rng(7), 3))
    for motion, each in zip(others, factors, strict=True):
        wanted = initial_guess(task(), closed_form_durations(task()) * DURATION_STRETCH * each)
        np.testing.assert_allclose(motion.segment_durations, wanted.segment_durations)


def test_a_moving_boundary_has_no_timing_by_toppra_and_one_random_start_more() -> None:
    moving = task(boundary=Boundary([[0.1, 0.0], [0.0, 0.0]]))
    assert toppra_durations(moving) is None
    assert len(list(other_starts(moving, np.random.default_rng(0), 4))) == 4


def test_centripetal_durations_grow_with_the_root_of_the_distance() -> None:
    steps = np.array([[0.0], [4.0], [5.0], [5.0]])
    durations = centripetal_durations(TrajectoryTask(steps, LIMITS))
    np.testing.assert_allclose(durations, [1.0, 0.5, 0.05])


def test_random_factors_have_the_spread_asked_for_and_repeat_by_seed() -> None:
    drawn = np.array(list(random_factors(task(), np.random.default_rng(3), 4000, 0.3)))
    assert drawn.shape == (4000, 2)
    assert np.log(drawn).std() == pytest.approx(0.3, rel=0.05)
    assert np.log(drawn).mean() == pytest.approx(0.0, abs=0.02)
    again = np.array(list(random_factors(task(), np.random.default_rng(3), 4000, 0.3)))
    np.testing.assert_array_equal(drawn, again)


def test_runs_share_one_budget_and_the_first_one_is_always_made() -> None:
    solver, starts = parse_solver("ipopt"), [None, initial_guess(task()), initial_guess(task())]
    begin = -1e9  # long ago
    assert len(run_from_each(solver, task(), Request(budget=10_000), starts, begin=0.0)) == 3
    one = run_from_each(solver, task(), Request(), starts[:1], begin=0.0)[0].solution.evaluations
    few = run_from_each(solver, task(), Request(budget=one + 2), starts, begin=0.0)
    assert len(few) == 2 and few[1].solution.status.key == "budget_exhausted"
    assert len(run_from_each(solver, task(), Request(time_limit=5.0), starts, begin=begin)) == 1
