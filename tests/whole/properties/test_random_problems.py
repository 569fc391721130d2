"""Random problems of all kinds: every motion called feasible passes the audit, every failure says why."""

from __future__ import annotations

import logging

import pytest

from helpers.random_problems import RandomProblem, random_problem
from ocp_traj.exceptions import TaskError
from ocp_traj.solving import solve

FEW, SOME, MANY = 20, 14, 1000
SOLVED = 0.99
"""Part of the problems with a motion that has to be solved."""

logger = logging.getLogger(__name__)


def outcome(problem: RandomProblem) -> str:
    """``solved``, ``unsolved`` or ``explained``; fails where a failure is not explained or a flaw not found."""
    result = solve(problem.task)
    if result.feasible:
        assert not problem.flaw, f"{problem.task.name}: a motion was found though there is {problem.flaw}"
        assert result.audit is not None and result.audit.worst is not None
        assert result.audit.worst.ratio <= 1 + 1e-6
        return "solved"
    assert result.message and result.diagnosis, f"{problem.task.name}: fails without a reason"
    if problem.flaw:
        assert result.status == "infeasible", f"{problem.task.name}: {result.message}"
        return "explained"
    return "unsolved"


def count_outcomes(seeds: range) -> dict[str, int]:
    counts = {"solved": 0, "unsolved": 0, "explained": 0}
    for seed in seeds:
        try:
            problem = random_problem(seed)
        except TaskError as error:  # waypoints outside the position limits are refused as the task is made
            assert "outside its range" in str(error) or "fewer free coefficients than conditions, 5" in str(error)
            counts["explained"] += 1
            continue
        result = outcome(problem)
        counts[result] += 1
        if result == "unsolved":
            logger.warning("not solved: %s", problem.task.name)
    return counts


def test_few_random_problems() -> None:
    counts = count_outcomes(range(30, 30 + FEW))
    assert counts["unsolved"] == 0 and counts["solved"] >= FEW // 2


@pytest.mark.parametrize("seed", [470, 482])
def test_problems_that_once_stayed_unsolved(seed: int) -> None:
    """A septic of one joint, and a 3-5-3 whose optimum is where two extrema of the jerk meet."""
    assert outcome(random_problem(seed)) == "solved"


@pytest.mark.parametrize(
    "seeds",
    [pytest.param(range(SOME), marks=pytest.mark.slow), pytest.param(range(MANY), marks=pytest.mark.long)],
    ids=["some", "many"],
)
def test_many_random_problems(seeds: range) -> None:
    counts = count_outcomes(seeds)
    print(counts)
    assert counts["explained"] >= max(1, len(seeds) // 20)
    assert counts["solved"] >= SOLVED * (counts["solved"] + counts["unsolved"])
