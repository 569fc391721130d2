"""Differential evolution, a baseline that is hard to beat."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from metaheuristics.arrays import FloatArray
from metaheuristics.optimizer import INITIAL_PHASE, Optimizer, State


@dataclass(frozen=True)
class DifferentialEvolution(Optimizer[State]):
    """Differential evolution of Storn & Price 1997 (doi 10.1023/A:1008202821328), binomial crossover.

    ``"rand"``: mutant x_a + F (x_b - x_c); ``"best"``: x_best + F (x_b - x_c); ``"current-to-best"``:
    x_i + F (x_best - x_i) + F (x_b - x_c); a, b, c distinct rows other than i.

    Parameters
    ----------
    population, bounds
        See `Optimizer`.
    strategy
        How the mutant is made.
    weight
        F. With `dither` > 0 it is drawn from weight +- dither once a generation.
    crossover
        Probability CR that a coordinate comes from the mutant (one always does).
    dither
        Half width of the range of F.
    """

    strategy: str = "rand"
    weight: float = 0.7
    crossover: float = 0.9
    dither: float = 0.2
    bounds: str = "reflect"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.strategy not in ("rand", "best", "current-to-best"):
            raise ValueError(f"The strategy is {self.strategy!r}, expected rand, best or current-to-best.")
        if not 0.0 <= self.crossover <= 1.0:
            raise ValueError(f"The crossover is {self.crossover}, expected a probability.")

    @property
    def minimum_population(self) -> int:
        """Each candidate needs three others."""
        return 4

    def propose(self, state: State, rng: np.random.Generator) -> tuple[FloatArray, State]:
        """Mutate and cross; see `Optimizer.propose`."""
        x, (n, d) = state.positions, state.positions.shape
        weight = self.weight + self.dither * (2.0 * float(rng.random()) - 1.0)
        # Three distinct others of each row i: the three smallest of n random keys, with that of i taken out.
        keys = rng.random((n, n))
        np.fill_diagonal(keys, 2.0)
        a, b, c = np.argpartition(keys, 2, axis=1)[:, :3].T
        if self.strategy == "rand":
            base = x.take(a, 0)
        else:
            best = x[state.ordering.find_best(state.cost, state.violation)]
            base = np.tile(best, (n, 1)) if self.strategy == "best" else x + weight * (best - x)
        mutant = base + weight * (x.take(b, 0) - x.take(c, 0))
        crossed = rng.random((n, d)) < self.crossover
        crossed[np.arange(n), (d * rng.random(n)).astype(np.intp)] = True
        return np.where(crossed, mutant, x), state

    def absorb(self, state: State, X: FloatArray, cost: FloatArray, violation: FloatArray) -> State:
        """Keep the better of parent and child; see `Optimizer.absorb`."""
        if state.phase == INITIAL_PHASE:
            return state.evolve(phase=0, positions=X, cost=cost, violation=violation)
        # A child as good as its parent replaces it, so that the search can cross plateaus.
        worse = state.ordering.is_better(state.cost, state.violation, cost, violation)
        return state.evolve(
            generation=state.generation + 1,
            positions=np.where(worse[:, None], state.positions, X),
            cost=np.where(worse, state.cost, cost),
            violation=np.where(worse, state.violation, violation),
        )
