"""One root in each of many brackets at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ocp_traj.arrays import Array

_MAX_ITERATIONS = 100


def bracketed_root(
    value_and_slope: Callable[[Array], tuple[Array, Array]],
    brackets: tuple[Array, Array],
    values: tuple[Array, Array],
    tolerance: float = 4.0 * np.finfo(np.float64).eps,
) -> Array:
    """Find the sign change inside each bracket by Newton steps that fall back to bisection.

    A step is taken when it stays inside the bracket and is at most half the one before, as in `rtsafe` of
    Numerical Recipes, section 9.4; the first guess is the secant's.

    Parameters
    ----------
    value_and_slope : callable
        x (R,) -> values (R,), slopes (R,): one function a row.
    brackets : (R,) array, (R,) array
        Left and right ends.
    values : (R,) array, (R,) array
        Values at the ends; one of them is negative, the other is not.
    tolerance : float
        Last step allowed, as a part of the larger end's magnitude.

    Returns
    -------
    (R,) array
    """
    left, right = brackets
    rising = values[0] < 0
    below, above = np.where(rising, left, right), np.where(rising, right, left)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        x = left - values[0] * (right - left) / (values[1] - values[0])
    x = np.where((x >= left) & (x <= right), x, 0.5 * (left + right))
    last = right - left
    smallest = tolerance * np.maximum(np.abs(left), np.abs(right))
    for _ in range(_MAX_ITERATIONS):
        value, slope = value_and_slope(x)
        below, above = np.where(value < 0, x, below), np.where(value < 0, above, x)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            newton = x - value / slope
        low, high = np.minimum(below, above), np.maximum(below, above)
        good = (newton >= low) & (newton <= high) & (np.abs(newton - x) <= 0.5 * last)
        following = np.where(good, newton, 0.5 * (low + high))
        last = np.where(value == 0, 0.0, np.abs(following - x))
        x = np.where(value == 0, x, following)
        if (last <= smallest).all():
            break
    return x
