"""Population methods get the same problem as everybody, within the same budget, in each encoding."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest

from helpers.condensed_tasks import LIMITS, OBJECTIVES, make_task
from metaheuristics import Evaluation
from ocp_traj import load_case
from ocp_traj.solving import solve
from ocp_traj.transcription.condensed.condensed import CondensedNlp

METHODS = (
    "pso",
    "pso-constriction",
    "pso-d",
    "ssa",
    "ssa-debiased",
    "issa-a",
    "issa-b",
    "t-ssa",
    "tadf-ssa",
    "de",
    "random",
)
BEST = 4.310382
"""Best shared durations of paper B's case, s."""


@pytest.fixture
def evaluated(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Count the candidates that reach the batched evaluation."""
    counts: Counter[str] = Counter()
    original = CondensedNlp.evaluate

    def evaluate(nlp: CondensedNlp, X: np.ndarray) -> Evaluation:
        counts["evaluate"] += len(np.atleast_2d(X))
        return original(nlp, X)

    monkeypatch.setattr(CondensedNlp, "evaluate", evaluate)
    return counts


@pytest.mark.parametrize("encoding", ["durations", "log-durations", "scaled"])
@pytest.mark.parametrize("method", METHODS)
def test_the_budget_is_exact_and_counted_by_the_problem(
    method: str, encoding: str, evaluated: Counter[str]
) -> None:
    result = solve(make_task("cubic", LIMITS["velocity"]), f"{method}[encoding={encoding}]", budget=333)
    assert result.solution.evaluations == result.counts["evaluate"] == evaluated["evaluate"] == 333
    assert result.encoding == encoding


def test_the_scaled_encoding_is_feasible_from_the_first_candidate_on() -> None:
    result = solve(load_case("machines-2024-490"), "random[encoding=scaled]", budget=1)
    assert result.feasible


@pytest.mark.parametrize("method", ["pso", "de", "ssa-debiased"])
def test_the_scaled_encoding_reaches_the_best_known_durations(method: str) -> None:
    found = [
        solve(load_case("machines-2024-490"), f"{method}[encoding=scaled]", seed=seed, budget=3000).duration
        for seed in range(5)
    ]
    assert min(found) > BEST * (1 - 1e-6)
    assert np.median(found) < BEST * 1.001


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "budget", "best", "share", "method"),
    [
        *(("machines-2024-490", 3000, 4.3104, 1e-3, name) for name in ("pso", "de", "cmaes", "ssa-debiased")),
        *(("zou-2024-eight-points", 20_000, 7.302, 5e-3, name) for name in ("pso", "de", "ssa-debiased")),
    ],
)
def test_the_median_of_twenty_seeds_is_near_the_best_known(
    case: str, budget: int, best: float, share: float, method: str
) -> None:
    task = load_case(case)
    results = [solve(task, f"{method}[encoding=scaled]", seed=seed, budget=budget) for seed in range(20)]
    assert all(result.feasible for result in results)
    assert float(np.median([result.duration for result in results])) == pytest.approx(best, rel=share)


@pytest.mark.long
def test_covariance_matrix_adaptation_is_near_the_best_known_of_eight_points() -> None:
    """It takes as long as all the others together."""
    test_the_median_of_twenty_seeds_is_near_the_best_known(
        "zou-2024-eight-points", 20_000, 7.302, 5e-3, "cmaes"
    )


def test_limits_broken_between_samples_are_repaired_by_slowing() -> None:
    """Torque and septic velocities are sampled: the judge slows the answer into its limits, by 2 % at most."""
    limits = {"torque": [60.0, 80.0, 40.0, 10.0, 5.0, 3.0], "velocity": 1.0}
    task = make_task("septic", limits)
    result = solve(task, "de[encoding=scaled,samples=8]", budget=600)
    assert result.feasible
    assert 1.0 < result.scaled_by < 1.02
    assert result.audit is not None
    assert result.audit.worst is not None
    assert result.audit.worst.ratio == pytest.approx(1.0, abs=1e-5)
    assert result.duration == pytest.approx(result.solution.cost * result.scaled_by, rel=1e-9)


def test_torque_is_repaired_too() -> None:
    task = make_task("quintic", {"torque": [60.0, 80.0, 40.0, 10.0, 5.0, 3.0]})
    result = solve(task, "de[encoding=scaled,samples=4]", budget=400)
    assert result.audit is not None
    assert result.audit.worst is not None
    assert result.audit.worst.limit == "torque"
    assert result.feasible
    assert result.scaled_by > 1.0


def test_a_start_by_ipopt_is_counted_and_never_made_worse() -> None:
    task = load_case("machines-2024-490")
    alone = solve(task, "ipopt")
    result = solve(task, "pso[start=ipopt,encoding=scaled]", budget=500)
    assert result.counts["nlp_f"] == alone.counts["nlp_f"]
    assert result.counts["evaluate"] + alone.solution.evaluations == result.solution.evaluations == 500
    assert result.duration <= alone.duration * (1 + 1e-7)


@pytest.mark.parametrize("start", ["guess", "warm"])
def test_a_known_motion_is_in_the_first_population(start: str) -> None:
    task = make_task("quintic", LIMITS["velocity"], search=(0.1, 10.0))
    nlp = CondensedNlp(task, encoding="scaled")
    options: dict[str, Any] = {"warm_start": nlp.decode(nlp.guess)} if start == "warm" else {}
    name = "random[encoding=scaled]" if start == "warm" else "random[encoding=scaled,start=guess]"
    result = solve(task, name, budget=1, **options)
    assert result.solution.cost == pytest.approx(float(nlp.evaluate(nlp.guess).cost[0]), rel=1e-6)


def test_energy_improves_with_the_free_speed_of_the_scaled_encoding() -> None:
    task = make_task("quintic", LIMITS["velocity"], {**OBJECTIVES["energy"], "duration": (0.0, 8.0)})
    scaled, plain = (solve(task, f"pso[encoding={name}]", budget=1000) for name in ("scaled", "durations"))
    assert scaled.feasible
    assert scaled.objective is not None
    assert plain.objective is not None
    assert scaled.objective < plain.objective


def test_the_time_limit_ends_the_search() -> None:
    result = solve(make_task("cubic", LIMITS["velocity"]), "pso", time_limit=0.2)
    assert result.status == "time_exhausted"
