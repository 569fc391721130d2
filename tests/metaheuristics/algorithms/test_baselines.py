import itertools
import time

import numpy as np
import pytest

from metaheuristics import (
    DifferentialEvolution,
    Evaluation,
    ParticleSwarm,
    Problem,
    RandomSearch,
    Status,
    minimize,
    minimize_restarting,
)
from metaheuristics.algorithms.covariance_matrix_adaptation import (
    CovarianceMatrixAdaptation,
    adapt,
    find_rates,
    is_finished,
)
from metaheuristics.test_problems.constrained import CLASSICS, ConstrainedProblem
from metaheuristics.test_problems.standard import (
    HALF_WIDTHS,
    Ackley,
    Ellipsoid,
    Griewank,
    Rastrigin,
    Rosenbrock,
    Schwefel12,
    Sphere,
    draw_rotation,
    make_shifted,
)


def make_rng(seed=0):
    return np.random.default_rng(seed)


# Differential evolution


@pytest.mark.parametrize("strategy", ["rand", "best", "current-to-best"])
def test_a_mutant_is_made_of_three_distinct_others(scripted, strategy):
    optimizer = DifferentialEvolution(population=5, strategy=strategy, dither=0.0, crossover=1.0, weight=0.5)
    state = optimizer.start([-100.0] * 2, [100.0] * 2, make_rng())
    x = np.array([[1.0, 0.0], [10.0, 1.0], [20.0, 3.0], [40.0, 7.0], [80.0, 15.0]])
    state = state.evolve(
        phase=0, positions=x, cost=np.array([3.0, 1.0, 2.0, 5.0, 4.0]), violation=np.zeros(5)
    )
    keys = np.tile([0.1, 0.2, 0.3, 0.4, 0.5], (5, 1))
    # Row 3 takes a, b, c = rows 0, 1, 2 in some order; row 0 takes 1, 2, 3.
    X, _ = optimizer.propose(state, scripted(random=[0.5, keys, 0.0, 0.0]))
    base = {"rand": None, "best": x[1], "current-to-best": x[3] + 0.5 * (x[1] - x[3])}[strategy]
    trios = [(a, b, c) for a in range(3) for b in range(3) for c in range(3) if len({a, b, c}) == 3]
    candidates = [(x[a] if base is None else base) + 0.5 * (x[b] - x[c]) for a, b, c in trios]
    assert any(np.allclose(X[3], candidate) for candidate in candidates)


def test_without_crossover_exactly_one_coordinate_changes():
    optimizer = DifferentialEvolution(population=8, crossover=0.0)
    rng = make_rng(1)
    state = optimizer.start([-1.0] * 6, [1.0] * 6, rng)
    X, state = optimizer.ask(state, rng)
    state = optimizer.tell(state, X, Evaluation((X**2).sum(axis=1)))
    Y, _ = optimizer.ask(state, rng)
    assert ((Y != X).sum(axis=1) == 1).all()


def test_parents_survive_worse_children_and_yield_to_equal_ones():
    optimizer = DifferentialEvolution(population=4)
    state = optimizer.start([0.0], [1.0], make_rng()).evolve(
        phase=0, positions=np.zeros((4, 1)), cost=np.ones(4), violation=np.zeros(4)
    )
    told = optimizer.tell(state, np.full((4, 1), 0.5), Evaluation([0.5, 1.0, 1.5, np.nan]))
    assert told.positions[:, 0].tolist() == [0.5, 0.5, 0.0, 0.0]
    assert told.cost.tolist() == [0.5, 1.0, 1.0, 1.0]


def test_differential_evolution_solves_a_rotated_ellipsoid():
    problem = make_shifted(Ellipsoid, 4, make_rng(2), rotated=True)
    best = minimize(problem, DifferentialEvolution(population=30), budget=20_000, rng=make_rng(3))
    assert best.x == pytest.approx(problem.optimum, abs=1e-3)


def test_random_search_is_uniform_and_independent_of_costs():
    seen = []
    problem = Problem.from_function(lambda X: (seen.append(X), X[:, 0])[1], [2.0], [4.0])
    minimize(problem, RandomSearch(population=50), budget=1000, rng=make_rng())
    drawn = np.concatenate(seen)[:, 0]
    assert drawn.mean() == pytest.approx(3.0, abs=0.06)
    assert drawn.var() == pytest.approx(4.0 / 12.0, abs=0.03)


def test_covariance_matrix_adaptation_solves_a_rotated_ellipsoid_to_ten_digits():
    problem = make_shifted(Ellipsoid, 5, make_rng(2), rotated=True)
    optimizer = CovarianceMatrixAdaptation(population=12)
    best = minimize(problem, optimizer, budget=8000, rng=make_rng(3))
    assert best.x == pytest.approx(problem.optimum, abs=1e-8)
    with pytest.raises(ValueError, match="sigma is 0"):
        CovarianceMatrixAdaptation(sigma=0.0)


@pytest.mark.parametrize(("d", "n"), [(1, 6), (5, 12), (8, 40)])
def test_every_adaptation_is_that_of_the_reference_package(d, n):
    """Thirty generations of `cmaes`, told the same candidates."""
    cmaes = pytest.importorskip("cmaes")
    rng = make_rng(4)
    peer = cmaes.CMA(np.full(d, 0.4), 0.3, population_size=n, seed=1)
    optimizer = CovarianceMatrixAdaptation(population=n)
    state = optimizer.start(np.zeros(d), np.ones(d), rng).evolve(**optimizer.start_at(np.full(d, 0.4)))
    for _ in range(30):
        unit = state.mean + state.sigma * rng.standard_normal((n, d)) @ (state.basis * state.spread).T
        cost = ((unit - 0.2) ** 2 @ 10.0 ** np.arange(d)) + 0.1 * np.sin(20 * unit[:, 0])
        peer.tell([(x.copy(), value) for x, value in zip(unit, cost.tolist())])
        state = state.evolve(**adapt(state, unit[np.argsort(cost)], find_rates(n, d)))
        assert state.mean == pytest.approx(peer.mean, rel=1e-9, abs=1e-12)
        assert state.sigma == pytest.approx(peer._sigma, rel=1e-9)
        assert state.covariance == pytest.approx(peer._C, rel=1e-8, abs=1e-11)


def test_candidates_follow_the_distribution_and_stay_in_the_box():
    optimizer, rng = CovarianceMatrixAdaptation(population=4000), make_rng(7)
    lower, upper = np.array([-1.0, 2.0]), np.array([1.0, 12.0])
    covariance = np.array([[1.0, 0.6], [0.6, 0.5]])
    values, basis = np.linalg.eigh(covariance)
    known = {"covariance": covariance, "basis": basis, "spread": np.sqrt(values), "phase": 0}
    state = optimizer.start(lower, upper, rng).evolve(mean=np.array([0.5, 0.4]), sigma=0.05, **known)
    X, _ = optimizer.ask(state, rng)
    unit = (X - lower) / (upper - lower)
    assert unit.mean(axis=0) == pytest.approx([0.5, 0.4], abs=0.004)
    assert np.cov(unit.T) / 0.05**2 == pytest.approx(covariance, abs=0.06)
    X, _ = optimizer.ask(state.evolve(mean=np.zeros(2)), rng)
    assert (lower <= X).all() and (upper >= X).all()
    assert (lower == X).any(axis=1).mean() < 0.02  # drawn again, not put on the walls


@pytest.mark.parametrize(
    "change",
    [{"sigma": 1e-14}, {"sigma": 2e4}, {"spread": np.array([1.0, 1e-8])}, {"sigma": 1e-10, "mean": np.full(2, 1e8)}],
    ids=["converged", "diverged", "degenerated", "without effect"],
)
def test_a_distribution_that_is_finished_starts_again(change):
    optimizer, rng = CovarianceMatrixAdaptation(), make_rng(8)
    state = optimizer.start([0.0, 0.0], [1.0, 1.0], rng).evolve(phase=0, age=9)
    assert not is_finished(state, optimizer.sigma)
    assert optimizer.propose(state, rng)[1].age == 9
    state = state.evolve(**change)
    assert is_finished(state, optimizer.sigma)
    fresh = optimizer.propose(state, rng)[1]
    assert (fresh.age, fresh.sigma) == (0, optimizer.sigma) and (fresh.mean != state.mean).all()


# Restarts


def test_restarts_grow_the_population_and_use_the_whole_budget():
    sizes = []

    def callback(progress):
        if progress.generation == 0:
            sizes.append(progress.population.shape[0])

    problem = make_shifted(Rastrigin, 3, make_rng(5))
    best = minimize_restarting(
        problem, ParticleSwarm(population=8), budget=6000, stall=15, rng=make_rng(6), callback=callback
    )
    assert sizes[:4] == [8, 16, 32, 64][: len(sizes)]
    assert len(sizes) >= 3
    assert best.evaluations == 6000
    assert (np.diff(best.history.evaluations) > 0).all()
    assert (np.diff(best.history.cost) <= 0.0).all()
    assert (np.diff(best.history.seconds) >= 0.0).all()
    assert best.history.cost[-1] == best.cost
    assert (best.history.x[-1] == best.x).all()
    assert f"of {len(sizes)} was best" in best.message


def test_restarts_solve_what_one_search_does_not():
    problem = Rastrigin(5, half_width=5.12, shift=[1.5, -2.2, 3.1, 0.4, -1.0])
    single = minimize(problem, ParticleSwarm(population=10), budget=60_000, rng=make_rng(1))
    several = minimize_restarting(problem, ParticleSwarm(population=10), budget=60_000, rng=make_rng(1))
    assert single.cost > 0.9
    assert several.cost < 1e-9


def test_restarts_stop_at_the_target_the_time_and_the_callback(monkeypatch):
    problem, swarm = Sphere(2, half_width=1.0), ParticleSwarm(population=5)
    hit = minimize_restarting(problem, swarm, budget=10_000, target=1e-3, rng=make_rng())
    assert hit.status is Status.CONVERGED
    assert hit.evaluations < 2000
    ticks = itertools.count()
    monkeypatch.setattr(time, "perf_counter", lambda: 0.001 * next(ticks))
    late = minimize_restarting(problem, swarm, budget=10**9, seconds=0.05, rng=make_rng())
    assert late.status is Status.TIME_EXHAUSTED
    stopped = minimize_restarting(
        problem, swarm, budget=10_000, rng=make_rng(), callback=lambda progress: progress.generation == 2
    )
    assert stopped.evaluations == 15
    with pytest.raises(ValueError, match=r"growth of the population is 0\.5"):
        minimize_restarting(problem, swarm, budget=100, growth=0.5, rng=make_rng())


# Problems


@pytest.mark.parametrize("kind", HALF_WIDTHS)
@pytest.mark.parametrize("rotated", [False, True])
def test_the_classics_are_zero_at_their_shift_and_positive_elsewhere(kind, rotated):
    rng = make_rng(4)
    problem = make_shifted(kind, 6, rng, rotated=rotated)
    assert problem.evaluate(problem.optimum[None]).cost[0] == pytest.approx(0.0, abs=1e-12)
    near = problem.optimum + 0.1 * rng.standard_normal((200, 6))
    assert (problem.evaluate(near).cost > 0.0).all()
    assert (np.abs(problem.optimum) <= 0.8 * HALF_WIDTHS[kind]).all()


def test_the_classics_by_hand():
    x = np.array([[1.0, 2.0]])

    def cost(kind):
        return kind(2, half_width=100.0).evaluate(x).cost[0]

    assert cost(Sphere) == 5.0
    assert cost(Ellipsoid) == pytest.approx(1.0 + 4e6)
    assert cost(Schwefel12) == 1.0 + 9.0
    assert cost(Rosenbrock) == 100.0 * (3.0 - 4.0) ** 2 + 1.0
    assert cost(Rastrigin) == pytest.approx(5.0)
    assert cost(Ackley) == pytest.approx(20.0 - 20.0 * np.exp(-0.2 * np.sqrt(2.5)))
    assert cost(Griewank) == pytest.approx(5.0 / 4000.0 - np.cos(1.0) * np.cos(2.0 / np.sqrt(2.0)) + 1.0)


def test_rotations_are_orthogonal_and_keep_the_sphere():
    rotation = draw_rotation(5, make_rng(1))
    assert rotation @ rotation.T == pytest.approx(np.eye(5), abs=1e-12)
    X = make_rng(2).uniform(-5, 5, (7, 5))
    turned = Sphere(5, half_width=10.0, rotation=rotation)
    assert turned.evaluate(X).cost == pytest.approx((X**2).sum(axis=1))


def test_unfitting_shifts_and_rotations_are_refused():
    with pytest.raises(ValueError, match=r"expected .* inside"):
        Sphere(2, half_width=1.0, shift=[0.0, 2.0])
    with pytest.raises(ValueError, match="rotation has shape"):
        Sphere(2, half_width=1.0, rotation=np.eye(3))


@pytest.mark.parametrize("name", CLASSICS)
def test_the_constrained_classics_have_their_published_optimum(name):
    problem = ConstrainedProblem(name)
    evaluation = problem.evaluate(problem.optimum[None])
    assert evaluation.cost[0] == pytest.approx(problem.best_cost, rel=1e-9)
    assert evaluation.total_violation[0] <= 1e-12
    assert (problem.optimum >= problem.lower).all()
    assert (problem.optimum <= problem.upper).all()


def test_an_unknown_classic_is_refused():
    with pytest.raises(ValueError, match="'g14', expected g01 to g13"):
        ConstrainedProblem("g14")


@pytest.mark.parametrize(
    ("name", "gap"),
    [("g01", 1e-3), ("g04", 1e-6), ("g06", 1e-4), ("g08", 1e-9), ("g09", 1e-4), ("g12", 1e-9)],
)
def test_differential_evolution_solves_the_easier_constrained_classics(name, gap):
    problem = ConstrainedProblem(name)
    best = minimize(problem, DifferentialEvolution(), budget=40_000, rng=make_rng(1))
    assert best.feasible
    assert best.cost == pytest.approx(problem.best_cost, rel=gap)


def test_epsilon_levels_solve_an_equality_that_defeats_feasible_first():
    problem = ConstrainedProblem("g03")
    gaps = {}
    for rule in ("feasible-first", "epsilon"):
        best = minimize(
            problem, DifferentialEvolution(), budget=40_000, rng=make_rng(1), constraint_handling=rule
        )
        assert best.feasible
        gaps[rule] = best.cost - problem.best_cost
    assert gaps["epsilon"] < 0.5 * gaps["feasible-first"]
