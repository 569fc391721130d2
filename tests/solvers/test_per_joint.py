"""Every joint alone, then the largest duration per segment: papers B and D, and what the audit says of it."""

from __future__ import annotations

import numpy as np
import pytest

from helpers.condensed_tasks import LIMITS, OBJECTIVES, make_task
from ocp_traj import load_case
from ocp_traj.exceptions import InputError
from ocp_traj.solvers.per_joint import joint_task, moving_gaps, synchronise
from ocp_traj.solving import SolveResult, solve
from ocp_traj.transcription.condensed.condensed import CondensedNlp

ALONE = np.array(
    [
        [0.05, 0.05, 0.05],
        [1.5538, 0.3189, 0.5001],
        [1.0692, 0.4521, 0.0500],
        [1.0656, 0.1963, 0.7277],
        [0.0500, 0.6120, 1.0187],
        [0.0500, 0.9799, 1.2263],
    ]
)
"""Durations of paper B's joints, each optimised alone, rounded."""


def paper_b() -> object:
    return load_case("machines-2024-490", overrides=['search.protocol="per-joint"'])


@pytest.fixture(scope="module")
def answer() -> SolveResult:
    return solve(paper_b(), "de", budget=30_000)  # type: ignore[arg-type]


def test_the_synchronised_motion_of_paper_b_breaks_the_acceleration_limit(answer: SolveResult) -> None:
    """Facts known before: 3.76 s, and about 59 % over the acceleration limit."""
    assert answer.duration == pytest.approx(3.76, abs=0.01)
    assert not answer.feasible
    assert answer.audit is not None
    worst = answer.audit.worst
    assert worst is not None
    assert worst.limit == "acceleration"
    assert worst.ratio == pytest.approx(1.59, abs=0.01)
    assert "joint 2, gap 2" in answer.message


def test_the_budget_is_shared_equally_among_moving_joints(answer: SolveResult) -> None:
    assert answer.solution.evaluations == answer.counts["evaluate"] == 30_000
    with pytest.raises(
        InputError, match="a budget of 4 cannot be shared, expected at least 1 a moving joint"
    ):
        solve(paper_b(), "pso", budget=4)  # type: ignore[arg-type]


def test_a_joint_that_rests_in_a_gap_does_not_stretch_it() -> None:
    task = load_case("machines-2024-490")
    moves = moving_gaps(task, ALONE)
    # Joint 6 stands between equal waypoints in gap 1, but passes waypoint 3 with a velocity: it moves in gap 2.
    expected = np.array([[0, 0, 0], [1, 1, 1], [1, 1, 0], [1, 1, 1], [0, 1, 1], [0, 1, 1]], dtype=bool)
    np.testing.assert_array_equal(moves, expected)
    long_rest = ALONE.copy()
    long_rest[2, 2] = 3.9
    np.testing.assert_allclose(synchronise(task, long_rest), [1.5538, 0.9799, 1.2263])


def test_every_joint_alone_keeps_its_limits() -> None:
    task = load_case("machines-2024-490")
    for joint in range(1, 6):
        nlp = CondensedNlp(joint_task(task, joint))
        assert nlp.task.n == 1
        over = nlp.evaluate(ALONE[joint] * 1.001)
        assert over.total_violation[0] < 1e-9
        assert nlp.evaluate(ALONE[joint] * 0.99).total_violation[0] > 1e-3


def test_the_same_seed_is_the_same_motion() -> None:
    first, again, other = (solve(paper_b(), "pso", seed=seed, budget=500) for seed in (1, 1, 2))  # type: ignore[arg-type]
    assert first.duration == again.duration != other.duration


def test_other_costs_and_virtual_knots_are_refused() -> None:
    from dataclasses import replace

    for task in (
        make_task("quintic", LIMITS["velocity"], OBJECTIVES["energy"]),
        make_task("quintic", LIMITS["velocity"], OBJECTIVES["jerk"]),
        make_task("quintic", LIMITS["velocity"], virtual_knots=1),
    ):
        apart = replace(task, search=replace(task.search, protocol="per-joint"))
        with pytest.raises(InputError, match="the per-joint protocol minimises the time"):
            solve(apart, "pso", budget=100)
