import ast
import math
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import metaheuristics
from metaheuristics import (
    DifferentialEvolution,
    Evaluation,
    History,
    Limits,
    ParticleSwarm,
    Problem,
    RandomSearch,
    SparrowSearch,
    Status,
    make_optimizer,
    minimize,
    registry,
)
from metaheuristics.test_problems.standard import Rastrigin, Sphere, draw_rotation

NAMES = sorted(registry)


def make_rng(seed=0):
    return np.random.default_rng(seed)


def make_small(name, **settings):
    return make_optimizer(name, population=12, **settings)


def test_the_first_program_of_the_contract_works():
    problem = Problem.from_function(lambda X: ((X - 1.0) ** 2).sum(axis=1), [-5.0] * 3, [5.0] * 3)
    best = minimize(problem, ParticleSwarm(population=100), budget=20_000, rng=make_rng())
    assert best.x == pytest.approx([1.0] * 3, abs=1e-6)
    assert best.cost < 1e-12
    assert best.evaluations == 20_000
    assert best.history.cost[-1] == best.cost
    assert best.problem is problem
    assert best.feasible


@pytest.mark.parametrize("name", NAMES)
def test_every_optimizer_beats_its_own_start_on_a_shifted_rotated_problem(name):
    rng = make_rng(3)
    problem = Rastrigin(4, half_width=5.12, shift=rng.uniform(-4, 4, 4), rotation=draw_rotation(4, rng))
    best = minimize(problem, make_small(name), budget=1500, rng=rng)
    assert best.cost < 0.7 * best.history.cost[0]
    assert best.evaluations == 1500


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("bounds", ["clip", "reflect", "resample"])
def test_no_optimizer_evaluates_outside_the_box_or_more_than_the_budget(name, bounds):
    lower, upper = np.array([-1.0, 10.0, 3.0]), np.array([1.0, 11.0, 3.0])
    count = 0

    def f(X):
        nonlocal count
        count += X.shape[0]
        assert (lower <= X).all()
        assert (upper >= X).all()
        return -X.sum(axis=1)

    problem = Problem.from_function(f, lower, upper)
    best = minimize(problem, make_small(name, bounds=bounds), budget=307, rng=make_rng())
    assert count == best.evaluations == 307
    assert best.x[2] == 3.0


@pytest.mark.parametrize("name", NAMES)
def test_the_same_seed_gives_the_same_run_whatever_the_batch_size_or_the_workers(name):
    problem = Rastrigin(3, half_width=5.12, shift=[1.0, -2.0, 3.0], rotation=draw_rotation(3, make_rng(9)))
    whole = minimize(problem, make_small(name), budget=400, rng=make_rng(5))
    single = minimize(problem, make_small(name), budget=400, rng=make_rng(5), batch_size=1)
    with ThreadPoolExecutor(2) as pool:
        shared = minimize(
            problem, make_small(name), budget=400, rng=make_rng(5), batch_size=5, map_batches=pool.map
        )
    for other in (single, shared):
        assert (other.history.x == whole.history.x).all()
        assert (other.history.cost == whole.history.cost).all()
        assert (other.history.evaluations == whole.history.evaluations).all()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("broken", [np.nan, np.inf, -np.inf])
@pytest.mark.filterwarnings("error")
def test_broken_values_never_win_and_never_poison_the_search(name, broken):
    def f(X):
        cost = ((X - 0.3) ** 2).sum(axis=1)
        return np.where(X[:, 0] > 0.0, cost, broken)

    problem = Problem.from_function(f, [-1.0] * 3, [1.0] * 3)
    best = minimize(problem, make_small(name), budget=600, rng=make_rng(1))
    assert math.isfinite(best.cost)
    assert best.x[0] > 0.0
    assert np.isfinite(best.history.x).all()
    assert best.cost < 0.3


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.filterwarnings("error")
def test_a_problem_that_always_breaks_ends_as_failed(name):
    problem = Problem.from_function(lambda X: np.full(X.shape[0], np.nan), [-1.0] * 2, [1.0] * 2)
    best = minimize(problem, make_small(name), budget=200, rng=make_rng())
    assert best.status is Status.FAILED
    assert best.message.startswith("No candidate had finite values.")
    assert not best.feasible


def linear_with_a_limit(X):
    return Evaluation(X.sum(axis=1), np.maximum(0.0, 1.0 - X))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    "rule", ["feasible-first", "epsilon", "static-penalty", "adaptive-penalty", "nondominated"]
)
def test_every_optimizer_takes_every_constraint_handling(name, rule):
    problem = Problem.from_function(linear_with_a_limit, [-1.0] * 2, [4.0] * 2)
    best = minimize(problem, make_small(name), budget=1200, rng=make_rng(2), constraint_handling=rule)
    assert best.total_violation <= 0.06
    assert 1.8 < best.cost < 3.5


def test_an_answer_that_breaks_a_constraint_is_infeasible_and_says_by_how_much():
    problem = Problem.from_function(
        lambda X: Evaluation(X[:, 0], np.column_stack((1.0 + X[:, 0], X[:, 0] ** 2))), [0.0], [1.0]
    )
    best = minimize(problem, RandomSearch(population=10), budget=50, rng=make_rng())
    assert best.status is Status.INFEASIBLE
    assert best.message.startswith(f"The least total violation found is {best.total_violation:.3g}.")
    assert best.violation.shape == (2,)
    assert best.violation[0] == 1.0 + best.x[0]


def test_generations_end_a_run_after_the_initial_population():
    problem = Sphere(2, half_width=1.0)
    best = minimize(problem, ParticleSwarm(population=10), generations=7, rng=make_rng())
    assert best.status is Status.BUDGET_EXHAUSTED
    assert best.message == "Ran the 7 generations allowed."
    assert best.history.evaluations.tolist() == list(range(10, 90, 10))


def test_a_target_ends_a_run_at_once():
    problem = Sphere(2, half_width=1.0)
    best = minimize(problem, ParticleSwarm(population=10), budget=5000, target=1e-3, rng=make_rng())
    assert best.status is Status.CONVERGED
    assert best.cost <= 1e-3 < best.history.cost[-2]
    assert best.evaluations < 5000


def test_an_infeasible_candidate_does_not_reach_a_target():
    problem = Problem.from_function(lambda X: Evaluation(-X[:, 0], X), [0.5], [1.0])
    best = minimize(problem, RandomSearch(population=5), budget=20, target=0.0, rng=make_rng())
    assert best.status is Status.INFEASIBLE


def test_a_stalled_run_says_so():
    problem = Problem.from_function(lambda X: np.zeros(X.shape[0]), [0.0], [1.0])
    best = minimize(problem, ParticleSwarm(population=5), stall=4, rng=make_rng())
    assert best.status is Status.STALLED
    assert best.message == "The best did not improve for 4 generations."
    assert len(best.history) == 5


def test_time_ends_a_run(monkeypatch):
    now = [100.0]

    def take_time(X):
        now[0] += 0.007
        return np.zeros(len(X))

    monkeypatch.setattr(time, "perf_counter", lambda: now[0])
    problem = Problem.from_function(take_time, [-1.0] * 2, [1.0] * 2)
    best = minimize(problem, RandomSearch(population=5), seconds=0.02, rng=make_rng())
    assert best.status is Status.TIME_EXHAUSTED
    assert best.message == "Used the 0.02 s allowed."
    assert best.history.seconds == pytest.approx([0.007, 0.014, 0.021])


def test_the_callback_sees_the_run_and_can_stop_it():
    seen = []

    def callback(progress):
        seen.append(progress)
        return progress.generation == 3

    problem = Sphere(2, half_width=1.0)
    best = minimize(problem, ParticleSwarm(population=8), budget=800, rng=make_rng(), callback=callback)
    assert best.status is Status.BUDGET_EXHAUSTED
    assert best.message == "Stopped by the callback in generation 3."
    assert [progress.generation for progress in seen] == [0, 1, 2, 3]
    assert seen[-1].cost == best.cost
    assert (seen[-1].x == best.x).all()
    assert seen[-1].population.shape == (8, 2)
    with pytest.raises(ValueError, match="read-only"):
        seen[-1].population[0] = 0.0
    assert seen[1].spread == pytest.approx(np.mean(seen[1].population.std(axis=0) / 2.0))


def test_a_budget_inside_the_first_population_is_kept():
    best = minimize(Sphere(2, half_width=1.0), ParticleSwarm(population=50), budget=7, rng=make_rng())
    assert best.evaluations == 7
    assert best.history.evaluations.tolist() == [7]


def test_known_candidates_are_in_the_first_population():
    problem = Sphere(2, half_width=1.0)
    seen = []
    minimize(
        Problem.from_function(lambda X: (seen.append(X), problem.evaluate(X))[1], [-1.0] * 2, [1.0] * 2),
        RandomSearch(population=3),
        budget=3,
        rng=make_rng(),
        x0=[[0.5, 0.25], [1.0 + 1e-12, -1.0]],
    )
    assert seen[0][:2].tolist() == [[0.5, 0.25], [1.0, -1.0]]


@pytest.mark.parametrize(
    ("x0", "words"),
    [
        ([0.0, 0.0, 0.0], r"x0 has shape \(3,\), expected \(2,\)"),
        (np.zeros((4, 2)), r"k <= 3"),
        ([0.0, 1.5], r"x0 row 1, variable 2 is 1.5, expected a value in \[-1.0, 1.0\]"),
        ([np.nan, 0.0], "x0 row 1, variable 1 is nan"),
    ],
)
def test_unfitting_known_candidates_are_refused(x0, words):
    with pytest.raises(ValueError, match=words):
        minimize(Sphere(2, half_width=1.0), RandomSearch(population=3), budget=3, rng=make_rng(), x0=x0)


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        ({}, "No limit was given"),
        ({"target": 1.0}, "No limit was given"),
        ({"budget": 0}, "The limit budget is 0, expected more than 0"),
        ({"generations": -1}, "generations is -1"),
        ({"seconds": 0.0}, "seconds is 0.0"),
        ({"budget": 10, "batch_size": 0}, "batch size is 0"),
    ],
)
def test_impossible_limits_are_refused(limits, words):
    with pytest.raises(ValueError, match=words):
        minimize(Sphere(2, half_width=1.0), RandomSearch(), rng=make_rng(), **limits)


def test_infinite_boxes_are_refused_with_the_variable():
    problem = Problem.from_function(lambda X: X[:, 0], [0.0, 0.0], [1.0, np.inf])
    with pytest.raises(ValueError, match=r"Variable 2 has bounds \[0.0, inf\]"):
        minimize(problem, RandomSearch(), budget=10, rng=make_rng())


def test_the_planned_generations_follow_from_the_budget():
    assert Limits(budget=1000).total_generations(100, 110) == 9  # 9 * 110 >= 900
    assert Limits(budget=1000, generations=5).total_generations(100, 110) == 5
    assert Limits(budget=50).total_generations(100, 110) == 1
    assert Limits(seconds=1.0).total_generations(100, 110) == 1000


def test_history_tells_the_generation_of_convergence():
    best = minimize(Sphere(3, half_width=5.0), ParticleSwarm(population=20), budget=2000, rng=make_rng())
    k = best.history.generations_to_within(0.5)
    assert best.history.cost[k] <= 1.5 * best.cost < best.history.cost[k - 1]
    assert best.history.generations_to_within(1e30) == 0
    assert History.empty(3).generations_to_within() == 0


def test_the_best_never_gets_worse_in_the_history():
    problem = Problem.from_function(linear_with_a_limit, [-1.0] * 2, [4.0] * 2)
    for rule in ("static-penalty", "nondominated"):
        run = minimize(
            problem, SparrowSearch(population=10), budget=600, rng=make_rng(), constraint_handling=rule
        )
        pairs = list(zip(run.history.violation.tolist(), run.history.cost.tolist()))
        assert pairs == sorted(pairs, reverse=True)


def test_ask_and_tell_by_hand_is_the_same_run_as_the_loop():
    problem, optimizer = Sphere(3, half_width=5.0), DifferentialEvolution(population=10)
    rng = make_rng(7)
    state = optimizer.start(problem.lower, problem.upper, rng, total_generations=19)
    for _ in range(20):
        X, state = optimizer.ask(state, rng)
        state = optimizer.tell(state, X, problem.evaluate(X))
    best = minimize(problem, optimizer, budget=200, rng=make_rng(7))
    assert state.cost.min() == best.cost
    assert state.generation == 19


def test_asking_twice_from_one_state_gives_the_same_answer():
    optimizer = SparrowSearch(population=10)
    state = optimizer.start([-1.0, -1.0], [1.0, 1.0], make_rng(), total_generations=9)
    first, asked = optimizer.ask(state, make_rng(1))
    state = optimizer.tell(asked, first, Evaluation(first[:, 0]))
    before = state.positions.copy()
    one, _ = optimizer.ask(state, make_rng(2))
    two, _ = optimizer.ask(state, make_rng(2))
    assert (one == two).all()
    assert (state.positions == before).all()


def test_telling_the_wrong_number_of_costs_is_refused():
    optimizer = RandomSearch(population=4)
    state = optimizer.start([0.0], [1.0], make_rng())
    X, state = optimizer.ask(state, make_rng())
    with pytest.raises(ValueError, match="3 costs for 4 candidates"):
        optimizer.tell(state, X, Evaluation(np.zeros(3)))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: ParticleSwarm(population=1), "population of ParticleSwarm is 1, expected at least 2"),
        (lambda: ParticleSwarm(bounds="wrap"), "bound rule is 'wrap'"),
        (lambda: ParticleSwarm(inertia="cubic"), "inertia is 'cubic'"),
        (lambda: ParticleSwarm(wall="stone"), "wall rule is 'stone'"),
        (lambda: ParticleSwarm(velocity_limit=0.0), "velocity limit is 0.0"),
        (lambda: ParticleSwarm.paper("E"), "paper is 'E'"),
        (lambda: SparrowSearch(flight="low"), "flight is 'low'"),
        (lambda: SparrowSearch(producers=1.5), "shares of producers and scouts are 1.5"),
        (lambda: DifferentialEvolution(strategy="worst"), "strategy is 'worst'"),
        (lambda: DifferentialEvolution(crossover=2.0), "crossover is 2.0"),
        (lambda: make_optimizer("gwo"), "optimiser is 'gwo', expected one of pso"),
        (lambda: make_optimizer("pso", colour=1), "'pso' has no setting 'colour'"),
    ],
)
def test_impossible_settings_are_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_the_start_refuses_less_than_one_generation_and_crooked_bounds():
    with pytest.raises(ValueError, match="generations is 0"):
        RandomSearch().start([0.0], [1.0], make_rng(), total_generations=0)
    with pytest.raises(ValueError, match=r"shapes \(1,\) and \(2,\)"):
        RandomSearch().start([0.0], [1.0, 2.0], make_rng())


def test_the_package_imports_numpy_itself_and_the_standard_library_only():
    allowed = {"numpy", "metaheuristics", *sys.stdlib_module_names}
    root = Path(metaheuristics.__file__).parent
    for path in root.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom):
                names = [node.module or ""]
            elif isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            else:
                continue
            for name in names:
                top = name.split(".")[0]
                assert top in allowed, f"{path}: {name}"
