"""Speed of judging whole populations; run with ``pytest tests/benchmarks``. Nothing here asserts a time.

The yardstick is what one writes first: a loop over candidates, SciPy's splines, ``pin.rnea`` at every sample.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from scipy.interpolate import make_interp_spline

from ocp_traj import load_case, load_robot
from ocp_traj.codegen.compiled import NO_COMPILER_VARIABLE, find_compiler
from ocp_traj.transcription.condensed.condensed import CondensedNlp

POPULATION = 100
REPEATS = 30


def best_seconds(function: Callable[[], Any], repeats: int = REPEATS) -> float:
    """Processor time of the fastest of several calls: other programs on the machine disturb it least."""
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        function()
        times.append(time.process_time() - begin)
    return min(times)


def population(nlp: CondensedNlp) -> np.ndarray:
    return np.random.default_rng(0).uniform(nlp.lower, nlp.upper, (POPULATION, nlp.dimension))


def straightforward(
    task: Any, model: Any, data: Any, h: np.ndarray, samples: int
) -> tuple[float, np.ndarray]:
    """Energy and the largest violation of each limit of one candidate, one sample at a time."""
    knots = np.concatenate([[0.0], np.cumsum(h)])
    ends = [(order, np.zeros(task.n)) for order in (1, 2, 3)]
    spline = make_interp_spline(knots, task.waypoints, k=7, bc_type=(ends, ends))
    t = (knots[:-1, None] + h[:, None] * np.linspace(0.0, 1.0, samples + 1)).ravel()
    q, v, a, j = (spline(t, nu=order) for order in range(4))
    tau = np.array([pin.rnea(model, data, *row) for row in zip(q, v, a)])
    weights = np.full(samples + 1, 2.0)
    weights[1::2], weights[[0, -1]] = 4.0, 1.0
    power = np.abs(tau * v).sum(axis=1).reshape(len(h), -1)
    energy = float((power @ weights) @ h / (3 * samples))
    worst = []
    for name, value in (("position", q), ("velocity", v), ("acceleration", a), ("jerk", j), ("torque", tau)):
        lower, upper = task.limits.get(name)[0]
        scale = np.maximum(np.abs(lower), np.abs(upper))
        worst.append(np.maximum(np.maximum(value - upper, lower - value) / scale, 0.0).max())
    return energy, np.array(worst)


@pytest.mark.parametrize("kind", ["numpy", "compiled"])
def test_a_population_against_a_loop_over_candidates(
    kind: str, monkeypatch: pytest.MonkeyPatch, record_property: Callable[[str, object], None]
) -> None:
    """UR5, 8 waypoints, septic, energy with all limits, 16 samples a gap."""
    if kind == "compiled" and find_compiler() is None:
        pytest.skip("no C compiler on this machine")
    if kind == "numpy":
        monkeypatch.setenv(NO_COMPILER_VARIABLE, "1")
    task = load_case("ur5-palletizing")
    task = replace(task, robot=replace(load_robot("ur5")))
    nlp = CondensedNlp(task, samples=16)
    X = population(nlp)
    evaluation = nlp.evaluate(X)
    model = task.robot.model
    data = model.createData()
    for k in range(3):
        energy, worst = straightforward(task, model, data, X[k], 16)
        assert evaluation.cost[k] == pytest.approx(energy, rel=1e-8)
        starts = np.cumsum([0, *map(len, nlp.rows)])
        for limit, expected in enumerate(worst):
            ours = evaluation.violation[k, starts[limit] : starts[limit + 1]].max()
            assert ours == pytest.approx(expected, rel=1e-7, abs=1e-8)
    ours = best_seconds(lambda: nlp.evaluate(X)) / POPULATION
    loop = best_seconds(lambda: [straightforward(task, model, data, x, 16) for x in X[:10]], 10) / 10
    report(record_property, {"candidates a second": 1 / ours, "loop over SciPy and rnea, times": loop / ours})


@pytest.mark.parametrize("case", ["machines-2024-490", "zou-2024-eight-points", "ur5-torque-limited"])
@pytest.mark.parametrize("encoding", ["durations", "scaled"])
def test_populations_of_packaged_cases(
    case: str, encoding: str, record_property: Callable[[str, object], None]
) -> None:
    nlp = CondensedNlp(load_case(case), encoding=encoding)
    X = population(nlp)
    assert np.isfinite(nlp.evaluate(X).cost).all()
    report(record_property, {"candidates a second": POPULATION / best_seconds(lambda: nlp.evaluate(X))})


def report(record_property: Callable[[str, object], None], numbers: dict[str, float]) -> None:
    for name, value in numbers.items():
        record_property(name, value)
        print(f"{name}: {value:,.1f}")
