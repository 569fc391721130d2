"""Whether Tent chaos fills an interval more evenly than pseudo-random numbers (Zhang et al. 2022, paper C, Fig. 1)."""

from __future__ import annotations

import functools

import numpy as np

from metaheuristics.algorithms.chaos import draw_tent, measure_uniformity
from ocp_traj.arrays import Array
from ocp_traj.papers.measures import claim_unpaired
from ocp_traj.papers.paper import Claim

NUMBERS, BINS = 1000, 10
"""As in the figure."""

REPETITIONS = 3000
"""Of the figure's experiment."""


def histograms() -> dict[str, tuple[Array, float]]:
    """Return the counts of the bins and their chi-square, by kind of number."""
    rng = np.random.default_rng(0)
    tent = draw_tent(1, NUMBERS, rng)[0]
    return {
        "Tent chaos": measure_uniformity(tent, BINS),
        "pseudo-random": measure_uniformity(rng.random(NUMBERS), BINS),
    }


@functools.cache
def evenness() -> dict[str, Array]:
    """Return the chi-square of many independent repetitions, by kind of number."""
    rng = np.random.default_rng(1)
    draws = draw_tent(REPETITIONS, NUMBERS, rng), rng.random((REPETITIONS, NUMBERS))
    tent, plain = (np.array([measure_uniformity(row, BINS)[1] for row in rows]) for rows in draws)
    return {"Tent chaos": tent, "pseudo-random": plain}


@functools.cache
def evenness_claim() -> Claim:
    """Judge Fig. 1 over many repetitions; the page and the summary ask for it."""
    tent, plain = evenness().values()
    return claim_unpaired(
        "Tent chaos fills the bins more evenly than pseudo-random numbers (chi-square)",
        "Fig. 1",
        ("Tent chaos", tent),
        ("pseudo-random", plain),
    )
