"""Against other libraries, where they are installed: same rules, same draws; same problem, same budget."""

import math

import numpy as np
import pytest
from scipy import stats

from metaheuristics import ParticleSwarm, SparrowSearch, make_optimizer, minimize
from metaheuristics.test_problems.standard import Rastrigin, Sphere, make_shifted

SEEDS = range(20)
BUDGET = 10_000
POPULATION = 50


def test_a_swarm_repeats_pyswarms_move_for_move_with_the_same_draws(monkeypatch):
    pyswarms = pytest.importorskip("pyswarms")
    n, d, w, c1, c2 = 15, 4, 0.7298, 1.49618, 1.49618
    problem = Sphere(d, half_width=1000.0, shift=[1.0, -2.0, 3.0, 0.5])
    rng = np.random.default_rng(0)
    start = rng.uniform(-2.0, 2.0, (n, d))
    draws = rng.random((2 * 30, n, d))

    class Replay:
        """Hands the same numbers to both libraries."""

        def __init__(self):
            self.taken = 0

        def take(self, shape):
            self.taken += 1
            return draws[self.taken - 1].reshape(shape).copy()

        def random(self, size=None, out=None):
            numbers = self.take(out.shape if out is not None else size)
            if out is None:
                return numbers
            out[:] = numbers
            return out

    class Silent:
        """No velocities at the start, as in ours; the box is never touched."""

        def __call__(self, size=None, *args, **kwargs):
            return np.zeros(size)

    swarm = pyswarms.single.GlobalBestPSO(
        n_particles=n,
        dimensions=d,
        options={"c1": c1, "c2": c2, "w": w},
        init_pos=start.copy(),
        bh_strategy="nearest",
    )
    swarm.swarm.velocity[:] = 0.0
    replay = Replay()
    monkeypatch.setattr(np.random, "uniform", lambda low, high, size: replay.take(size))
    swarm.optimize(lambda X: problem.evaluate(X).cost, iters=20, verbose=False)
    monkeypatch.undo()

    ours = ParticleSwarm(
        population=n, weight=w, cognitive=c1, social=c2, velocity_limit=math.inf, wall="keep"
    )
    state = ours.start(problem.lower, problem.upper, np.random.default_rng(1), x0=start)
    replay = Replay()
    bests = []
    for _ in range(20):
        X, state = ours.ask(state, replay)
        state = ours.tell(state, X, problem.evaluate(X))
        bests.append(state.best_cost.min())
    assert bests == pytest.approx(swarm.cost_history, rel=1e-9)


def run_pyswarms(problem, seed):
    pyswarms = pytest.importorskip("pyswarms")
    np.random.seed(seed)  # noqa: NPY002 - that library knows no other way
    swarm = pyswarms.single.GlobalBestPSO(
        n_particles=POPULATION,
        dimensions=problem.dimension,
        options={"c1": 1.49618, "c2": 1.49618, "w": 0.7298},
        bounds=(problem.lower, problem.upper),
    )
    iterations = BUDGET // POPULATION
    return swarm.optimize(lambda X: problem.evaluate(X).cost, iters=iterations, verbose=False)[0]


def run_pymoo(problem, seed):
    pytest.importorskip("pymoo")
    from pymoo.algorithms.soo.nonconvex.pso import PSO
    from pymoo.core.problem import Problem as PymooProblem
    from pymoo.optimize import minimize as pymoo_minimize

    class Adapter(PymooProblem):
        def __init__(self):
            super().__init__(n_var=problem.dimension, n_obj=1, xl=problem.lower, xu=problem.upper)

        def _evaluate(self, x, out, *args, **kwargs):
            out["F"] = problem.evaluate(np.asarray(x)).cost[:, None]

    answer = pymoo_minimize(Adapter(), PSO(pop_size=POPULATION), ("n_eval", BUDGET), seed=seed, verbose=False)
    return float(answer.F[0])


@pytest.mark.slow
@pytest.mark.parametrize("kind", [Sphere, Rastrigin])
@pytest.mark.parametrize("run_peer", [run_pyswarms, run_pymoo])
def test_our_swarm_is_not_significantly_worse_than_theirs_on_shifted_problems(kind, run_peer):
    pairs = []
    for seed in SEEDS:
        problem = make_shifted(kind, 10, np.random.default_rng(1000 + seed))
        theirs = run_peer(problem, seed)
        ours = minimize(
            problem, ParticleSwarm(population=POPULATION), budget=BUDGET, rng=np.random.default_rng(seed)
        ).cost
        pairs.append((ours, theirs))
    ours, theirs = np.array(pairs).T
    print(f"{kind.__name__} {run_peer.__name__}: ours {np.median(ours):.3g}, theirs {np.median(theirs):.3g}")
    assert stats.wilcoxon(ours, theirs, alternative="greater").pvalue > 0.05


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pso-constriction", "de", "ssa", "ssa-debiased", "cmaes"])
def test_bbob_runs_through_and_simple_functions_are_solved(name, tmp_path, monkeypatch):
    cocoex = pytest.importorskip("cocoex")
    from metaheuristics import Problem

    monkeypatch.chdir(tmp_path)
    options = "dimensions: 2,5,10 function_indices: 1,3,8,15 instance_indices: 1-3"
    solved = {}
    for peer in cocoex.Suite("bbob", "", options):
        problem = Problem.from_function(
            lambda X, f=peer: np.array([f(x) for x in X]), peer.lower_bounds, peer.upper_bounds
        )
        optimizer = make_optimizer(name, population=40)
        minimize(problem, optimizer, budget=5000 * peer.dimension, rng=np.random.default_rng(peer.index))
        solved[peer.id] = peer.final_target_hit
        peer.free()
    assert len(solved) == 4 * 3 * 3
    spheres = [hit for key, hit in solved.items() if key.startswith("bbob_f001")]
    if name not in ("ssa", "ssa-debiased"):
        assert all(spheres)
    print(name, sum(solved.values()), "of", len(solved))


def test_the_settings_compared_are_the_defaults():
    swarm = ParticleSwarm()
    assert (swarm.weight, swarm.cognitive, swarm.social) == (0.7298, 1.49618, 1.49618)
    assert SparrowSearch().replacement == "greedy"
