"""Tasks that have a motion by construction are solved well; where a task is called infeasible, another proof agrees."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
import pytest

from helpers.drawn.impossible import has_no_motion
from helpers.drawn.solvable_tasks import moving_end_task, random_start, solvable_task, squeezed_task
from ocp_traj.audit import audit
from ocp_traj.audit.costs import objective_value
from ocp_traj.solvers import Request
from ocp_traj.solvers.gradient.account import Account
from ocp_traj.solvers.gradient.attempt import attempt
from ocp_traj.solvers.gradient.gradient import Gradient
from ocp_traj.solvers.gradient.ranking import value
from ocp_traj.solving import solve
from ocp_traj.task import TrajectoryTask

logger = logging.getLogger(__name__)


def best_of_starts(task: TrajectoryTask, count: int) -> float:
    """Return the least objective of feasible motions from random starts, infinite where there are none."""
    rng, best = np.random.default_rng(0), np.inf
    for _ in range(count):
        start = random_start(task, rng)
        answer = attempt(task, start, Gradient(iterations=200), Account(Request()), continued=False)
        excess, cost = value(task, answer.trajectory)
        best = min(best, cost) if excess == 0.0 else best
    return best


@pytest.mark.parametrize("seed", range(12))
def test_the_motion_that_limits_are_drawn_around_keeps_them(seed: int) -> None:
    drawn = solvable_task(seed)
    assert audit(drawn.task, drawn.witness).feasible
    again = solvable_task(seed)
    np.testing.assert_array_equal(again.witness.coefficients, drawn.witness.coefficients)


@pytest.mark.parametrize(
    ("seeds", "starts"),
    [
        pytest.param(range(1, 5), 0, id="few"),
        pytest.param(range(50), 10, marks=pytest.mark.long, id="some"),
        pytest.param(range(1000), 10, marks=pytest.mark.long, id="all"),
    ],
)
def test_tasks_that_have_a_motion_are_solved_and_solved_well(seeds: range, starts: int) -> None:
    ratios, slow = [], 0
    for seed in seeds:
        drawn = solvable_task(seed)
        result = solve(drawn.task)
        known = min(best_of_starts(drawn.task, starts), objective_value(drawn.task, drawn.witness))
        reached = result.objective if result.feasible and result.objective is not None else np.inf
        ratios.append(reached / min(known, reached))
        slow += "slow one" in result.message
        if not ratios[-1] <= 1.01:
            logger.warning("seed %d: %.4g times the best, %s, %s", seed, ratios[-1], drawn.kinds, result.message)
    found = np.array(ratios)
    print(f"within 1 %: {np.mean(found <= 1.01):.4f}, within 5 %: {np.mean(found <= 1.05):.4f}, slow: {slow}")
    assert np.isfinite(found).all()
    assert (found <= 1.05).all() and np.mean(found <= 1.01) >= 0.95
    assert slow <= 0.01 * len(found)


@pytest.mark.parametrize(
    ("seeds", "starts"), [((9, 45), 2), pytest.param(range(100), 20, marks=pytest.mark.long)]
)
def test_several_joints_with_moving_ends_are_as_fast_as_from_the_best_of_many_starts(
    seeds: range, starts: int
) -> None:
    for seed in seeds:
        task = moving_end_task(seed)
        result = solve(task)
        assert result.feasible, result
        assert result.duration <= 1.01 * best_of_starts(task, starts), f"seed {seed}: {result}"


@pytest.mark.parametrize("seeds", [range(2), pytest.param(range(300), marks=pytest.mark.long)])
def test_what_is_called_infeasible_is_proved_again_another_way(seeds: range) -> None:
    called = 0
    for seed in seeds:
        task = squeezed_task(seed)
        result = solve(replace(task, name=f"squeezed-{seed}"), time_limit=20.0)
        if result.status == "infeasible":
            called += 1
            assert has_no_motion(task), f"seed {seed}: {result.message}"
        assert result.feasible or result.message
    print(f"{called} of {len(seeds)} called infeasible")
