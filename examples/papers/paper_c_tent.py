"""
Paper C: is the Tent map even?
==============================

Paper C starts its sparrow search from a Tent-chaos population, since its numbers fill [0, 1] more evenly than
pseudo-random ones. Counted in ten bins, many times over:
"""

import numpy as np

from metaheuristics.chaos import draw_tent, measure_uniformity

rng = np.random.default_rng(0)
tent = [measure_uniformity(draw_tent(1, 1000, rng)[0])[1] for _ in range(200)]
plain = [measure_uniformity(rng.random(1000))[1] for _ in range(200)]
print(
    f"chi-square over ten bins, median of 200: Tent {np.median(tent):.1f}, pseudo-random {np.median(plain):.1f}"
)

assert np.median(tent) > 0 and np.median(plain) > 0
