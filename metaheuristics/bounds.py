"""Ways back into the box: no candidate outside it is ever evaluated."""

from __future__ import annotations

import numpy as np

from metaheuristics.arrays import FloatArray, IntArray

BOUND_RULES = ("clip", "reflect", "resample")

NOWHERE: IntArray = np.empty(0, dtype=np.intp)


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
    places = _find_outside(X, lower, upper)
    if places.shape[0]:
        low, high = _pick(lower, places, X.shape), _pick(upper, places, X.shape)
        values = X.take(places)
        finite = np.isfinite(values)
        if np.count_nonzero(finite) < finite.size:
            broken = ~finite
            X.put(places[broken], clip(values[broken], low[broken], high[broken]))
            return reflect(X, lower, upper)
        width = high - low
        period = np.where(width > 0.0, 2.0 * width, 1.0)
        mirrored = low + (width - np.abs(np.mod(values - low, period) - width))
        X.put(places, clip(mirrored, low, high))
    return X


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
    places = _find_outside(X, lower, upper)
    if places.shape[0]:
        low, high = _pick(lower, places, X.shape), _pick(upper, places, X.shape)
        X.put(places, clip(low + (high - low) * rng.random(places.shape[0]), low, high))
    return X


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


def _find_outside(X: FloatArray, lower: FloatArray, upper: FloatArray) -> IntArray:
    """Return the places, counted row by row, of the coordinates (p, d) that left the box or are NaN."""
    inside = lower <= X
    inside &= upper >= X
    if np.count_nonzero(inside) == inside.size:
        return NOWHERE
    np.logical_not(inside, out=inside)
    return inside.reshape(-1).nonzero()[0]


def _pick(bound: FloatArray, places: IntArray, shape: tuple[int, ...]) -> FloatArray:
    """Return the bounds (d,) or (p, d) at the places counted row by row in an array of that shape."""
    full = bound if bound.ndim == len(shape) else np.broadcast_to(bound, shape)
    return full.take(places)
