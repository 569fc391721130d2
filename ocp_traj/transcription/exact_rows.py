"""Rows that Bernstein coefficients can decide: exact extrema, and positions.

A polynomial stays between its smallest and its largest Bernstein coefficient, so where both are inside the limits
there is nothing to solve and the violation is 0. Closed-form extrema, or samples, are worked out only for the
segments, joints and candidates that may be outside.
"""

from __future__ import annotations

from functools import lru_cache
from math import comb
from typing import Any

import numpy as np

from ocp_traj.arrays import Array, read_only
from ocp_traj.spline.hermite import falling, hermite_matrix
from ocp_traj.transcription.batch import CurveBatch, sample_rows
from ocp_traj.transcription.blocks import Block
from ocp_traj.transcription.extrema import ArrayOperations, extremes

ARRAYS = ArrayOperations()

ROUNDING = 1e-12
"""Share of its scale by which a Bernstein coefficient of a position may be outside: a waypoint on its limit is."""


@lru_cache
def power_rows(degree: int, order: int, terms: int) -> Array:
    """Return the matrix from scaled end states to ascending coefficients of a derivative by tau.

    Only the first `terms` coefficients of the polynomial itself are kept; a cubic held as a quintic has four.
    """
    matrix = hermite_matrix(degree)[order:terms]
    factors = np.array([falling(power, order) for power in range(order, terms)])
    return read_only(matrix * factors[:, None])


@lru_cache
def bernstein_rows(degree: int, order: int) -> Array:
    """Return the matrix from scaled end states to the Bernstein coefficients of a derivative by tau."""
    top = degree - order
    change = np.array([[comb(i, k) / comb(top, k) for k in range(top + 1)] for i in range(top + 1)])
    return read_only(change @ power_rows(degree, order, degree + 1))


def write_exact(curves: CurveBatch, order: int, block: Block, out: Array) -> None:
    """Write by how much the largest and the smallest value are outside, (k, 2, S, p)."""
    hull = _hull(curves, order, block)
    lower, upper = _side(block.lower), _side(block.upper)
    first, last = hull[:, 0], hull[:, -1]
    # Right where the polynomial is monotone, and a start for the others.
    _write_sides(np.maximum(first, last), np.minimum(first, last), lower, upper, out)
    if hull.shape[1] <= 2:
        return
    outside = ((hull.max(axis=1) > upper) | (hull.min(axis=1) < lower)) & ~_is_monotone(hull)
    for entries, largest, smallest in _exact_extremes(curves, order, block, outside):
        k, s, _ = entries
        found = np.empty((1, 2, len(k)))
        _write_sides(largest, smallest, block.lower[k, s], block.upper[k, s], found)
        out[k, :, s, entries[2]] = found[0].T


def _is_monotone(hull: Array) -> Any:
    """Return where the Bernstein coefficients (k, N, S, p), so the polynomial too, only rise or only fall."""
    steps = hull[:, 1:] - hull[:, :-1]
    return (steps.min(axis=1) >= 0.0) | (steps.max(axis=1) <= 0.0)


def largest_ratio(curves: CurveBatch, order: int, block: Block, floor: Array) -> Array:
    """Return the larger of `floor` and the largest value over its bound on its own side, both (p,).

    `floor` is what is known already: extrema that cannot exceed it are not worked out.
    """
    hull = _hull(curves, order, block)
    upper, lower = _inverse(block.upper), _inverse(block.lower)
    ends = hull[:, (0, -1)]
    at_ends = _ratio(ends.max(axis=1), ends.min(axis=1), upper, lower).max(axis=(0, 1))
    floor = np.array(np.maximum(floor, at_ends))
    if hull.shape[1] <= 2:
        return floor
    bound = _ratio(hull.max(axis=1), hull.min(axis=1), upper, lower)
    bound[_is_monotone(hull)] = 0.0
    for entries, largest, smallest in _exact_extremes(curves, order, block, bound > floor):
        k, s, candidates = entries
        ratio = _ratio(largest, smallest, upper[k, s, 0], lower[k, s, 0])
        np.maximum.at(floor, candidates, ratio)
    return floor


def write_positions(curves: CurveBatch, block: Block, out: Array) -> None:
    """Write by how much sampled positions are outside, (k, N, S, p)."""
    hull = _hull(curves, 0, block)
    outside = (hull.max(axis=1) > _side(block.upper + ROUNDING)) | (
        hull.min(axis=1) < _side(block.lower - ROUNDING)
    )
    out[...] = 0.0
    if not outside.any():
        return
    k, s, candidate = np.nonzero(outside)
    states = curves.states[np.asarray(block.joints)[k], :, s, candidate]
    values = sample_rows(curves.degree, 0, block.fractions) @ states.T / block.scale[k, s]
    over = np.maximum(np.maximum(values - block.upper[k, s], block.lower[k, s] - values), 0.0)
    out[k, :, s, candidate] = over.T


def _hull(curves: CurveBatch, order: int, block: Block) -> Array:
    """Return the Bernstein coefficients divided by the block's scale, (k, degree - order + 1, S, p)."""
    hull = curves.combine(bernstein_rows(curves.degree, order), order)
    if len(block.joints) < len(hull):
        hull = hull[block.joints]
    scaled: Array = hull * (1.0 / block.scale)[:, None, :, None]
    return scaled


def _exact_extremes(curves: CurveBatch, order: int, block: Block, wanted: Any) -> list[Any]:
    """Return (entries, largest, smallest) of the wanted (k, S, p), one group a degree, scaled."""
    groups = []
    for degree in sorted(set(curves.degrees)):
        chosen = np.array([own == degree for own in curves.degrees])
        entries = np.nonzero(wanted & chosen[:, None])
        k, s, candidates = entries
        if not len(k):
            continue
        states = curves.states[np.asarray(block.joints)[k], :, s, candidates]
        coefficients = power_rows(curves.degree, order, degree + 1) @ states.T
        coefficients /= curves.h[s, candidates] ** order * block.scale[k, s]
        groups.append((entries, *extremes(list(coefficients), ARRAYS)))
    return groups


def _write_sides(largest: Array, smallest: Array, lower: Array, upper: Array, out: Array) -> None:
    for row, value in enumerate((largest, smallest)):
        out[:, row] = np.maximum(np.maximum(value - upper, lower - value), 0.0)


def _side(bounds: Array) -> Array:
    return bounds[:, :, None]


def _inverse(bounds: Array) -> Array:
    with np.errstate(divide="ignore"):
        return _side(1.0 / bounds)


def _ratio(largest: Array, smallest: Array, upper: Array, lower: Array) -> Array:
    """Return the larger of largest / upper and smallest / lower; 0/0 counts as 0, `upper` and `lower` inverted."""
    with np.errstate(invalid="ignore"):
        ratio = np.maximum(largest * upper, smallest * lower)
    result: Array = np.where(np.isnan(ratio), 0.0, ratio)
    return result
