"""The sparrow search of paper A: elite opposition, Gauss-Cauchy mutation, non-dominated sorting."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from metaheuristics.algorithms.sparrow_search import LARGEST_EXPONENT, PRODUCERS, SparrowSearch, SparrowState
from metaheuristics.algorithms.tent_sparrow_search import find_share
from metaheuristics.arrays import FloatArray
from metaheuristics.optimizer import INITIAL_PHASE
from metaheuristics.ordering import NonDominated, Ordering
from metaheuristics.recorder import find_deviation

OPPOSITION = -2
"""Phase in which the opposite points of the initial population are asked."""

MUTATION = 3
"""Phase in which the mutant of the best is asked; skipped while the best still improves."""


@dataclass(frozen=True)
class EliteSparrowSearch(SparrowSearch):
    """The improved sparrow search of paper A (doi 10.1177/00202940231220080), with its three schemes.

    The printed equations (10) to (12) are lost; these are standard forms.

    1. Elite opposition-based learning of the initial population: the elites are its best half, a_j and b_j
       their least and largest coordinate j; the opposite of x is k (a_j + b_j) - x_j, k ~ U(0, 1) one number
       a sparrow, a coordinate outside the box drawn anew uniformly; the best n of both sets stay.
    2. Gauss-Cauchy mutation of the best sparrow after a generation that changed the best cost by no more than
       `threshold`, relatively: X_best [1 + l1 Cauchy(0, s^2) + l2 N(0, s^2)], l1 = 1 - t^2 / T^2,
       l2 = t^2 / T^2; s = 1 if f_best < f_i, else exp((f_best - f_i) / |f_best|), with i a sparrow drawn at
       random; kept if better.
    3. Non-dominated sorting of (cost, violation): the default constraint handling, `NonDominated`.

    Parameters
    ----------
    threshold
        Relative change of the best cost up to which it is mutated (stand-in 1e-3).
    redraw
        Opposite coordinates outside the box are drawn in the ``"box"`` or between the ``"elites"``.
    mutation
        One Cauchy and one normal number a ``"coordinate"``, or one of each for all (``"scalar"``).

    Notes
    -----
    With ``debiased`` the opposite of x is a_j + b_j - x_j, and the mutation is relative to the standard
    deviation of the flock: neither depends on where the origin of coordinates is.
    """

    threshold: float = 1e-3
    redraw: str = "box"
    mutation: str = "coordinate"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.redraw not in ("box", "elites"):
            raise ValueError(f"redraw is {self.redraw!r}, expected 'box' or 'elites'.")
        if self.mutation not in ("coordinate", "scalar"):
            raise ValueError(f"mutation is {self.mutation!r}, expected 'coordinate' or 'scalar'.")

    @classmethod
    def paper(cls) -> EliteSparrowSearch:
        """Return n = 100 of paper A (it runs T = 50); producers 20 %, scouts 10 %, ST 0.8 are stand-ins."""
        return cls(population=100, producers=0.2, scouts=0.1, safety=0.8)

    @property
    def initial_evaluations(self) -> int:
        """The initial population and its opposites."""
        return 2 * self.population

    @property
    def evaluations_per_generation(self) -> int:
        """As sparrow search, and at most one mutant."""
        return super().evaluations_per_generation + 1

    @property
    def default_ordering(self) -> Ordering:
        """Non-dominated sorting."""
        return NonDominated()

    def propose(self, state: SparrowState, rng: np.random.Generator) -> tuple[FloatArray, SparrowState]:
        """Oppose, mutate or move; see `Optimizer.propose`."""
        if state.phase == OPPOSITION:
            return self.oppose(state, rng), state
        if state.phase == MUTATION:
            row = state.ordering.find_best(state.cost, state.violation)
            state = state.evolve(rows=np.array([row]))
            return self.mutate(state, rng), state
        return super().propose(state, rng)

    def absorb(
        self, state: SparrowState, X: FloatArray, cost: FloatArray, violation: FloatArray
    ) -> SparrowState:
        """Select, keep or settle; see `Optimizer.absorb`."""
        if state.phase == INITIAL_PHASE:
            return self.settle(state, X, cost, violation, False, phase=OPPOSITION)
        if state.phase == OPPOSITION:
            return self.select(state, X, cost, violation)
        finished = {"phase": PRODUCERS, "generation": state.generation + 1}
        if state.phase == MUTATION:
            row = int(state.rows[0])
            present = state.cost.item(row), state.violation.item(row)
            if not state.ordering.beats(cost.item(0), violation.item(0), *present):
                return state.evolve(**finished)
            return self.settle(state, X, cost, violation, False, **finished)
        settled = super().absorb(state, X, cost, violation)
        if settled.phase == PRODUCERS and self.is_stagnant(settled):
            return settled.evolve(phase=MUTATION, generation=state.generation)
        return settled

    def oppose(self, state: SparrowState, rng: np.random.Generator) -> FloatArray:
        """Return the opposite points (n, d) of the initial population: scheme 1 of paper A."""
        order = state.ordering.sort(state.cost, state.violation)
        elites = state.positions[order[: (self.population + 1) // 2]]
        a, b = elites.min(axis=0), elites.max(axis=0)
        k = 1.0 if self.debiased else rng.random((self.population, 1))
        opposite = k * (a + b) - state.positions
        lower, upper = state.frame.lower, state.frame.upper
        low, high = (lower, upper) if self.redraw == "box" else (a, b)
        drawn = low + (high - low) * rng.random(opposite.shape)
        return np.where((lower > opposite) | (upper < opposite), drawn, opposite)

    def select(
        self, state: SparrowState, X: FloatArray, cost: FloatArray, violation: FloatArray
    ) -> SparrowState:
        """Return the state with the best n of the population and its opposites (n, d)."""
        positions = np.concatenate((state.positions, X))
        costs, violations = np.concatenate((state.cost, cost)), np.concatenate((state.violation, violation))
        kept = state.ordering.sort(costs, violations)[: self.population]
        everybody = state.evolve(rows=np.arange(self.population))
        return self.settle(everybody, positions[kept], costs[kept], violations[kept], False, phase=PRODUCERS)

    def is_stagnant(self, state: SparrowState) -> bool:
        """Return whether this generation changed the best cost by no more than the threshold."""
        if not math.isfinite(state.previous_cost):
            return False
        change = abs(state.leader_cost - state.previous_cost)
        return change <= self.threshold * abs(state.previous_cost)

    def mutate(self, state: SparrowState, rng: np.random.Generator) -> FloatArray:
        """Return the mutant (1, d) of the best sparrow: scheme 2 of paper A."""
        best = int(state.rows[0])
        i = int(self.population * rng.random())
        s = find_mutation_scale(float(state.cost[best]), float(state.cost[i]))
        late = find_share(state) ** 2
        x = state.positions[best : best + 1]
        shape = (1, x.shape[1] if self.mutation == "coordinate" else 1)
        jump: FloatArray = (1.0 - late) * s * rng.standard_cauchy(shape)
        jump += late * s * rng.standard_normal(shape)
        return x + (find_deviation(state.positions) if self.debiased else x) * jump


def find_mutation_scale(best_cost: float, other_cost: float) -> float:
    """Return s of the Gauss-Cauchy mutation: 1 if f_best < f_i, else exp((f_best - f_i) / |f_best|).

    The quotient is 0 for a best cost of 0 or an infinite one, and bounded so that exp does not overflow.
    """
    if best_cost < other_cost or best_cost == 0.0 or not math.isfinite(best_cost):
        return 1.0
    return math.exp(min((best_cost - other_cost) / abs(best_cost), LARGEST_EXPONENT))
