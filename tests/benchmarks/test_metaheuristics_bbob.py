"""Runtime distributions on the 24 functions of BBOB in 2, 5 and 10 dimensions (Hansen et al. 2021, COCO).

Run with ``pytest tests/benchmarks/test_metaheuristics_bbob.py -s``. Each run is a share of the 51 targets
f_opt + 10^(2 ... -8) reached within a number of evaluations a dimension. Nothing here asserts a rank.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from metaheuristics import Problem, make_optimizer, minimize

TARGETS = 10.0 ** np.linspace(2.0, -8.0, 51)
INSTANCES = "1"
EFFORTS = (10, 100, 1000)
"""Evaluations a dimension at which the distribution is read; the last is the budget."""

NAMES = (
    "random",
    "pso",
    "pso-constriction",
    "pso-d",
    "de",
    "cmaes",
    "ssa",
    "ssa-debiased",
    "t-ssa",
    "tadf-ssa",
    "issa-a",
    "issa-b",
    "issa-b-debiased",
)


def find_least_value(peer: Any) -> float:
    """Return f_opt; COCO tells the best x only through a file in the working directory."""
    peer._best_parameter("print")
    return float(peer(np.loadtxt("._bbob_problem_best_parameter.txt")))


def measure_shares(name: str, dimension: int) -> list[float]:
    """Return the share of (function, instance, target) triples reached within each effort."""
    cocoex = pytest.importorskip("cocoex")
    optimizer = make_optimizer(name, population=40)
    reached = []
    for peer in cocoex.Suite("bbob", f"instances: {INSTANCES}", f"dimensions: {dimension}"):
        problem = Problem.from_function(
            lambda X, f=peer: np.array([f(x) for x in X]), peer.lower_bounds, peer.upper_bounds, peer.id
        )
        rng = np.random.default_rng(peer.index)
        history = minimize(problem, optimizer, budget=EFFORTS[-1] * dimension, rng=rng).history
        gaps = history.cost - find_least_value(peer)
        for effort in EFFORTS:
            known = gaps[history.evaluations <= effort * dimension]
            reached.append(float((known[-1] <= TARGETS).mean()) if known.size else 0.0)
        peer.free()
    return [float(share) for share in np.array(reached).reshape(-1, len(EFFORTS)).mean(axis=0)]


@pytest.mark.parametrize("name", NAMES)
def test_runtime_distributions(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for dimension in (2, 5, 10):
        shares = measure_shares(name, dimension)
        print(f"\n| {name} | {dimension} | " + " | ".join(f"{share:.2f}" for share in shares) + " |", end="")
        assert all(early <= late for early, late in pairwise(shares))
