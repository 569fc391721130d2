"""Particle swarm optimisation, plain and with the trigonometric schedule of paper D."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from metaheuristics.arrays import FloatArray
from metaheuristics.optimizer import INITIAL_PHASE, Frame, Optimizer, State
from metaheuristics.ordering import Ordering

INERTIAS = ("constant", "linear", "trigonometric", "trigonometric-repaired")
WALLS = ("zero", "reverse", "keep")


@dataclass(frozen=True, eq=False)
class SwarmState(State):
    """A swarm between two calls.

    Parameters
    ----------
    velocities
        (n, d) V of the last move.
    best_positions, best_cost, best_violation
        (n, d), (n,), (n,) P, the best of each particle so far.
    leader
        Row of G, the best of all, in `best_positions`.
    """

    velocities: FloatArray
    best_positions: FloatArray
    best_cost: FloatArray
    best_violation: FloatArray
    leader: int


@dataclass(frozen=True)
class ParticleSwarm(Optimizer[SwarmState]):
    """Particle swarm: V <- w V + c1 r1 (P - X) + c2 r2 (G - X); X <- X + V.

    Kennedy & Eberhart 1995 with the inertia w of Shi & Eberhart 1998; r1, r2 ~ U[0,1) per particle and
    coordinate; G is the best of the whole swarm; all particles move at once. The default settings are the
    constriction values of Clerc & Kennedy 2002 (doi 10.1109/4235.985692).

    Parameters
    ----------
    population, bounds
        See `Optimizer`.
    inertia
        ``"constant"``: w = `weight`. ``"linear"``: from `weight_max` to `weight_min` over the run.
        ``"trigonometric"``: Eq. (10) of paper D as printed, with c1, c2 from Eqs. (11) and (12).
        ``"trigonometric-repaired"``: the same with "+ w_min" and with pi inside the first cosine.
    weight, weight_max, weight_min
        w constant, and its ends where it changes.
    cognitive, social
        c1 and c2; unused by the trigonometric schedules, which bring their own.
    velocity_limit
        Largest step per coordinate relative to the width of the box; infinity for none.
    wall
        Velocity of a coordinate that was brought back into the box: ``"zero"``, ``"reverse"`` or ``"keep"``.
    """

    inertia: str = "constant"
    weight: float = 0.7298
    weight_max: float = 0.9
    weight_min: float = 0.4
    cognitive: float = 1.49618
    social: float = 1.49618
    velocity_limit: float = 0.5
    wall: str = "zero"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.inertia not in INERTIAS:
            raise ValueError(f"The inertia is {self.inertia!r}, expected one of {', '.join(INERTIAS)}.")
        if self.wall not in WALLS:
            raise ValueError(f"The wall rule is {self.wall!r}, expected one of {', '.join(WALLS)}.")
        if not self.velocity_limit > 0.0:
            raise ValueError(f"The velocity limit is {self.velocity_limit}, expected more than 0.")

    @classmethod
    def paper(cls, key: str) -> ParticleSwarm:
        """Return the swarm of a paper.

        Parameters
        ----------
        key
            ``"A"``: n = 100, inertia 0.9 to 0.4, c = 2 (the inertia and c are stand-ins).
            ``"B"``: n = 30, inertia 0.9 to 0.4 linear (Section 5), c = 2 (stand-in).
            ``"D"``: w_max 0.9, w_min 0.4 and Eqs. (10) to (12); n = 50 (stand-in).
            ``"D-plain"``: the plain swarm D compares with; n = 50, w = 0.7, c = 2 (all stand-ins).

        Raises
        ------
        ValueError
            If no paper has that key.
        """
        presets = {
            "A": cls(population=100, inertia="linear", cognitive=2.0, social=2.0),
            "B": cls(population=30, inertia="linear", cognitive=2.0, social=2.0),
            "D": cls(population=50, inertia="trigonometric"),
            "D-plain": cls(population=50, weight=0.7, cognitive=2.0, social=2.0),
        }
        if key not in presets:
            raise ValueError(f"The paper is {key!r}, expected one of {', '.join(presets)}.")
        return presets[key]

    def find_factors(self, t: int, total: int, rng: np.random.Generator) -> tuple[float, float, float]:
        """Return w, c1 and c2 of generation t (from 1) of `total`.

        Draws one uniform number where the schedule of paper D asks for it (t > 0.6 T).
        """
        share = min(t / total, 1.0)
        if self.inertia == "constant":
            return self.weight, self.cognitive, self.social
        if self.inertia == "linear":
            return self.weight_max - (self.weight_max - self.weight_min) * share, self.cognitive, self.social
        repaired = self.inertia == "trigonometric-repaired"
        if share <= 0.6:  # Eq. (10) of paper D, first line
            angle = math.pi * share if repaired else share
            w = (self.weight_max - self.weight_min) * math.cos(angle) ** 2 + repaired * self.weight_min
        else:  # Eq. (10), second line
            w = 0.2 + 0.1 * float(rng.random())
        c1 = 2.0 * math.cos(math.pi * share / 3.0) ** 2  # Eq. (11)
        c2 = 2.0 * math.sin(math.pi * share / 1.5) ** 2  # Eq. (12)
        return w, c1, c2

    def make_state(
        self, frame: Frame, ordering: Ordering, positions: FloatArray, rng: np.random.Generator
    ) -> SwarmState:
        """Return the state before the first evaluation, at rest; see `Optimizer.make_state`."""
        worst = np.full(positions.shape[0], np.inf)
        rest = np.zeros_like(positions)
        return SwarmState(
            frame, ordering, 0, INITIAL_PHASE, positions, worst, worst, rest, positions, worst, worst, 0
        )

    def propose(self, state: SwarmState, rng: np.random.Generator) -> tuple[FloatArray, SwarmState]:
        """Move every particle; see `Optimizer.propose`."""
        frame, x = state.frame, state.positions
        w, c1, c2 = self.find_factors(state.generation + 1, frame.total_generations, rng)
        velocities = w * state.velocities
        pull = rng.random(x.shape)
        pull *= c1
        pull *= state.best_positions - x
        velocities += pull
        rng.random(out=pull)
        pull *= c2
        pull *= state.best_positions[state.leader] - x
        velocities += pull
        if math.isfinite(self.velocity_limit):
            limit = self.velocity_limit * (frame.upper_rows - frame.lower_rows)
            np.minimum(velocities, limit, out=velocities)
            np.negative(limit, out=limit)
            np.maximum(velocities, limit, out=velocities)
        return x + velocities, state.evolve(velocities=velocities)

    def absorb(self, state: SwarmState, X: FloatArray, cost: FloatArray, violation: FloatArray) -> SwarmState:
        """Remember the bests; see `Optimizer.absorb`."""
        ordering = state.ordering
        if state.phase == INITIAL_PHASE:
            return state.evolve(
                phase=0,
                positions=X,
                cost=cost,
                violation=violation,
                best_positions=X,
                best_cost=cost,
                best_violation=violation,
                leader=ordering.find_best(cost, violation),
            )
        changes: dict[str, Any] = {"velocities": self._stop_at_walls(state, X)}
        best_cost, best_violation = state.best_cost, state.best_violation
        better = ordering.is_better(cost, violation, state.best_cost, state.best_violation).nonzero()[0]
        if better.shape[0]:
            best_positions = state.best_positions.copy()
            best_cost, best_violation = best_cost.copy(), best_violation.copy()
            best_positions[better] = X.take(better, 0)
            best_cost[better], best_violation[better] = cost.take(better), violation.take(better)
            changes.update(best_positions=best_positions, best_cost=best_cost, best_violation=best_violation)
        # The rule may have changed since the last generation, so the leader is found anew every time.
        changes["leader"] = ordering.find_best(best_cost, best_violation)
        return state.evolve(
            generation=state.generation + 1, positions=X, cost=cost, violation=violation, **changes
        )

    def _stop_at_walls(self, state: SwarmState, X: FloatArray) -> FloatArray:
        """Return the velocities (n, d) after the walls had their say."""
        if self.wall == "keep":
            return state.velocities
        free = state.positions + state.velocities == X
        if self.wall == "zero":
            return state.velocities * free
        return np.where(free, state.velocities, -state.velocities)
