"""Ways back into the box: no candidate outside it is ever evaluated."""

from __future__ import annotations

import numpy as np

from metaheuristics.arrays import BoolArray, FloatArray

BOUND_RULES = ("clip", "reflect", "resample")


def clip(X: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Put every coordinate that left the box on the bound it crossed (NaN on the lower one), in place.

    Parameters
    ----------
    X
        (p, d) candidates, overwritten.
    lower, upper
        (d,) or (p, d) the box.

    Returns
    -------
    FloatArray
        The same array, inside the box.
    """
    np.fmax(X, lower, out=X)
    np.fmin(X, upper, out=X)
    return X


def reflect(X: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Mirror every coordinate that left the box at its bounds, as often as needed, in place.

    Parameters
    ----------
    X
        (p, d) candidates, overwritten; one that is not finite lands on a bound as in `clip`.
    lower, upper
        (d,) or (p, d) the box.

    Returns
    -------
    FloatArray
        The same array, inside the box.
    """
    outside = (lower > X) | (upper < X)
    if np.count_nonzero(outside):
        outside &= np.isfinite(X)
        low = _pick(lower, outside)
        width = _pick(upper, outside) - low
        period = np.where(width > 0.0, 2.0 * width, 1.0)
        X[outside] = low + (width - np.abs(np.mod(X[outside] - low, period) - width))
    return clip(X, lower, upper)


def resample(X: FloatArray, lower: FloatArray, upper: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Draw every coordinate that left the box (or is NaN) anew, uniformly in the box, in place.

    Parameters
    ----------
    X
        (p, d) candidates, overwritten.
    lower, upper
        (d,) or (p, d) the box.
    rng
        Source of randomness; one number is drawn for each coordinate outside.

    Returns
    -------
    FloatArray
        The same array, inside the box.
    """
    outside = ~((lower <= X) & (upper >= X))
    count = np.count_nonzero(outside)
    if count:
        low = _pick(lower, outside)
        X[outside] = low + (_pick(upper, outside) - low) * rng.random(count)
    return clip(X, lower, upper)


def repair(
    rule: str, X: FloatArray, lower: FloatArray, upper: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Bring candidates back into the box, in place, by the named rule of `BOUND_RULES`.

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


def _pick(bound: FloatArray, outside: BoolArray) -> FloatArray:
    """Return the bounds (d,) or (p, d) of the coordinates marked in (p, d), one a mark."""
    full = bound if bound.ndim == 2 else np.broadcast_to(bound, outside.shape)
    return full[outside]
