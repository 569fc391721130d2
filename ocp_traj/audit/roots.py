"""One root in each of many brackets at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ocp_traj.arrays import Array

_MAX_ITERATIONS = 100


def bracketed_root(
    value_and_slope: Callable[[Array], tuple[Array, Array]], left: Array, right: Array, rising: NDArray[np.bool_]
) -> Array:
    """Find the sign change inside each bracket by Newton steps that fall back to bisection.

    A step is taken when it stays inside the bracket and is at most half the one before, as in `rtsafe` of
    Numerical Recipes, section 9.4.

    Parameters
    ----------
    value_and_slope : callable
        x (R,) -> values (R,), slopes (R,): one function a row.
    left, right : (R,) array
        Ends of the brackets.
    rising : (R,) bool array
        The value at `left` is negative.

    Returns
    -------
    (R,) array, to the last bits of the bracket's scale.
    """
    below, above = np.where(rising, left, right), np.where(rising, right, left)
    x = 0.5 * (left + right)
    last = right - left
    tolerance = 4.0 * np.finfo(np.float64).eps * np.maximum(np.abs(left), np.abs(right))
    for _ in range(_MAX_ITERATIONS):
        value, slope = value_and_slope(x)
        below, above = np.where(value < 0, x, below), np.where(value < 0, above, x)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            newton = x - value / slope
        low, high = np.minimum(below, above), np.maximum(below, above)
        good = (newton >= low) & (newton <= high) & (np.abs(newton - x) <= 0.5 * last)
        following = np.where(good, newton, 0.5 * (low + high))
        last = np.abs(following - x)
        x = following
        if (last <= tolerance).all():
            break
    return x
