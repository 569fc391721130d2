"""Ways back into the box: no candidate outside it is ever evaluated."""

from __future__ import annotations

import numpy as np

from metaheuristics.arrays import FloatArray

BOUND_RULES = ("clip", "reflect", "resample")


def clip(X: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Put every coordinate that left the box on the bound it crossed (NaN on the lower one).

    Parameters
    ----------
    X
        (p, d) candidates.
    lower, upper
        (d,) the box.

    Returns
    -------
    FloatArray
        (p, d) new array inside the box.
    """
    inside = np.fmax(X, lower)
    np.fmin(inside, upper, out=inside)
    return inside


def reflect(X: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Mirror every coordinate that left the box at its bounds, as often as needed.

    Parameters
    ----------
    X
        (p, d) candidates; one that is not finite lands on a bound as in `clip`.
    lower, upper
        (d,) the box.

    Returns
    -------
    FloatArray
        (p, d) new array inside the box.
    """
    width = upper - lower
    outside = (X < lower) | (X > upper)
    if not outside.any():
        return clip(X, lower, upper)
    period = np.where(width > 0.0, 2.0 * width, 1.0)
    offset = np.where(np.isfinite(X), X, lower) - lower
    folded = width - np.abs(np.mod(offset, period) - width)
    # Coordinates that never left keep their exact bits; infinities go to the bound they point at.
    return clip(np.where(outside & np.isfinite(X), lower + folded, X), lower, upper)


def resample(X: FloatArray, lower: FloatArray, upper: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Draw every coordinate that left the box (or is NaN) anew, uniformly in the box.

    Parameters
    ----------
    X
        (p, d) candidates.
    lower, upper
        (d,) the box.
    rng
        Source of randomness; nothing is drawn when nothing left.

    Returns
    -------
    FloatArray
        (p, d) new array inside the box.
    """
    outside = ~((X >= lower) & (X <= upper))
    if not outside.any():
        return X.copy()
    drawn = lower + (upper - lower) * rng.random(X.shape)
    return clip(np.where(outside, drawn, X), lower, upper)


def repair(
    rule: str, X: FloatArray, lower: FloatArray, upper: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Bring candidates back into the box by the named rule of `BOUND_RULES`.

    Raises
    ------
    ValueError
        If there is no such rule.
    """
    if rule == "clip":
        return clip(X, lower, upper)
    if rule == "reflect":
        return reflect(X, lower, upper)
    if rule == "resample":
        return resample(X, lower, upper, rng)
    raise ValueError(f"The bound rule is {rule!r}, expected one of {', '.join(BOUND_RULES)}.")
