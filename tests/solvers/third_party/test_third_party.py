"""Other people's optimisers solve the same problem within the same budget."""

from __future__ import annotations

import numpy as np
import pytest

from helpers.condensed_tasks import LIMITS, OBJECTIVES, make_task
from metaheuristics import Evaluation, Status
from ocp_traj import load_case
from ocp_traj.exceptions import InputError
from ocp_traj.solvers import Request, parse_solver
from ocp_traj.solvers.population.counting import Archive, BudgetSpent, Counted
from ocp_traj.solvers.third_party.third_party import ThirdParty
from ocp_traj.solving import solve
from ocp_traj.transcription.condensed.condensed import CondensedNlp

SINGLE = {
    "scipy-de": "scipy",
    "scipy-da": "scipy",
    "pymoo-pso": "pymoo",
    "pymoo-ga": "pymoo",
    "pymoo-de": "pymoo",
    "mealpy-ssa": "mealpy",
    "pycma": "cma",
}
REACHED = 4.3104  # the best shared durations of paper B's case


class Spy:
    """Counts the candidates that reach the batched evaluation."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.count = 0
        original = CondensedNlp.evaluate

        def evaluate(nlp: CondensedNlp, X: np.ndarray) -> Evaluation:
            self.count += len(np.atleast_2d(X))
            return original(nlp, X)

        monkeypatch.setattr(CondensedNlp, "evaluate", evaluate)


def test_every_declared_entry_point_is_a_solver(own_entry_points: dict[str, str]) -> None:
    assert set(own_entry_points) == {*SINGLE, "pymoo-nsga2"}


@pytest.mark.parametrize("name", SINGLE)
def test_the_budget_is_never_exceeded_and_the_answer_is_near(
    name: str, own_entry_points: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip(SINGLE[name])
    spy = Spy(monkeypatch)
    result = solve(load_case("machines-2024-490"), f"{name}[encoding=scaled]", budget=701)
    assert result.solution.evaluations == result.counts["evaluate"] == 701
    assert spy.count <= 701 + 2  # besides: the guess that sets the unit of the penalty
    assert result.status == "budget_exhausted"
    assert result.feasible
    assert result.encoding == "scaled"
    assert REACHED * 0.99999 < result.duration < REACHED * 1.03
    history = result.solution.history
    assert (np.diff(history.evaluations) > 0).all()
    assert history.evaluations[-1] == 701
    assert history.cost[-1] == result.solution.cost


@pytest.mark.parametrize("name", SINGLE)
def test_the_same_seed_is_the_same_run(name: str, own_entry_points: dict[str, str]) -> None:
    pytest.importorskip(SINGLE[name])
    task = make_task("cubic", LIMITS["velocity"])
    first, again, other = (solve(task, name, seed=seed, budget=200).solution for seed in (3, 3, 4))
    np.testing.assert_array_equal(first.x, again.x)
    assert not np.array_equal(first.x, other.x)


@pytest.mark.parametrize("name", SINGLE)
def test_a_warm_start_is_used(name: str, own_entry_points: dict[str, str]) -> None:
    pytest.importorskip(SINGLE[name])
    task = load_case("machines-2024-490")
    best = solve(task, "ipopt")
    result = solve(task, f"{name}[encoding=scaled]", budget=60, warm_start=best.trajectory)
    limit = 1.02 if name == "pycma" else 1.0 + 1e-6  # pycma takes a mean, not a candidate
    assert result.duration <= best.duration * limit


def test_the_time_limit_and_the_callback_end_the_run(own_entry_points: dict[str, str]) -> None:
    task = make_task("cubic", LIMITS["velocity"])
    result = solve(task, "scipy-de", budget=10**8, time_limit=0.3)
    assert result.status == "time_exhausted"
    seen = []
    result = solve(
        task, "scipy-da", budget=10_000, progress=lambda progress: seen.append(progress) or len(seen) >= 2
    )
    assert len(seen) == 2
    assert result.solution.evaluations == seen[-1].evaluations < 10_000
    assert "Stopped by the callback" in result.message


class LooksOnce(ThirdParty):
    """Evaluates the middle of the box and ends."""

    def optimise(self, problem: Counted, rng: np.random.Generator, start: object) -> str:
        self.objective(problem)((problem.lower + problem.upper)[None] / 2)
        return "seen enough"


def test_a_library_that_ends_by_itself_says_so() -> None:
    result = solve(make_task("cubic", LIMITS["velocity"], search=(3.0, 3.5)), LooksOnce(), budget=5000)
    assert result.status == "stalled"
    assert "Ended by itself: seen enough" in result.message
    assert result.solution.evaluations == 1
    broken = solve(make_task("cubic", LIMITS["velocity"], search=(0.3, 0.3)), LooksOnce(), budget=5000)
    assert broken.status == "stalled"
    assert "least total violation" in broken.message and "search.duration binds" in broken.message


def test_the_front_of_time_and_energy_holds_no_beaten_motion(own_entry_points: dict[str, str]) -> None:
    pytest.importorskip("pymoo")
    task = make_task("quintic", LIMITS["velocity"], {"time": 1.0, "energy": 0.05})
    solver = parse_solver("pymoo-nsga2[population=40]")
    front = solver.front(task, Request(budget=2000))  # type: ignore[attr-defined]
    assert len(front.durations) > 5
    assert front.evaluations == 2000
    assert (np.diff(front.durations) > 0).all()
    assert (np.diff(front.energies) < 0).all()
    middle = len(front.durations) // 2
    assert front.trajectory(middle).duration == pytest.approx(front.durations[middle])
    energies = CondensedNlp(make_task("quintic", LIMITS["velocity"], {"energy": 1.0})).evaluate(front.x)
    np.testing.assert_allclose(energies.cost, front.energies, rtol=1e-9)
    assert energies.total_violation.max() == 0.0
    result = solve(task, solver, budget=2000)
    assert result.counts == {"evaluate": 2000, "front": len(front.durations)}
    assert result.solution.cost == pytest.approx((front.durations + 0.05 * front.energies).min())
    assert result.feasible


def test_the_front_refuses_other_costs(own_entry_points: dict[str, str]) -> None:
    pytest.importorskip("pymoo")
    with pytest.raises(InputError, match="expected no other weights"):
        solve(make_task(objective=OBJECTIVES["jerk"]), "pymoo-nsga2", budget=200)
    with pytest.raises(InputError, match="decides the speed itself"):
        solve(make_task(objective=OBJECTIVES["energy"]), "pymoo-nsga2[encoding=scaled]", budget=200)
    with pytest.raises(InputError, match="a robot with inertia"):
        solve(load_case("machines-2024-490"), "pymoo-nsga2", budget=200)


def test_a_batch_beyond_the_budget_is_cut() -> None:
    nlp = CondensedNlp(make_task("cubic", LIMITS["velocity"]))
    problem = Counted(nlp, budget=5)
    X = np.random.default_rng(0).uniform(nlp.lower, nlp.upper, (4, nlp.dimension))
    problem.evaluate(X)
    with pytest.raises(BudgetSpent, match="Used the 5 evaluations allowed"):
        problem.evaluate(X)
    assert problem.evaluations == 5
    with pytest.raises(BudgetSpent) as caught:
        problem.evaluate(X)
    assert caught.value.status is Status.BUDGET_EXHAUSTED
    assert problem.evaluations == 5


def test_the_archive_keeps_the_best_distinct_motions() -> None:
    nlp = CondensedNlp(make_task("cubic", LIMITS["velocity"]), encoding="scaled")
    archive = Archive(nlp, 2)
    base = np.zeros(nlp.dimension)
    other = base.copy()
    other[0] = 1.0
    X = np.stack([base, base + 0.3, other, other + np.eye(nlp.dimension)[0] * 0.01])
    archive.add(X, Evaluation(np.array([2.0, 1.0, 4.0, 3.0])))
    assert [entry[1] for entry in archive.entries] == [
        1.0,
        3.0,
    ]  # one of each motion: the total does not matter
    archive.add(X[:1], Evaluation(np.array([0.5]), np.array([[0.1]])))
    assert [entry[1] for entry in archive.entries] == [1.0, 3.0]  # broken limits come last
