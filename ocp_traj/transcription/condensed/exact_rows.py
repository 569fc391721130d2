"""Rows with closed-form extrema, and positions.

A polynomial stays between its smallest and its largest Bernstein coefficient. Where finding extrema is dear (the
quartic velocity of a quintic), they are worked out only for the segments, joints and candidates whose coefficients
are outside the limits; positions are sampled only there.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.transcription.condensed.batch import CurveBatch, bernstein_change, hull, sample_rows
from ocp_traj.transcription.condensed.extrema import ArrayOperations, extremes
from ocp_traj.transcription.condensed.limit_rows import LimitRows

ARRAYS = ArrayOperations()

ROUNDING = 1e-12
"""Share of its scale by which a Bernstein coefficient of a position may be outside: a waypoint on its limit is."""

CHEAP = 3
"""Highest degree whose extrema cost less than the question whether they are needed."""


def write_exact(curves: CurveBatch, order: int, block: LimitRows, out: Array) -> None:
    """Write by how much the largest and the smallest value are outside, (k, 2, S, p)."""
    # A waypoint on a limit of position is inside.
    slack = 0.0 if order else ROUNDING
    lower, upper = (
        side[:, None, :, None] for side in (block.lower - slack, block.upper + slack)
    )

    def outside(largest: Array, smallest: Array) -> Any:
        return (largest > upper[:, 0]) | (smallest < lower[:, 0])

    _write_extremes(curves, order, block, outside, out)
    below = lower - out
    out -= upper
    np.maximum(out, below, out=out)
    np.maximum(out, 0.0, out=out)


def largest_ratio(curves: CurveBatch, order: int, block: LimitRows, floor: Array) -> Array:
    """Return the larger of `floor` and the largest value over its bound on its own side, both (p,).

    `floor` is what is known already: extrema that cannot exceed it are not worked out.
    """
    with np.errstate(divide="ignore"):
        lower, upper = (1.0 / side[:, :, None] for side in (block.lower, block.upper))

    def exceeding(largest: Array, smallest: Array) -> Any:
        return _ratio(largest, smallest, upper, lower) > floor

    values = np.empty((*lower.shape[:1], 2, *curves.h.shape))
    _write_extremes(curves, order, block, exceeding, values)
    ratio = _ratio(values[:, 0], values[:, 1], upper, lower).max(axis=(0, 1))
    return np.maximum(floor, ratio)


def write_positions(curves: CurveBatch, block: LimitRows, out: Array) -> None:
    """Write by how much sampled positions are outside, (k, N, S, p)."""
    coefficients = hull(curves)
    if len(block.joints) < len(coefficients):
        coefficients = coefficients[block.joints]
    highest, lowest = (
        (side * block.scale)[:, :, None] for side in (block.upper + ROUNDING, block.lower - ROUNDING)
    )
    outside = (coefficients.max(axis=1) > highest) | (coefficients.min(axis=1) < lowest)
    out[...] = 0.0
    k, s, candidate = np.nonzero(outside)
    if not len(k):
        return
    states = curves.states[np.asarray(block.joints)[k], :, s, candidate]
    values = sample_rows(curves.degree, 0, block.fractions) @ states.T / block.scale[k, s]
    over = np.maximum(np.maximum(values - block.upper[k, s], block.lower[k, s] - values), 0.0)
    out[k, :, s, candidate] = over.T


def _write_extremes(
    curves: CurveBatch, order: int, block: LimitRows, decide: Callable[[Array, Array], Any], out: Array
) -> None:
    """Write the largest and the smallest scaled value, (k, 2, S, p).

    `decide` says from upper and lower bounds on the values (k, S, p) where extrema are needed; the values at the ends
    stand where they are not.
    """
    coefficients = curves.coefficients(order)
    if len(block.joints) < len(coefficients):
        coefficients = coefficients[block.joints]
    coefficients = coefficients * (curves.inverse_powers[order] / block.scale[:, :, None])[:, None]
    top = curves.degree - order
    if top > CHEAP or order == 0:
        _write_needed_extremes(coefficients, decide, out)
        return
    for degree, segments in degree_groups(curves.degrees):
        own = coefficients[:, : degree + 1 - order, segments].swapaxes(0, 1)
        out[:, 0, segments], out[:, 1, segments] = extremes(own, ARRAYS)


def _write_needed_extremes(coefficients: Array, decide: Callable[[Array, Array], Any], out: Array) -> None:
    """Write extrema of polynomials (k, degree + 1, S, p) as `_write_extremes` does, where they are needed."""
    joints, terms = coefficients.shape[:2]
    hulls = np.matmul(bernstein_change(terms - 1), coefficients.reshape(joints, terms, -1))
    hulls = hulls.reshape(coefficients.shape)
    np.maximum(hulls[:, 0], hulls[:, -1], out=out[:, 0])
    np.minimum(hulls[:, 0], hulls[:, -1], out=out[:, 1])
    k, s, candidate = np.nonzero(decide(hulls.max(axis=1), hulls.min(axis=1)))
    if len(k):
        own = np.ascontiguousarray(coefficients[k, :, s, candidate].T)
        out[k, 0, s, candidate], out[k, 1, s, candidate] = extremes(own, ARRAYS)


@lru_cache
def degree_groups(degrees: tuple[int, ...]) -> tuple[tuple[int, slice], ...]:
    """Return (degree, segments) of the runs of one degree; a first and a last one among others count as one."""
    last = len(degrees) - 1
    if last > 1 and degrees[0] == degrees[last] and degrees[0] not in degrees[1:last]:
        inner = tuple(
            (degree, slice(run.start + 1, run.stop + 1)) for degree, run in degree_groups(degrees[1:last])
        )
        return ((degrees[0], slice(0, last + 1, last)), *inner)
    starts = [k for k in range(last + 1) if k == 0 or degrees[k] != degrees[k - 1]]
    return tuple((degrees[a], slice(a, b)) for a, b in zip(starts, [*starts[1:], last + 1]))


def _ratio(largest: Array, smallest: Array, upper: Array, lower: Array) -> Array:
    """Return the larger of largest / upper and smallest / lower; 0/0 counts as 0, `upper` and `lower` inverted."""
    with np.errstate(invalid="ignore"):
        ratio = np.maximum(largest * upper, smallest * lower)
    return np.where(np.isnan(ratio), 0.0, ratio)
