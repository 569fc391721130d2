"""Uniform random search: the honest zero line for every comparison."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from metaheuristics.arrays import FloatArray
from metaheuristics.optimizer import INITIAL_PHASE, Optimizer, State


@dataclass(frozen=True)
class RandomSearch(Optimizer[State]):
    """Independent uniform candidates; `population` is only the size of a batch."""

    @property
    def minimum_population(self) -> int:
        """One candidate is enough."""
        return 1

    def propose(self, state: State, rng: np.random.Generator) -> tuple[FloatArray, State]:
        """Draw the next batch; see `Optimizer.propose`."""
        return self.draw_initial(state.frame, rng), state

    def absorb(self, state: State, X: FloatArray, cost: FloatArray, violation: FloatArray) -> State:
        """Forget the last batch; see `Optimizer.absorb`."""
        generation = 0 if state.phase == INITIAL_PHASE else state.generation + 1
        return state.evolve(generation=generation, phase=0, positions=X, cost=cost, violation=violation)
