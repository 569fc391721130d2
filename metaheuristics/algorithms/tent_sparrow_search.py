"""The sparrow searches of paper C: Tent-map start and adaptive step factors (T-SSA, ADF-SSA, TADF-SSA)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from metaheuristics.algorithms.chaos import draw_tent
from metaheuristics.algorithms.sparrow_search import SparrowSearch, SparrowState
from metaheuristics.arrays import FloatArray
from metaheuristics.optimizer import Frame


@dataclass(frozen=True)
class TentSparrowSearch(SparrowSearch):
    """Sparrow search with a Tent-map start, adaptive step factors for the scouts, or both (paper C).

    The equations (16) to (19) are lost in print; these are standard forms that fit the words.
    beta(t) = beta_min + (beta_max - beta_min) (1 + cos(pi t / T)) / 2;
    K(t) = K_min + (K_max - K_min) sin(pi (t / T)^2) (stand-in: grows early, falls fast late).

    Parameters
    ----------
    tent
        Draw the initial population from the Tent map (T-SSA).
    tent_range
        Orbits are scaled into the ``"box"`` or, in the paper's words, between each sparrow's
        ``"own-extremes"``: the smallest and largest element of the sparrow, drawn uniformly in the box. With
        boxes that differ from one coordinate to the next the result is brought back into the box.
    adaptive
        Use the adaptive factors (ADF-SSA).
    factors
        They ``"replace"`` the random factors of the scouts, or ``"scale"`` them.
    beta_min, beta_max, factor_min, factor_max
        Ends of beta and K (stand-ins 0.2 to 1 and 0 to 1).

    Notes
    -----
    With ``debiased`` a replaced factor gets a random sign per coordinate: one that is never negative moves
    every scout to the same side of the best.
    """

    tent: bool = True
    tent_range: str = "box"
    adaptive: bool = True
    factors: str = "replace"
    beta_min: float = 0.2
    beta_max: float = 1.0
    factor_min: float = 0.0
    factor_max: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.tent_range not in ("box", "own-extremes"):
            raise ValueError(f"tent_range is {self.tent_range!r}, expected 'box' or 'own-extremes'.")
        if self.factors not in ("replace", "scale"):
            raise ValueError(f"factors is {self.factors!r}, expected 'replace' or 'scale'.")

    @classmethod
    def paper(cls, variant: str = "TADF-SSA") -> SparrowSearch:
        """Return one of the four searches of paper C: n = 100, producers 20 %, scouts 10 %, ST = 0.5.

        Parameters
        ----------
        variant
            ``"SSA"``, ``"T-SSA"``, ``"ADF-SSA"`` or ``"TADF-SSA"``; the paper runs 80 generations.

        Raises
        ------
        ValueError
            If the paper has no such variant.
        """
        if variant == "SSA":
            return SparrowSearch(population=100, producers=0.2, scouts=0.1, safety=0.5)
        if variant not in ("T-SSA", "ADF-SSA", "TADF-SSA"):
            raise ValueError(f"The variant is {variant!r}, expected SSA, T-SSA, ADF-SSA or TADF-SSA.")
        return cls(
            population=100,
            producers=0.2,
            scouts=0.1,
            safety=0.5,
            tent=variant.startswith("T"),
            adaptive="ADF" in variant,
        )

    def draw_initial(self, frame: Frame, rng: np.random.Generator) -> FloatArray:
        """Return the initial population (n, d): Eqs. (16) and (17) of paper C, or uniform without `tent`."""
        if not self.tent:
            return super().draw_initial(frame, rng)
        chaos = draw_tent(self.population, frame.dimension, rng)
        if self.tent_range == "box":
            return frame.lower + frame.width * chaos
        uniform = super().draw_initial(frame, rng)
        smallest, largest = uniform.min(axis=1, keepdims=True), uniform.max(axis=1, keepdims=True)
        return np.clip(smallest + (largest - smallest) * chaos, frame.lower, frame.upper)

    def find_beta(self, share: float) -> float:
        """Return beta at t / T = share, Eq. (18) of paper C: cosine annealing."""
        return self.beta_min + (self.beta_max - self.beta_min) * (1.0 + math.cos(math.pi * share)) / 2.0

    def find_scout_factor(self, share: float) -> float:
        """Return K at t / T = share, Eq. (19) of paper C (stand-in): up early, down fast late."""
        return self.factor_min + (self.factor_max - self.factor_min) * math.sin(math.pi * share * share)

    def draw_beta(self, state: SparrowState, p: int, d: int, rng: np.random.Generator) -> FloatArray:
        """Return beta for the scouts; see `SparrowSearch.draw_beta`."""
        if not self.adaptive:
            return super().draw_beta(state, p, d, rng)
        value = self.find_beta(find_share(state))
        if self.factors == "scale":
            return super().draw_beta(state, p, d, rng) * value
        return self._sign(value, p, d, rng)

    def draw_scout_factor(self, state: SparrowState, p: int, d: int, rng: np.random.Generator) -> FloatArray:
        """Return K for the scouts; see `SparrowSearch.draw_scout_factor`."""
        if not self.adaptive:
            return super().draw_scout_factor(state, p, d, rng)
        value = self.find_scout_factor(find_share(state))
        if self.factors == "scale":
            return super().draw_scout_factor(state, p, d, rng) * value
        return self._sign(value, p, d, rng)

    def _sign(self, value: float, p: int, d: int, rng: np.random.Generator) -> FloatArray:
        """Return the factor for everyone (p, 1); debiased (p, d) with random signs."""
        if not self.debiased:
            return np.full((p, 1), value)
        return np.copysign(value, rng.random((p, d)) - 0.5)


def find_share(state: SparrowState) -> float:
    """Return t / T of the generation that is going on (t from 1), at most 1."""
    return min((state.generation + 1) / state.frame.total_generations, 1.0)
