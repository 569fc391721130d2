"""Sparrow search as published, with its ambiguities as named readings, and without its bias on request."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from metaheuristics.arrays import FloatArray, IntArray, freeze
from metaheuristics.evaluation import list_zeros
from metaheuristics.optimizer import INITIAL_PHASE, Frame, Optimizer, State
from metaheuristics.ordering import Ordering

PRODUCERS, SCROUNGERS, SCOUTS = 0, 1, 2
"""Phases of a generation: which group moves next."""

READINGS = {
    "replacement": ("greedy", "always"),
    "alpha": ("scalar", "coordinate"),
    "normal": ("scalar", "coordinate"),
    "beta": ("coordinate", "scalar"),
    "flight": ("literal", "coordinate", "coordinate-undivided"),
    "hungry": ("population", "scroungers"),
}
"""The readings of the ambiguous places of the papers; the first of each, the default, is the author's own program."""

LARGEST_EXPONENT = 700.0
"""exp of more than this overflows; such a move ends on the bound of the box either way."""


@dataclass(frozen=True, eq=False)
class SparrowState(State):
    """A flock between two calls.

    Parameters
    ----------
    leader, leader_cost, leader_violation
        (d,), its cost and violation: X_best, the best position so far.
    rows
        (p,) rows of the population the last candidates belong to, unless the phase alone says so.
    previous_cost
        Cost of the leader when the generation began.
    """

    leader: FloatArray
    leader_cost: float
    leader_violation: float
    rows: IntArray
    previous_cost: float


@dataclass(frozen=True)
class SparrowSearch(Optimizer[SparrowState]):
    """Sparrow search of Xue & Shen 2020 (doi 10.1080/21642583.2019.1708830).

    Every generation the flock is sorted, best first. Producers move and are evaluated, then the scroungers
    (which look at the moved producers), then some scouts drawn at random; all evaluations count. Equations
    (37) to (41) of paper B, (13) to (15) of paper C.

    Known defect, kept on purpose: the producers' and the hungry scroungers' moves pull towards the origin of
    coordinates, and the flight of the others prefers the diagonal, so a problem whose optimum is there looks
    easy. `debiased` moves relative to the flock and the box instead.

    The defaults are one consistent reading, the author's own program: greedy replacement, alpha and Q one number a
    sparrow, beta one a coordinate, the literal flight.

    Parameters
    ----------
    population, bounds
        See `Optimizer`.
    producers, scouts
        Shares of the population (PD and SD).
    safety
        Threshold ST: with R2 ~ U[0, 1) below it producers search nearby, else they leap.
    replacement
        ``"greedy"``: a sparrow moves only if that is better; ``"always"``: as the equations stand.
    alpha, normal, beta
        Whether alpha, Q and beta are one number a sparrow (``"scalar"``) or one per ``"coordinate"``. With a scalar
        beta nothing but the start leaves the diagonal for good, and the flock collapses onto it.
    flight
        |X_i - X_p| A+ L as the ``"literal"`` product (one number for all coordinates), per ``"coordinate"``
        with random signs and divided by d, or ``"coordinate-undivided"``.
    hungry
        n in "i > n/2": the whole ``"population"`` or, as paper C says, the number of ``"scroungers"``.
    smallest
        eps, which keeps the denominator of the best scout's move off zero.
    debiased
        Replace every move that prefers the origin or the diagonal, see `move_producers` and the others.
    leap
        Standard deviation of a debiased producer's leap, relative to the width of the box.
    """

    population: int = 100
    producers: float = 0.2
    scouts: float = 0.1
    safety: float = 0.8
    replacement: str = "greedy"
    alpha: str = "scalar"
    normal: str = "scalar"
    beta: str = "coordinate"
    flight: str = "literal"
    hungry: str = "population"
    smallest: float = 1e-50
    debiased: bool = False
    leap: float = 0.01

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, readings in READINGS.items():
            if getattr(self, name) not in readings:
                raise ValueError(f"{name} is {getattr(self, name)!r}, expected one of {', '.join(readings)}.")
        if not 0.0 < self.producers < 1.0 or not 0.0 <= self.scouts <= 1.0:
            raise ValueError(
                f"The shares of producers and scouts are {self.producers} and {self.scouts}, "
                "expected a producers' share between 0 and 1, and a scouts' from 0 to 1."
            )

    @property
    def minimum_population(self) -> int:
        """One producer, and scroungers of both kinds."""
        return 4

    @cached_property
    def producer_count(self) -> int:
        """Number of producers, at least one and never everybody."""
        return min(max(round(self.producers * self.population), 1), self.population - 1)

    @cached_property
    def flying_count(self) -> int:
        """Number of scroungers that fly: ranks PD + 1 to n/2, with n as `hungry` reads it."""
        n, count = self.population, self.producer_count
        base = n if self.hungry == "population" else n - count
        return min(max(base // 2 - count, 0), n - count)

    @cached_property
    def scout_count(self) -> int:
        """Number of scouts."""
        return round(self.scouts * self.population)

    @property
    def evaluations_per_generation(self) -> int:
        """Everybody once, and the scouts once more."""
        return self.population + self.scout_count

    def make_state(
        self, frame: Frame, ordering: Ordering, positions: FloatArray, rng: np.random.Generator
    ) -> SparrowState:
        """Return the state before the initial population is evaluated; see `Optimizer.make_state`."""
        worst = np.full(positions.shape[0], np.inf)
        return SparrowState(
            frame,
            ordering,
            generation=0,
            phase=INITIAL_PHASE,
            positions=positions,
            cost=worst,
            violation=worst,
            leader=positions[0],
            leader_cost=np.inf,
            leader_violation=np.inf,
            rows=np.arange(positions.shape[0]),
            previous_cost=np.inf,
        )

    def propose(self, state: SparrowState, rng: np.random.Generator) -> tuple[FloatArray, SparrowState]:
        """Move the group whose turn it is; see `Optimizer.propose`."""
        if state.phase == PRODUCERS:
            order = state.ordering.sort(state.cost, state.violation)
            state = state.evolve(
                positions=state.positions.take(order, 0),
                cost=state.cost.take(order),
                violation=state.violation if is_free(state.violation) else state.violation.take(order),
                previous_cost=state.leader_cost,
            )
            return self.move_producers(state, rng), state
        if state.phase == SCROUNGERS:
            return self.move_scroungers(state, rng), state
        count = self.scout_count
        state = state.evolve(rows=rng.random(self.population).argsort()[:count])
        return self.move_scouts(state, rng), state

    def absorb(
        self, state: SparrowState, X: FloatArray, cost: FloatArray, violation: FloatArray
    ) -> SparrowState:
        """Let the group settle and pass the turn; see `Optimizer.absorb`."""
        if state.phase == INITIAL_PHASE:
            return self.settle(state, X, cost, violation, False, phase=PRODUCERS)
        return self.settle(state, X, cost, violation, self.replacement == "greedy", **self.pass_turn(state))

    def pass_turn(self, state: SparrowState) -> dict[str, Any]:
        """Return the phase after this one, and the generation if it ends here."""
        last = SCOUTS if self.scout_count else SCROUNGERS
        if state.phase < last:
            return {"phase": state.phase + 1}
        return {"phase": PRODUCERS, "generation": state.generation + 1}

    def find_rows(self, state: SparrowState) -> slice | IntArray:
        """Return the rows of the population the last candidates belong to."""
        if state.phase == PRODUCERS:
            return slice(0, self.producer_count)
        if state.phase == SCROUNGERS:
            return slice(self.producer_count, self.population)
        return state.rows

    def settle(
        self,
        state: SparrowState,
        X: FloatArray,
        cost: FloatArray,
        violation: FloatArray,
        greedy: bool,
        **changes: Any,
    ) -> SparrowState:
        """Return the state with the candidates (p, d) in the population, only better ones if greedy."""
        rows, ordering = self.find_rows(state), state.ordering
        free = is_free(violation) and is_free(state.violation)
        if greedy:
            present = violation if free else state.violation[rows]
            better = ordering.is_better(cost, violation, state.cost[rows], present).nonzero()[0]
            if not better.shape[0]:
                return state.evolve(**changes)
            X, cost = X.take(better, 0), cost.take(better)
            violation = violation[: better.shape[0]] if free else violation.take(better)
            rows = better + rows.start if isinstance(rows, slice) else rows.take(better)
        changes["positions"] = positions = state.positions.copy()
        changes["cost"] = all_cost = state.cost.copy()
        positions[rows], all_cost[rows] = X, cost
        if not free:
            all_violation = state.violation.copy()
            all_violation[rows] = violation
            # Violations without constraints are recognised from now on.
            changes["violation"] = (
                all_violation if np.count_nonzero(all_violation) else list_zeros(self.population)
            )
        i = ordering.find_best(cost, violation)
        c, excess = cost.item(i), violation.item(i)
        if ordering.beats(c, excess, state.leader_cost, state.leader_violation):
            changes.update(leader=X[i], leader_cost=c, leader_violation=excess)
        return state.evolve(**changes)

    def draw_normal(self, reading: str, p: int, d: int, rng: np.random.Generator) -> FloatArray:
        """Return N(0, 1) numbers, (p, 1) for the reading ``"scalar"``, (p, d) for ``"coordinate"``."""
        return rng.standard_normal((p, 1 if reading == "scalar" else d))

    def draw_others(self, state: SparrowState, p: int, rng: np.random.Generator) -> FloatArray:
        """Return the positions (p, d) of sparrows drawn at random, with replacement."""
        rows = rng.random(p)
        rows *= self.population
        return state.positions.take(rows.astype(np.intp), 0)

    def move_producers(self, state: SparrowState, rng: np.random.Generator) -> FloatArray:
        """Return where the producers (PD, d) go: Eq. (39) of paper B, (13) of paper C.

        R2, drawn once a generation, decides: below ST, X_i exp(-i / (alpha T)); else X_i + Q L. Debiased:
        below ST, X_i + exp(-i / (alpha T)) N(0, 1) |X_i - X_r| per coordinate with a random sparrow r; else
        X_i + leap N(0, 1) (upper - lower) per coordinate.
        """
        x = state.positions[: self.producer_count]
        p, d = x.shape
        if float(rng.random()) >= self.safety:
            if self.debiased:
                return x + (self.leap * state.frame.width) * rng.standard_normal((p, d))
            return x + self.draw_normal(self.normal, p, d, rng)
        alpha = 1.0 - rng.random((p, 1 if self.alpha == "scalar" else d))
        alpha *= -state.frame.total_generations
        shrink = np.divide(list_ranks(0, p), alpha, out=alpha)
        np.exp(shrink, out=shrink)
        if self.debiased:
            step = x - self.draw_others(state, p, rng)
            step *= shrink * rng.standard_normal((p, d))
            step += x
            return step
        return x * shrink

    def move_scroungers(self, state: SparrowState, rng: np.random.Generator) -> FloatArray:
        """Return where the scroungers (n - PD, d) go: Eq. (40) of paper B, (14) of paper C.

        i > n/2: Q exp((X_worst - X_i) / i^2); else X_p + |X_i - X_p| A+ L with A = +-1 at random,
        A+ = A^T (A A^T)^-1 = A^T / d. Debiased: the hungry ones go to X_r + N(0, 1) |X_r - X_i| with a random
        sparrow r, the others fly per coordinate.
        """
        count, near = self.producer_count, self.flying_count
        x = state.positions[count:]
        best = state.ordering.find_best(state.cost[:count], state.violation[:count])
        moved = np.empty_like(x)
        moved[:near] = self.fly(x[:near], state.positions[best], rng)
        moved[near:] = self.leave(state, x[near:], count + near, rng)
        return moved

    def fly(self, x: FloatArray, target: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Return X_p + |X_i - X_p| A+ L for sparrows x (p, d) and target X_p (d,)."""
        d = x.shape[1]
        signs = rng.random(x.shape)
        signs -= 0.5
        signed = x - target
        np.copysign(signed, signs, out=signed)  # |X_i - X_p| A, element by element
        if self.flight == "literal" and not self.debiased:
            step: FloatArray = np.add.reduce(signed, axis=1, keepdims=True)
            step /= d
            return target + step
        if self.flight == "coordinate" and not self.debiased:
            signed /= d
        signed += target
        return signed

    def leave(self, state: SparrowState, x: FloatArray, ahead: int, rng: np.random.Generator) -> FloatArray:
        """Return where the hungry sparrows x (p, d) go, the first of which has rank `ahead` + 1."""
        p, d = x.shape
        if self.debiased:
            other = self.draw_others(state, p, rng)
            beside = x - other
            beside *= rng.standard_normal((p, d))
            beside += other
            return beside
        left: FloatArray = state.positions[-1] - x
        left /= list_squared_ranks(ahead, p)
        if state.frame.largest_width > LARGEST_EXPONENT:
            np.minimum(left, LARGEST_EXPONENT, out=left)
        np.exp(left, out=left)
        left *= self.draw_normal(self.normal, p, d, rng)
        return left

    def move_scouts(self, state: SparrowState, rng: np.random.Generator) -> FloatArray:
        """Return where the scouts (SD, d) go: Eq. (41) of paper B, (15) of paper C.

        f_i > f_best: X_best + beta |X_i - X_best|, beta ~ N(0, 1); f_i = f_best:
        X_i + K |X_i - X_worst| / ((f_i - f_worst) + eps), K ~ U[-1, 1]. Best and worst are the present ones.
        Debiased: beta and K per coordinate, K |X_i - X_worst| without the division.
        """
        x, cost = state.positions.take(state.rows, 0), state.cost.take(state.rows)
        p, d = x.shape
        beta = self.draw_beta(state, p, d, rng)
        factor = self.draw_scout_factor(state, p, d, rng)
        moved: FloatArray = x - state.leader
        np.abs(moved, out=moved)
        moved *= beta
        moved += state.leader
        at_best = cost == state.leader_cost
        if np.count_nonzero(at_best):
            at_best &= state.violation.take(state.rows) == state.leader_violation
            moved[at_best] = self.stir_best(state, x[at_best], cost[at_best], factor[at_best])
        return moved

    def stir_best(
        self, state: SparrowState, x: FloatArray, cost: FloatArray, factor: FloatArray
    ) -> FloatArray:
        """Return where scouts x (p, d) as good as the leader go, with K (p, 1) or (p, d) drawn."""
        worst = state.ordering.sort(state.cost, state.violation)[-1]
        step = factor * np.abs(x - state.positions[worst])
        stirred: FloatArray
        if self.debiased:
            stirred = x + step
            return stirred
        worst_cost = float(state.cost[worst])
        if not np.isfinite(worst_cost):
            return x  # f_i - f_worst is minus infinity, or everything failed: the move vanishes
        stirred = x + step / ((cost - worst_cost) + self.smallest)[:, None]
        return stirred

    def draw_beta(self, state: SparrowState, p: int, d: int, rng: np.random.Generator) -> FloatArray:
        """Return the step factors beta of the scouts, (p, 1) or (p, d)."""
        return self.draw_normal("coordinate" if self.debiased else self.beta, p, d, rng)

    def draw_scout_factor(self, state: SparrowState, p: int, d: int, rng: np.random.Generator) -> FloatArray:
        """Return the step factors K of the scouts, (p, 1), debiased (p, d)."""
        # The same numbers as `rng.uniform`, which takes three times longer for so few.
        factor = rng.random((p, d if self.debiased else 1))
        factor *= 2.0
        factor -= 1.0
        return factor


def is_free(violation: FloatArray) -> bool:
    """Return whether total violations (p,) are the kept zeros of candidates without constraints."""
    return violation is list_zeros(violation.shape[0])


@lru_cache(maxsize=64)
def list_ranks(ahead: int, p: int) -> FloatArray:
    """Return the ranks i = ahead + 1 ... ahead + p as a column (p, 1), read-only and kept."""
    return freeze(np.arange(ahead + 1.0, ahead + p + 1.0)[:, None])


@lru_cache(maxsize=64)
def list_squared_ranks(ahead: int, p: int) -> FloatArray:
    """Return i^2 for the ranks of `list_ranks`, (p, 1), read-only."""
    return freeze(list_ranks(ahead, p) ** 2)
