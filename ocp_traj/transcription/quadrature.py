"""Quadratures on a segment of unit duration."""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array


def even_intervals(samples: int, per_gap: int) -> int:
    """Return the intervals of a segment for so many samples per gap: an even number of at least 2."""
    return max(2, 2 * round(samples / (2 * per_gap)))


def simpson_weights(intervals: int) -> Array:
    """Return the weights of Simpson's rule at evenly spaced points, (intervals + 1,); `intervals` is even."""
    weights = np.full(intervals + 1, 2.0)
    weights[1::2] = 4.0
    weights[[0, -1]] = 1.0
    return weights / (3 * intervals)


def gauss_legendre(points: int) -> tuple[list[float], Array]:
    """Return nodes in [0, 1] and weights, exact for polynomials of degree 2 points - 1."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    return [float(node) for node in (nodes + 1) / 2], weights / 2
