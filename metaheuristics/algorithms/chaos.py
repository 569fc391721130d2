"""Chaotic maps of the papers, as generators of numbers in [0, 1]."""

from __future__ import annotations

import math

import numpy as np

from metaheuristics.arrays import FloatArray


def draw_tent(p: int, count: int, rng: np.random.Generator) -> FloatArray:
    """Return p orbits of the Tent map with the random kick of paper C (Eqs. 16 and 17, standard form).

    x' = 2 x for x < 1/2, else 2 (1 - x), plus delta / N with delta ~ U[0, 1), modulo 1. The kick keeps the
    orbit out of short cycles; without it the map ends at 0 in floating point after some fifty steps.

    Parameters
    ----------
    p
        Number of orbits, each with a uniformly random start.
    count
        Length N of each orbit, the number of elements of a sparrow.
    rng
        Source of the starts and the kicks.

    Returns
    -------
    FloatArray
        (p, count) numbers in [0, 1).
    """
    x = rng.random(p)
    kicks = rng.random((count, p)) / count
    orbits = np.empty((p, count))
    for k in range(count):
        x = np.mod(np.where(x < 0.5, 2.0 * x, 2.0 * (1.0 - x)) + kicks[k], 1.0)
        orbits[:, k] = x
    return orbits


def draw_logistic(count: int, rng: np.random.Generator, mu: float = 4.0) -> FloatArray:
    """Return one orbit of the logistic map x' = mu x (1 - x), Eq. (42) of paper B.

    Parameters
    ----------
    count
        Length of the orbit.
    rng
        Source of the start, uniform in (0, 1).
    mu
        Control parameter; chaotic between about 3.57 and 4.

    Returns
    -------
    FloatArray
        (count,) numbers in [0, 1].
    """
    x = _draw_open(rng)
    orbit = np.empty(count)
    for k in range(count):
        x = mu * x * (1.0 - x)
        orbit[k] = x
    return orbit


def draw_logistic_sine(
    count: int, rng: np.random.Generator, a: float = 0.9, *, squared: bool = False
) -> FloatArray:
    """Return one orbit of the two-dimensional logistic-sine coupling map, Eq. (43) of paper B.

    x' = sin(pi (4 a x (1 - x) + (1 - a) sin(pi y))), y' = sin(pi (4 a y (1 - y) + (1 - a) sin(pi x'))).
    The sine's value may be negative where its argument exceeds pi; then its absolute value is taken, so that
    the orbit stays in [0, 1] (our reading: the print does not say). The numbers crowd near 1.

    Parameters
    ----------
    count
        Numbers wanted; x and y of the orbit alternate (our reading).
    rng
        Source of the start.
    a
        Coupling, between 0 and 1 (stand-in 0.9).
    squared
        Read the stray "2" of the second line as a square on x'.

    Returns
    -------
    FloatArray
        (count,) numbers in [0, 1].
    """
    x, y = _draw_open(rng), _draw_open(rng)
    orbit = np.empty(count + 1)
    for k in range(0, count, 2):
        x, y = step_logistic_sine(x, y, a, squared=squared)
        orbit[k], orbit[k + 1] = x, y
    return orbit[:count]


def step_logistic_sine(x: float, y: float, a: float, *, squared: bool = False) -> tuple[float, float]:
    """Return the next point of the logistic-sine coupling map; see `draw_logistic_sine`."""
    x = abs(math.sin(math.pi * (4.0 * a * x * (1.0 - x) + (1.0 - a) * math.sin(math.pi * y))))
    coupled = x * x if squared else x
    y = abs(math.sin(math.pi * (4.0 * a * y * (1.0 - y) + (1.0 - a) * math.sin(math.pi * coupled))))
    return x, y


def measure_uniformity(numbers: FloatArray, bins: int = 10) -> tuple[FloatArray, float]:
    """Return how evenly numbers fall into equal bins of [0, 1], as in Fig. 1 of paper C.

    Parameters
    ----------
    numbers
        (N,) numbers in [0, 1].
    bins
        Number of bins.

    Returns
    -------
    counts, chi_square
        (bins,) numbers per bin, and sum (count - N/bins)^2 / (N/bins): about bins - 1 for independent uniform
        numbers, more for an uneven, less for a too even sequence.
    """
    counts = np.histogram(numbers, bins=bins, range=(0.0, 1.0))[0].astype(np.float64)
    expected = numbers.shape[0] / bins
    return counts, float(((counts - expected) ** 2).sum() / expected)


def _draw_open(rng: np.random.Generator) -> float:
    """Return a uniform number in (0, 1), ends excluded: 0 is a fixed point of the maps."""
    return float(rng.uniform(1e-6, 1.0 - 1e-6))
