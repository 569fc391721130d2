"""Regular samples of every segment, and Simpson's rule on them."""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array


def even_intervals(samples: int, per_gap: int) -> int:
    """Return the intervals of a segment for so many samples per gap: an even number of at least 2."""
    return max(2, 2 * round(samples / (2 * per_gap)))


def simpson_weights(intervals: int) -> Array:
    """Return the weights of Simpson's rule on a segment of unit duration, (intervals + 1,)."""
    weights = np.full(intervals + 1, 2.0)
    weights[1::2] = 4.0
    weights[[0, -1]] = 1.0
    return weights / (3 * intervals)
