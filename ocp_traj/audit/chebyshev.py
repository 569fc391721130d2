"""Smooth curves known only by evaluation, turned into piecewise polynomials to a stated bound.

On each segment a curve is sampled at Chebyshev points and interpolated. For a curve without kinks the
coefficients decay geometrically, so the last ones bound what is left out; two points that are no nodes check that. Where the
bound is too large the segment is halved. Extrema and zeros are then those of the interpolants.
(Trefethen, Approximation Theory and Approximation Practice, chapters 3, 8 and 18.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ocp_traj.arrays import Array
from ocp_traj.audit.roots import bracketed_root

DEGREE = 16
"""Degree of the interpolants."""

Pieces: TypeAlias = NDArray[np.int64]

Function = Callable[[Pieces, Array], Array]
"""(pieces (S,), x (S, C)) -> values (S, C, k)."""

Tolerance = Callable[[Array], Array]
"""largest magnitudes (k,) -> allowed error (k,)."""

_TAIL = 4
_SAFETY = 4.0
_MAX_HALVINGS = 30
_MAX_SEGMENTS = 20_000
_GRID = 128
_ORDERS = np.arange(DEGREE + 1.0)
_NODES = np.cos(np.pi * _ORDERS / DEGREE)
_CHECKS = np.array([-0.5497, 0.6823])
_THETA = np.linspace(0.0, np.pi, _GRID + 1)


def _transform() -> Array:
    """Return the matrix from values at the nodes to Chebyshev coefficients."""
    weights = np.ones(DEGREE + 1)
    weights[[0, -1]] = 0.5
    return 2.0 / DEGREE * np.outer(weights, weights) * np.cos(np.pi * np.outer(_ORDERS, _ORDERS) / DEGREE)


def _derivative() -> Array:
    """Return the matrix from Chebyshev coefficients to those of the derivative on [-1, 1]."""
    columns = [np.polynomial.chebyshev.chebder(row) for row in np.eye(DEGREE + 1)]
    return np.array([np.pad(column, (0, DEGREE + 1 - column.size)) for column in columns]).T


_TRANSFORM = _transform()
_DERIVATIVE = _derivative()
_CHECK_BASIS = np.cos(np.outer(_ORDERS, np.arccos(_CHECKS)))


@dataclass(frozen=True)
class ChebyshevCurve:
    """A vector of k functions of time as Chebyshev series on segments of the pieces of a motion.

    Attributes
    ----------
    pieces : (S,) int array
        Piece of the motion each segment lies in.
    left, right : (S,) array
        Ends of the segments inside their piece, in [0, 1].
    coefficients : (S, k, DEGREE + 1) array
        Chebyshev coefficients over [left, right].
    bounds : (S, k) array
        Bound on the interpolation error of each segment.
    resolved : bool
        False when the number of segments ran out before the tolerance was met.
    """

    pieces: Pieces
    left: Array
    right: Array
    coefficients: Array
    bounds: Array
    resolved: bool

    def position(self, segment: Pieces, theta: Array) -> Array:
        """Return x inside the piece for angles theta (x = cos theta over the segment)."""
        left, right = self.left[segment], self.right[segment]
        inner = 0.5 * (left + right) + 0.5 * (right - left) * np.cos(theta)
        return np.where(theta <= 0.0, right, np.where(theta >= np.pi, left, inner))

    def locate(self, pieces: Pieces, x: Array) -> tuple[Pieces, Array]:
        """Return the segment that holds each point x (P,) of pieces (P,), and the angle there."""
        segment = np.searchsorted(self.pieces + self.left, pieces + x, side="right") - 1
        segment = np.clip(segment, np.searchsorted(self.pieces, pieces), None)
        segment = np.minimum(segment, np.searchsorted(self.pieces, pieces, side="right") - 1)
        left, right = self.left[segment], self.right[segment]
        return segment, np.arccos(np.clip((2.0 * x - left - right) / (right - left), -1.0, 1.0))


def differentiate(coefficients: Array) -> Array:
    """Return Chebyshev coefficients of the derivative with respect to the variable in [-1, 1], same shape."""
    return coefficients @ _DERIVATIVE.T


def fit(
    function: Function, pieces: Pieces, left: Array, right: Array, tolerance: Tolerance
) -> ChebyshevCurve:
    """Interpolate `function` on segments, halving them until the error bound meets the tolerance.

    A segment is halved at most 30 times: what is left of a jump then is narrower than 1e-9 of its piece, and
    the values on both of its sides are known. A segment with values that are no finite numbers stays as it is.
    """
    done: list[tuple[Pieces, Array, Array, Array, Array]] = []
    whole = right - left
    largest: Array | None = None
    count, resolved = 0, True
    while pieces.size:
        coefficients, error, magnitude = _interpolate(function, pieces, left, right)
        largest = magnitude if largest is None else np.maximum(largest, magnitude)
        narrow = right - left <= whole * 0.5**_MAX_HALVINGS
        good = (error <= tolerance(largest)).all(axis=1) | narrow | ~np.isfinite(error).all(axis=1)
        count += int(good.sum())
        if count + 2 * int((~good).sum()) > _MAX_SEGMENTS:
            good[:] = True
            resolved = False
        done.append((pieces[good], left[good], right[good], coefficients[good], error[good]))
        pieces, whole = np.repeat(pieces[~good], 2), np.repeat(whole[~good], 2)
        middle = 0.5 * (left[~good] + right[~good])
        left = np.stack([left[~good], middle], axis=1).ravel()
        right = np.stack([middle, right[~good]], axis=1).ravel()
    merged = [np.concatenate(parts) for parts in zip(*done, strict=True)]
    order = np.lexsort((merged[1], merged[0]))
    return ChebyshevCurve(*(part[order] for part in merged), resolved=resolved)


def _interpolate(
    function: Function, pieces: Pieces, left: Array, right: Array
) -> tuple[Array, Array, Array]:
    """Return coefficients (S, k, .), error bounds (S, k) and the largest magnitudes (k,)."""
    points = np.concatenate([_NODES, _CHECKS])
    x = 0.5 * (left + right)[:, None] + 0.5 * (right - left)[:, None] * points
    values = function(pieces, x)
    nodes, checks = values[:, : DEGREE + 1], values[:, DEGREE + 1 :]
    coefficients = np.einsum("ij,sjk->ski", _TRANSFORM, nodes)
    tail = _SAFETY * np.abs(coefficients[:, :, -_TAIL:]).max(axis=2)
    seen = np.abs(np.einsum("ski,ic->sck", coefficients, _CHECK_BASIS) - checks).max(axis=1)
    return coefficients, np.maximum(tail, seen), np.abs(values).max(axis=(0, 1))


def evaluate(coefficients: Array, theta: Array) -> Array:
    """Evaluate series (R, .) at one angle each (R,): the sum of c_k cos(k theta)."""
    values: Array = np.einsum("rk,rk->r", coefficients, np.cos(np.multiply.outer(theta, _ORDERS)))
    return values


def _slopes(coefficients: Array, order: int) -> Callable[[Array], tuple[Array, Array]]:
    """Return theta -> derivatives `order` (0, 1 or 2) and `order` + 1 of the series with respect to theta."""
    weights = [coefficients * _ORDERS**power for power in (order, order + 1)]
    waves: list[Callable[[Array], Array]] = [np.cos, np.sin, np.cos, np.sin]
    signs = [1.0, -1.0, -1.0, 1.0]

    def value_and_slope(theta: Array) -> tuple[Array, Array]:
        angle = np.multiply.outer(theta, _ORDERS)
        value, slope = (
            signs[order + i] * np.einsum("rk,rk->r", weights[i], waves[order + i](angle)) for i in (0, 1)
        )
        return value, slope

    return value_and_slope


_FIRST = -_ORDERS[:, None] * np.sin(np.outer(_ORDERS, _THETA))
_SECOND = -(_ORDERS**2)[:, None] * np.cos(np.outer(_ORDERS, _THETA))


def critical_points(coefficients: Array) -> tuple[Pieces, Array]:
    """Return the row and angle of every interior extremum of series (R, .), and of both ends of every row.

    The second derivative's sign changes on a grid eight times finer than the nodes, refined, and the grid itself
    bracket those of the first derivative: two extrema between neighbouring grid points are found, too.
    """
    rows = np.arange(len(coefficients))
    first, second = coefficients @ _FIRST, coefficients @ _SECOND
    row, column = np.nonzero((second[:, :-1] < 0) != (second[:, 1:] < 0))
    bend = bracketed_root(
        _slopes(coefficients[row], 2), _THETA[column], _THETA[column + 1], second[row, column] < 0
    )
    bend_slope = _slopes(coefficients[row], 1)(bend)[0]
    inside = np.zeros(second[:, 1:].shape, dtype=bool)
    inside[row, column] = True
    plain, cell = np.nonzero(((first[:, :-1] < 0) != (first[:, 1:] < 0)) & ~inside)
    before = (first[row, column] < 0) != (bend_slope < 0)
    behind = (bend_slope < 0) != (first[row, column + 1] < 0)
    row_all = np.concatenate([plain, row[before], row[behind]])
    left = np.concatenate([_THETA[cell], _THETA[column[before]], bend[behind]])
    right = np.concatenate([_THETA[cell + 1], bend[before], _THETA[column[behind] + 1]])
    rising = np.concatenate([first[plain, cell] < 0, first[row[before], column[before]] < 0, bend_slope[behind] < 0])
    inner = bracketed_root(_slopes(coefficients[row_all], 1), left, right, rising)
    ends = np.concatenate([np.zeros(len(rows)), np.full(len(rows), np.pi)])
    return np.concatenate([row_all, rows, rows]), np.concatenate([inner, ends])


def zeros(coefficients: Array) -> tuple[Pieces, Array]:
    """Return the row and angle of every sign change of series (R, .)."""
    row, theta = critical_points(coefficients)
    order = np.lexsort((theta, row))
    row, theta = row[order], theta[order]
    values = evaluate(coefficients[row], theta)
    index = np.flatnonzero((row[1:] == row[:-1]) & ((values[1:] < 0) != (values[:-1] < 0)))
    return row[index], bracketed_root(
        _slopes(coefficients[row[index]], 0), theta[index], theta[index + 1], values[index] < 0
    )


def integrals(coefficients: Array) -> Array:
    """Return the integrals of series (R, .) over [-1, 1]: the sum over even k of 2 c_k / (1 - k^2)."""
    even = _ORDERS[::2]
    values: Array = coefficients[:, ::2] @ (2.0 / (1.0 - even**2))
    return values
