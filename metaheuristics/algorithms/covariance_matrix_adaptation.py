"""CMA-ES in NumPy: a whole population is sampled, and the distribution adapted, in a few matrix products."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from metaheuristics.arrays import FloatArray, freeze
from metaheuristics.optimizer import INITIAL_PHASE, Frame, Optimizer, State
from metaheuristics.ordering import Ordering

RESAMPLINGS = 10
"""How often candidates outside the box are drawn again before they are brought back into it."""

SMALLEST_STEP = 1e-12
"""Standard deviation, relative to the first one, below which the distribution has converged."""

LARGEST_STEP = 1e4
"""Standard deviation, relative to the width of the box, above which the distribution diverges."""

LARGEST_CONDITION = 1e14
"""Condition number of the covariance matrix above which it has degenerated."""


@dataclass(frozen=True, eq=False)
class CmaState(State):
    """A covariance matrix adaptation between two calls, in the unit box.

    Parameters
    ----------
    mean
        (d,) of the distribution.
    sigma
        Its overall standard deviation.
    covariance
        (d, d) the matrix C.
    basis, spread
        (d, d) eigenvectors in columns and (d,) square roots of eigenvalues of C.
    path, sigma_path
        (d,) evolution paths of C and of sigma.
    age
        Generations of this distribution.
    """

    mean: FloatArray
    sigma: float
    covariance: FloatArray
    basis: FloatArray
    spread: FloatArray
    path: FloatArray
    sigma_path: FloatArray
    age: int


@dataclass(frozen=True)
class Rates:
    """Weights and learning rates for a population and a dimension, Table 1 of Hansen 2016 (arXiv:1604.00772).

    Parameters
    ----------
    weights
        (n,) of the candidates in order, negative for the worse half.
    parents
        Number of positive ones, mu.
    mass
        Variance-effective selection mass, mu_eff.
    sigma_path, damping, path, rank_one, rank_mu
        c_sigma, d_sigma, c_c, c_1 and c_mu.
    length
        Expected length of a standard normal vector.
    """

    weights: FloatArray
    parents: int
    mass: float
    sigma_path: float
    damping: float
    path: float
    rank_one: float
    rank_mu: float
    length: float


@lru_cache(maxsize=64)
def find_rates(n: int, d: int) -> Rates:
    """Return weights and rates of a population of n in d dimensions."""
    raw = math.log((n + 1) / 2) - np.log(np.arange(1.0, n + 1.0))
    parents = n // 2
    mass, opposite = (float(part.sum() ** 2 / (part**2).sum()) for part in (raw[:parents], raw[parents:]))
    rank_one = 2.0 / ((d + 1.3) ** 2 + mass)
    rank_mu = min(1.0 - rank_one - 1e-8, 2.0 * (mass - 2.0 + 1.0 / mass) / ((d + 2.0) ** 2 + mass))
    negative = min(
        1.0 + rank_one / rank_mu,
        1.0 + 2.0 * opposite / (mass + 2.0),
        (1.0 - rank_one - rank_mu) / (d * rank_mu),
    )
    positive_sum, negative_sum = raw[raw > 0].sum(), -raw[raw < 0].sum()
    sigma_path = (mass + 2.0) / (d + mass + 5.0)
    return Rates(
        weights=freeze(np.where(raw >= 0, raw / positive_sum, negative * raw / negative_sum)),
        parents=parents,
        mass=mass,
        sigma_path=sigma_path,
        damping=1.0 + 2.0 * max(0.0, math.sqrt((mass - 1.0) / (d + 1.0)) - 1.0) + sigma_path,
        path=(4.0 + mass / d) / (d + 4.0 + 2.0 * mass / d),
        rank_one=rank_one,
        rank_mu=rank_mu,
        length=math.sqrt(d) * (1.0 - 1.0 / (4.0 * d) + 1.0 / (21.0 * d * d)),
    )


@dataclass(frozen=True)
class CovarianceMatrixAdaptation(Optimizer[CmaState]):
    """CMA-ES (Hansen 2016, arXiv:1604.00772) with negative weights, working in the unit box.

    The first population is uniform in the box, its best becomes the mean. Only the order of candidates
    counts, so every constraint handling works. Candidates outside the box are drawn again a few times, then
    brought back. Where the distribution has converged, diverged or degenerated, it starts again from a random mean.

    Parameters
    ----------
    population, bounds
        See `Optimizer`.
    sigma
        First standard deviation, relative to the width of the box.
    """

    population: int = 16
    sigma: float = 0.3

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.sigma > 0.0:
            raise ValueError(f"sigma is {self.sigma}, expected more than 0.")

    @property
    def minimum_population(self) -> int:
        """Smallest population the weights are defined for."""
        return 4

    def make_state(
        self, frame: Frame, ordering: Ordering, positions: FloatArray, rng: np.random.Generator
    ) -> CmaState:
        """Return the state before the initial population is evaluated; see `Optimizer.make_state`."""
        worst = np.full(positions.shape[0], np.inf)
        return CmaState(
            frame, ordering, 0, INITIAL_PHASE, positions, worst, worst, **self.start_at(np.full(frame.dimension, 0.5))
        )

    def start_at(self, mean: FloatArray) -> dict[str, Any]:
        """Return a fresh distribution around a mean (d,), as fields of the state."""
        d = mean.shape[0]
        identity, zero = np.eye(d), np.zeros(d)
        return {
            "mean": mean,
            "sigma": self.sigma,
            "covariance": identity,
            "basis": identity,
            "spread": np.ones(d),
            "path": zero,
            "sigma_path": zero,
            "age": 0,
        }

    def propose(self, state: CmaState, rng: np.random.Generator) -> tuple[FloatArray, CmaState]:
        """Sample the distribution; see `Optimizer.propose`."""
        if is_finished(state, self.sigma):
            state = state.evolve(**self.start_at(rng.random(state.frame.dimension)))
        root = state.sigma * (state.basis * state.spread).T
        unit = rng.standard_normal((self.population, state.mean.shape[0])) @ root
        unit += state.mean
        for _ in range(RESAMPLINGS):
            outside = ((unit < 0.0) | (unit > 1.0)).any(axis=1).nonzero()[0]
            if not outside.shape[0]:
                break
            unit[outside] = state.mean + rng.standard_normal((outside.shape[0], unit.shape[1])) @ root
        unit *= state.frame.width
        unit += state.frame.lower
        return unit, state

    def absorb(self, state: CmaState, X: FloatArray, cost: FloatArray, violation: FloatArray) -> CmaState:
        """Adapt the distribution; see `Optimizer.absorb`."""
        frame = state.frame
        width = np.where(frame.width > 0.0, frame.width, 1.0)
        unit = np.clip((X - frame.lower) / width, 0.0, 1.0)
        order = state.ordering.sort(cost, violation)
        changes: dict[str, Any] = {"phase": 0, "positions": X, "cost": cost, "violation": violation}
        if state.phase == INITIAL_PHASE:
            return state.evolve(**changes, **self.start_at(unit[order[0]]))
        adapted = adapt(state, unit[order], find_rates(*unit.shape))
        return state.evolve(**changes, **adapted, generation=state.generation + 1)


def adapt(state: CmaState, unit: FloatArray, rates: Rates) -> dict[str, Any]:
    """Return the distribution after candidates (n, d) of the unit box, best first: Eqs. (41) to (47) of Hansen 2016."""
    d, age, whiten = state.mean.shape[0], state.age + 1, state.basis / state.spread
    y = (unit - state.mean) / state.sigma
    step = rates.weights[: rates.parents] @ y[: rates.parents]
    pull = math.sqrt(rates.sigma_path * (2.0 - rates.sigma_path) * rates.mass)
    sigma_path = (1.0 - rates.sigma_path) * state.sigma_path + pull * (state.basis @ (whiten.T @ step))
    length = math.sqrt(sigma_path @ sigma_path)
    sigma = state.sigma * math.exp(rates.sigma_path / rates.damping * (length / rates.length - 1.0))
    expected = math.sqrt(1.0 - (1.0 - rates.sigma_path) ** (2 * (age + 1))) * rates.length
    moving = 1.0 if length < (1.4 + 2.0 / (d + 1.0)) * expected else 0.0
    path = (1.0 - rates.path) * state.path
    path = path + moving * math.sqrt(rates.path * (2.0 - rates.path) * rates.mass) * step
    squared = ((y @ whiten) ** 2).sum(axis=1)
    weights = np.where(rates.weights >= 0.0, rates.weights, rates.weights * d / (squared + 1e-8))
    kept = 1.0 + rates.rank_one * (1.0 - moving) * rates.path * (2.0 - rates.path)
    kept -= rates.rank_one + rates.rank_mu * float(rates.weights.sum())
    covariance = kept * state.covariance + rates.rank_one * np.outer(path, path)
    covariance += rates.rank_mu * ((y.T * weights) @ y)
    covariance = (covariance + covariance.T) / 2.0
    values, basis = np.linalg.eigh(covariance)
    return {
        "mean": state.mean + state.sigma * step,
        "sigma": sigma,
        "covariance": covariance,
        "basis": basis,
        "spread": np.sqrt(np.maximum(values, 1e-16)),
        "path": path,
        "sigma_path": sigma_path,
        "age": age,
    }


def is_finished(state: CmaState, sigma: float) -> bool:
    """Return whether the distribution has converged, diverged or degenerated; `sigma` is the first deviation."""
    deviation = state.sigma * np.sqrt(np.diagonal(state.covariance))
    largest, smallest = float(state.spread.max()), float(state.spread.min())
    return bool(
        (deviation < SMALLEST_STEP * sigma).all()
        or state.sigma * largest > LARGEST_STEP
        or largest > math.sqrt(LARGEST_CONDITION) * smallest
        or (state.mean == state.mean + 0.2 * deviation).any()
    )


__all__ = ["CmaState", "CovarianceMatrixAdaptation", "Rates", "adapt", "find_rates", "is_finished"]
