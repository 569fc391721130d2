"""Whether Tent chaos fills an interval more evenly than pseudo-random numbers (Zhang et al. 2022, paper C, Fig. 1)."""

from __future__ import annotations

import functools

import numpy as np

from metaheuristics.algorithms.chaos import draw_tent, measure_uniformity
from ocp_traj.arrays import Array
from ocp_traj.papers.measures import claim_order
from ocp_traj.papers.paper import Claim

NUMBERS, BINS = 1000, 10
"""As in the figure."""


def histograms() -> dict[str, tuple[Array, float]]:
    """Return the counts of the bins and their chi-square, by kind of number."""
    rng = np.random.default_rng(0)
    tent = draw_tent(1, NUMBERS, rng)[0]
    return {
        "Tent chaos": measure_uniformity(tent, BINS),
        "pseudo-random": measure_uniformity(rng.random(NUMBERS), BINS),
    }


@functools.cache
def evenness_claim() -> Claim:
    """Judge Fig. 1 over 200 repetitions; the page and the summary ask for it."""
    rng = np.random.default_rng(1)
    tent = np.array([measure_uniformity(draw_tent(1, NUMBERS, rng)[0], BINS)[1] for _ in range(200)])
    plain = np.array([measure_uniformity(rng.random(NUMBERS), BINS)[1] for _ in range(200)])
    return claim_order(
        "Tent chaos fills the bins more evenly than pseudo-random numbers (chi-square, 200 repetitions)",
        "Fig. 1",
        {"Tent chaos": tent, "pseudo-random": plain},
        "",
    )
