"""Cost of the optimisers themselves, without the problem: population 100, 10 variables, 20 000 evaluations.

Run with ``pytest tests/benchmarks/test_metaheuristics_overhead.py -s``. CPU time, so that other work on the machine
counts as little as possible, and each run beside one of pyswarms, so that a ratio survives what remains; nothing
here asserts a time.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pytest

from metaheuristics import Evaluation, Problem, make_optimizer, minimize, registry

POPULATION, DIMENSION, BUDGET, REPEATS = 100, 10, 20_000, 11
LOWER, UPPER = np.full(DIMENSION, -100.0), np.full(DIMENSION, 100.0)


class TimedSphere(Problem):
    """A shifted sphere that keeps account of its own CPU time."""

    def __init__(self) -> None:
        super().__init__("timed sphere", LOWER, UPPER)
        self.spent = 0.0
        self.evaluations = 0

    def compute(self, X: np.ndarray) -> np.ndarray:
        begin = time.process_time()
        cost = ((X - 7.0) ** 2).sum(axis=1)
        self.spent += time.process_time() - begin
        self.evaluations += X.shape[0]
        return cost

    def evaluate(self, X: np.ndarray) -> Evaluation:
        return Evaluation(self.compute(X))


def measure_overhead(run: Callable[[TimedSphere], object]) -> float:
    """Return the CPU time an evaluation of one run, in microseconds, without the problem's own."""
    problem = TimedSphere()
    begin = time.process_time()
    run(problem)
    return 1e6 * (time.process_time() - begin - problem.spent) / problem.evaluations


def run_pyswarms(problem: TimedSphere) -> None:
    pyswarms = pytest.importorskip("pyswarms")
    swarm = pyswarms.single.GlobalBestPSO(
        n_particles=POPULATION,
        dimensions=DIMENSION,
        options={"c1": 1.49618, "c2": 1.49618, "w": 0.7298},
        bounds=(LOWER, UPPER),
    )
    swarm.optimize(problem.compute, iters=BUDGET // POPULATION, verbose=False)


def report(name: str, run: Callable[[TimedSphere], object]) -> None:
    pairs = np.array([(measure_overhead(run), measure_overhead(run_pyswarms)) for _ in range(REPEATS)])
    least, yardstick = pairs.min(axis=0)
    ratio = np.median(pairs[:, 0] / pairs[:, 1])
    print(f"\n| {name} | {least:.2f} | {yardstick:.2f} | {ratio:.2f} |", end="")
    assert least > 0.0


@pytest.mark.parametrize("name", sorted(registry))
def test_overhead_of_our_optimizers(name: str) -> None:
    optimizer = make_optimizer(name, population=POPULATION)
    report(name, lambda problem: minimize(problem, optimizer, budget=BUDGET, rng=np.random.default_rng(0)))


def test_overhead_of_pymoo() -> None:
    pytest.importorskip("pymoo")
    from pymoo.algorithms.soo.nonconvex.pso import PSO
    from pymoo.core.problem import Problem as PymooProblem
    from pymoo.optimize import minimize as pymoo_minimize

    def run(problem: TimedSphere) -> None:
        class Adapter(PymooProblem):
            def __init__(self) -> None:
                super().__init__(n_var=DIMENSION, n_obj=1, xl=LOWER, xu=UPPER)

            def _evaluate(self, x, out, *args, **kwargs) -> None:  # type: ignore[no-untyped-def]
                out["F"] = problem.compute(x)[:, None]

        pymoo_minimize(Adapter(), PSO(pop_size=POPULATION), ("n_eval", BUDGET), seed=0, verbose=False)

    report("pymoo PSO", run)


def test_overhead_of_mealpy() -> None:
    mealpy = pytest.importorskip("mealpy")

    def run(problem: TimedSphere) -> None:
        statement = {
            "obj_func": lambda x: float(problem.compute(x[None])[0]),
            "bounds": mealpy.FloatVar(lb=LOWER, ub=UPPER),
            "minmax": "min",
            "log_to": None,
        }
        model = mealpy.SSA.OriginalSSA(epoch=BUDGET // POPULATION // 2, pop_size=POPULATION)
        model.solve(statement, seed=0)

    report("mealpy OriginalSSA", run)
