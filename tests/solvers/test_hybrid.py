"""Population search and gradient solver together: not worse than their parts, and within one budget."""

from __future__ import annotations

import numpy as np
import pytest

from helpers.condensed_tasks import LIMITS, make_task
from ocp_traj import load_case
from ocp_traj.exceptions import InputError
from ocp_traj.solvers import Request, parse_solver
from ocp_traj.solvers.hybrid import join_outcomes
from ocp_traj.solving import solve

BEST = 4.310382


@pytest.mark.parametrize("name", ["pso+ipopt", "ssa+ipopt", "issa+ipopt", "issa-b+ipopt"])
def test_ipopt_finishes_what_the_population_found(name: str) -> None:
    task = load_case("machines-2024-490")
    method = {"issa+ipopt": "issa-a"}.get(name, name.removesuffix("+ipopt"))
    alone = solve(task, f"{method}[encoding=scaled]", budget=200)
    result = solve(task, name, budget=400)
    assert result.feasible
    assert result.duration == pytest.approx(BEST, rel=1e-6)
    assert result.duration < alone.duration
    assert result.counts["evaluate"] == 200
    assert result.counts["nlp_f"] > 0
    assert result.solution.evaluations <= 400
    assert "Best of " in result.message
    history = result.solution.history
    assert (np.diff(history.evaluations) >= 0).all()
    assert (np.diff(history.seconds) >= 0).all()


def test_the_share_of_the_population_and_the_number_of_starts_are_settings() -> None:
    task = load_case("machines-2024-490")
    result = solve(task, "de+ipopt[starts=1,share=0.25,encoding=durations]", budget=800)
    assert result.counts["evaluate"] == 200
    assert "Best of 2 runs." in result.message


def test_without_budget_for_the_second_part_the_population_answers() -> None:
    result = solve(load_case("machines-2024-490"), "pso+ipopt[share=0.999]", budget=200)
    assert result.counts == {"evaluate": 199}
    assert result.encoding == "scaled"


def test_the_per_joint_protocol_is_refused() -> None:
    task = load_case("machines-2024-490", overrides=['search.protocol="per-joint"'])
    with pytest.raises(InputError, match="moves all joints together"):
        solve(task, "pso+ipopt", budget=100)


@pytest.mark.parametrize("jobs", [1, 2])
def test_several_starts_are_not_worse_than_one(jobs: int) -> None:
    task = make_task("cubic", {**LIMITS["velocity"], **LIMITS["acceleration"]}, virtual_knots=1)
    one = solve(task, "ipopt")
    several = solve(task, f"ipopt-multistart[starts=3,spread=0.4,jobs={jobs}]", seed=1)
    assert several.feasible
    assert several.duration <= one.duration * (1 + 1e-7)
    assert several.solution.evaluations > one.solution.evaluations
    assert "Best of 3 runs." in several.message


def test_starts_differ_by_seed_and_repeat_by_seed() -> None:
    task = load_case("machines-2024-490")
    counts = [solve(task, "ipopt-multistart[starts=3,spread=1.0]", seed=seed).counts for seed in (1, 1, 2)]
    assert counts[0] == counts[1] != counts[2]


def test_the_better_of_two_outcomes_is_the_feasible_one() -> None:
    task = make_task("cubic", LIMITS["velocity"], search=(0.2, 4.0))
    good = parse_solver("random[encoding=scaled]").run(task, Request(budget=5))
    tight = make_task("cubic", LIMITS["velocity"], search=(0.2, 0.21))
    broken = parse_solver("random").run(tight, Request(budget=5))
    assert broken.solution.cost < good.solution.cost
    joined = join_outcomes(task, [broken, good])
    assert joined.trajectory is good.trajectory
    assert joined.solution.evaluations == 10
    assert joined.counts == {"evaluate": 10}
