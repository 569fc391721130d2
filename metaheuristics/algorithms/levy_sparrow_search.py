"""The sparrow search of paper B: logistic-sine start, Levy producers, reverse-learning scouts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from metaheuristics.algorithms.chaos import draw_logistic_sine
from metaheuristics.algorithms.sparrow_search import SCOUTS, SparrowSearch, SparrowState
from metaheuristics.algorithms.tent_sparrow_search import find_share
from metaheuristics.arrays import FloatArray
from metaheuristics.optimizer import Frame

LEVY_EXPONENT = 1.5
"""beta of Eqs. (44) and (45) of paper B."""


def find_levy_scale(exponent: float = LEVY_EXPONENT) -> float:
    """Return sigma_mu of Mantegna's algorithm, Eq. (45) of paper B.

    [Gamma(1 + b) sin(pi b / 2) / (Gamma((1 + b) / 2) b 2^((b - 1) / 2))]^(1 / b); 0.6966 for b = 1.5.
    """
    b = exponent
    numerator = math.gamma(1.0 + b) * math.sin(math.pi * b / 2.0)
    denominator = math.gamma((1.0 + b) / 2.0) * b * 2.0 ** ((b - 1.0) / 2.0)
    return float((numerator / denominator) ** (1.0 / b))


LEVY_SCALE = find_levy_scale()

SMALLEST = float(np.finfo(np.float64).tiny)
"""Keeps the denominator of a Levy step off zero."""


def draw_levy(p: int, d: int, rng: np.random.Generator) -> FloatArray:
    """Return Levy steps (p, d), Eq. (44) of paper B: mu / |nu|^(1/1.5), mu ~ N(0, s^2), nu ~ N(0, 1)."""
    steps: FloatArray = rng.standard_normal((p, d))
    steps *= LEVY_SCALE
    nu = rng.standard_normal((p, d))
    np.abs(nu, out=nu)
    np.maximum(nu, SMALLEST, out=nu)
    steps /= nu ** (1.0 / LEVY_EXPONENT)
    return steps


@dataclass(frozen=True)
class LevySparrowSearch(SparrowSearch):
    """The improved sparrow search of paper B (Ma et al. 2024, doi 10.3390/machines12070490, Eqs. 43 to 50).

    Parameters
    ----------
    coupling
        a of the logistic-sine map (stand-in 0.9).
    map_reading
        ``"plain"``, or ``"squared"``: the stray "2" of Eq. (43) read as a square.
    weight_max, weight_min
        Ends of w = w_max - (w_max - w_min) (t / T)^2, Eq. (46) (stand-ins 0.9 and 0.4).

    Notes
    -----
    With ``debiased`` Levy steps multiply the distance to another sparrow instead of the position, and scouts
    take X_r on either side of the best, X_best + (2 r - 1) (ub - lb), where Eq. (48) always takes it on the
    upper one; the start is uniform, since the map's numbers crowd near 1.
    """

    coupling: float = 0.9
    map_reading: str = "plain"
    weight_max: float = 0.9
    weight_min: float = 0.4

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.map_reading not in ("plain", "squared"):
            raise ValueError(f"map_reading is {self.map_reading!r}, expected 'plain' or 'squared'.")
        if not 0.0 < self.coupling < 1.0:
            raise ValueError(f"The coupling is {self.coupling}, expected more than 0 and less than 1.")

    @classmethod
    def paper(cls) -> LevySparrowSearch:
        """Return the settings of paper B: n = 30, producers 20 %, scouts 10 %, ST = 0.8; it runs T = 1000."""
        return cls(population=30, producers=0.2, scouts=0.1, safety=0.8)

    def draw_initial(self, frame: Frame, rng: np.random.Generator) -> FloatArray:
        """Return the initial population (n, d): Eq. (43) of paper B, coordinates x, y alternately."""
        if self.debiased:
            return super().draw_initial(frame, rng)
        count = self.population * frame.dimension
        orbit = draw_logistic_sine(count, rng, self.coupling, squared=self.map_reading == "squared")
        return frame.lower + frame.width * orbit.reshape(self.population, frame.dimension)

    def find_weight(self, share: float) -> float:
        """Return w at t / T = share, Eq. (46) of paper B."""
        return self.weight_max - (self.weight_max - self.weight_min) * share * share

    def move_producers(self, state: SparrowState, rng: np.random.Generator) -> FloatArray:
        """Return where the producers (PD, d) go, Eq. (47) of paper B.

        X + X Levy (one draw a coordinate) if R2 < ST, else X + Q L w.
        """
        x = state.positions[: self.producer_count]
        p, d = x.shape
        moved: FloatArray
        if float(rng.random()) < self.safety:
            scale = x - self.draw_others(state, p, rng) if self.debiased else x
            moved = draw_levy(p, d, rng)
            moved *= scale
            moved += x
        elif self.debiased:
            weight = self.find_weight(find_share(state))
            moved = x + (self.leap * weight * state.frame.width) * rng.standard_normal((p, d))
        else:
            moved = x + self.draw_normal(self.normal, p, d, rng) * self.find_weight(find_share(state))
        return moved

    def move_scouts(self, state: SparrowState, rng: np.random.Generator) -> FloatArray:
        """Return where the scouts (SD, d) go, Eqs. (48) to (50) of paper B, not Eq. (41).

        X_r = ub + r (lb - X_best), r ~ U(0, 1)^d, debiased X_best + (2 r - 1) (ub - lb);
        X = X_r + b1 (X_best - X_r), b1 = ((T - t) / T)^t.
        """
        frame, best = state.frame, state.leader
        t = state.generation + 1
        b1 = max(1.0 - t / frame.total_generations, 0.0) ** t
        r = rng.random((state.rows.shape[0], frame.dimension))
        reverse: FloatArray
        if self.debiased:
            reverse = best + (2.0 * r - 1.0) * frame.width
        else:
            reverse = frame.upper + r * (frame.lower - best)  # Eq. (48)
        reverse += b1 * (best - reverse)  # Eq. (49)
        return reverse

    def absorb(
        self, state: SparrowState, X: FloatArray, cost: FloatArray, violation: FloatArray
    ) -> SparrowState:
        """Let the group settle; scouts keep the better of old and new under any `replacement`."""
        if state.phase != SCOUTS:
            return super().absorb(state, X, cost, violation)
        return self.settle(state, X, cost, violation, True, **self.pass_turn(state))
