"""Uniform random search: the honest zero line for every comparison."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from metaheuristics.arrays import FloatArray
from metaheuristics.optimizer import INITIAL_PHASE, Frame, Optimizer, State
from metaheuristics.ordering import Ordering


@dataclass(frozen=True)
class RandomSearch(Optimizer[State]):
    """Independent uniform candidates; `population` is only the size of a batch."""

    @property
    def minimum_population(self) -> int:
        """One candidate is enough."""
        return 1

    def make_state(
        self, frame: Frame, ordering: Ordering, positions: FloatArray, rng: np.random.Generator
    ) -> State:
        """Return the state before the first batch; see `Optimizer.make_state`."""
        worst = np.full(positions.shape[0], np.inf)
        return State(frame, ordering, 0, INITIAL_PHASE, positions, worst, worst)

    def propose(self, state: State, rng: np.random.Generator) -> tuple[FloatArray, State]:
        """Draw the next batch; see `Optimizer.propose`."""
        return self.draw_initial(state.frame, rng), state

    def absorb(self, state: State, X: FloatArray, cost: FloatArray, violation: FloatArray) -> State:
        """Forget the last batch; see `Optimizer.absorb`."""
        generation = 0 if state.phase == INITIAL_PHASE else state.generation + 1
        return state.evolve(generation=generation, phase=0, positions=X, cost=cost, violation=violation)
