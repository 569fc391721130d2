"""Is a method fair to every place in the box? Structural bias and dependence on where the optimum lies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from metaheuristics.arrays import FloatArray, freeze
from metaheuristics.evaluation import Evaluation
from metaheuristics.minimize import minimize
from metaheuristics.optimizer import Optimizer
from metaheuristics.problem import Problem
from metaheuristics.test_problems.standard import Sphere


@dataclass(frozen=True, eq=False)
class BiasReport:
    """Where the best candidates on a random objective ended.

    Parameters
    ----------
    positions
        (runs, d) final best of each run, scaled to the unit box.
    statistics, p_values
        (d,) Kolmogorov-Smirnov distance from the uniform distribution, and its p-value, for each coordinate.
    diagonal_p_value
        p-value of the largest correlation between two coordinates.
    """

    positions: FloatArray
    statistics: FloatArray
    p_values: FloatArray
    diagonal_p_value: float

    @property
    def p_value(self) -> float:
        """Smallest p-value of all coordinates, corrected for their number (Bonferroni)."""
        return min(float(self.p_values.min()) * len(self.p_values), 1.0)

    def is_biased(self, level: float = 0.01) -> bool:
        """Return whether uniformity is rejected at the level, by a coordinate or by the diagonal."""
        return 2.0 * min(self.p_value, self.diagonal_p_value) < level


class RandomObjective(Problem):
    """A cost that is a uniform random number, whatever the candidate: no place is better than another.

    Parameters
    ----------
    dimension
        Number of variables; the box is [lower, upper] in each.
    rng
        Source of the costs.
    lower, upper
        Ends of the box.
    """

    def __init__(
        self, dimension: int, rng: np.random.Generator, lower: float = 0.0, upper: float = 1.0
    ) -> None:
        super().__init__("random objective", np.full(dimension, lower), np.full(dimension, upper))
        self._rng = rng

    def evaluate(self, X: FloatArray) -> Evaluation:
        """Return random costs; see `Problem.evaluate`."""
        return Evaluation(self._rng.random(X.shape[0]))


def measure_structural_bias(
    optimizer: Optimizer[Any],
    *,
    rng: np.random.Generator,
    runs: int = 200,
    dimension: int = 5,
    budget: int = 3000,
    lower: float = 0.0,
    upper: float = 1.0,
) -> BiasReport:
    """Run a method on a random objective and test whether its final bests are uniform in the box.

    Kononova et al. 2015, doi 10.1016/j.ins.2014.11.035: on an objective without any structure a fair method
    ends anywhere with equal probability; the Kolmogorov-Smirnov test measures the deviation.

    Parameters
    ----------
    optimizer
        The method with its settings.
    rng
        Source of all randomness.
    runs, dimension, budget
        Independent runs, variables, and evaluations a run.
    lower, upper
        The box in every variable. A pull to the origin shows in any box: at a corner of [0, 1], in the middle
        of [-1, 1], at an edge of [10, 11].

    Returns
    -------
    BiasReport
        Final positions and tests.
    """
    finals = np.empty((runs, dimension))
    for run in range(runs):
        problem = RandomObjective(dimension, rng, lower, upper)
        finals[run] = minimize(problem, optimizer, budget=budget, rng=rng).x
    unit = (finals - lower) / (upper - lower)
    statistics = np.array([measure_uniform_distance(column) for column in unit.T])
    p_values = np.array([find_kolmogorov_p_value(value, runs) for value in statistics])
    return BiasReport(freeze(unit), freeze(statistics), freeze(p_values), find_diagonal_p_value(unit))


def measure_uniform_distance(numbers: FloatArray) -> float:
    """Return the Kolmogorov-Smirnov distance of numbers (N,) from the uniform distribution on [0, 1]."""
    n = numbers.shape[0]
    ordered = np.sort(numbers)
    steps = np.arange(1, n + 1) / n
    return float(max((steps - ordered).max(), (ordered - steps + 1.0 / n).max()))


def find_kolmogorov_p_value(distance: float, count: int) -> float:
    """Return the p-value of a Kolmogorov-Smirnov distance.

    The asymptotic series 2 sum (-1)^(k-1) exp(-2 k^2 z^2) with Stephens'
    z = D (sqrt N + 0.12 + 0.11 / sqrt N), good to three digits from N = 20 on.

    Parameters
    ----------
    distance
        D.
    count
        Number of values N.
    """
    root = math.sqrt(count)
    z = distance * (root + 0.12 + 0.11 / root)
    if z < 0.2:
        return 1.0  # the series converges slowly here, its sum is 1 to twelve digits
    terms = (2.0 * (-1.0) ** (k - 1) * math.exp(-2.0 * (k * z) ** 2) for k in range(1, 101))
    return min(max(sum(terms), 0.0), 1.0)


def find_diagonal_p_value(unit: FloatArray) -> float:
    """Return the p-value of the largest correlation between two coordinates of positions (runs, d).

    Fisher's transformation, corrected for the number of pairs; 1 for a single coordinate.
    """
    runs, d = unit.shape
    if d < 2:
        return 1.0
    correlation = np.asarray(np.corrcoef(unit, rowvar=False))[np.triu_indices(d, 1)]
    z = math.sqrt(runs - 3) * math.atanh(min(float(np.abs(correlation).max()), 1.0 - 1e-15))
    pairs = d * (d - 1) // 2
    return float(min(math.erfc(z / math.sqrt(2.0)) * pairs, 1.0))


def measure_shift_dependence(
    optimizer: Optimizer[Any],
    *,
    rng: np.random.Generator,
    runs: int = 20,
    dimension: int = 10,
    budget: int = 20_000,
    half_width: float = 100.0,
) -> dict[str, FloatArray]:
    """Return the final costs on a sphere whose optimum is at the origin, on the diagonal, or anywhere.

    Parameters
    ----------
    optimizer
        The method with its settings.
    rng
        Source of all randomness, the shifts included.
    runs, dimension, budget
        Runs per place, variables, and evaluations a run.
    half_width
        The box is +- this in every variable; shifts are uniform within 0.8 of it.

    Returns
    -------
    dict
        (runs,) final costs for ``"origin"``, ``"equal"`` (one shift for all coordinates) and ``"random"``
        (one a coordinate).
    """
    reach = 0.8 * half_width
    costs: dict[str, FloatArray] = {name: np.empty(runs) for name in ("origin", "equal", "random")}
    for run in range(runs):
        shifts = {
            "origin": np.zeros(dimension),
            "equal": np.full(dimension, rng.uniform(-reach, reach)),
            "random": rng.uniform(-reach, reach, dimension),
        }
        for name, shift in shifts.items():
            problem = Sphere(dimension, half_width=half_width, shift=shift)
            costs[name][run] = minimize(problem, optimizer, budget=budget, rng=rng).cost
    return costs
