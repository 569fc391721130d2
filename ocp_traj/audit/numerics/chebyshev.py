"""Smooth curves known only by evaluation, turned into piecewise polynomials to a stated bound.

On each segment a curve is sampled at Chebyshev points and interpolated. For a curve without kinks the
coefficients decay geometrically, so the last ones bound what is left out; two points that are no nodes check
that. Where the bound is too large the segment is halved. Extrema and zeros are then those of the
interpolants. (Trefethen, Approximation Theory and Approximation Practice, chapters 3, 8 and 18.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ocp_traj.arrays import Array
from ocp_traj.audit.numerics.roots import bracketed_root

DEGREE = 16
"""Degree of the interpolants."""

LOW_DEGREE = 8
"""Degree tried first where a motion has many short pieces, as sampled ones do."""

Pieces: TypeAlias = NDArray[np.int64]

Function = Callable[[Pieces, Array], Array]
"""(pieces (S,), x (S, C)) -> values (S, C, k)."""

Tolerance = Callable[[Array], Array]
"""largest magnitudes (k,) -> allowed error (k,)."""

_SAFETY = 4.0
_MAX_HALVINGS = 30
_MAX_SEGMENTS = 100_000
_MANY = 64
_GRID = 128
_COARSE = 1e-6
_FINE = 1e-12
_ORDERS = np.arange(DEGREE + 1.0)
NODES = np.cos(np.pi * _ORDERS / DEGREE)
CHECKS = np.array([-0.5497, 0.6823])
_MANY_CHECKS = np.concatenate([CHECKS, np.cos(np.pi * (_ORDERS[:-1] + 0.5) / DEGREE)])
"""Also the middles between nodes: 35 samples in all, for motions up to degree 30."""

_THETA = np.linspace(0.0, np.pi, _GRID + 1)


def _transform(degree: int) -> Array:
    """Return the matrix from values at degree + 1 nodes to Chebyshev coefficients."""
    weights, orders = np.ones(degree + 1), np.arange(degree + 1.0)
    weights[[0, -1]] = 0.5
    return 2.0 / degree * np.outer(weights, weights) * np.cos(np.pi * np.outer(orders, orders) / degree)


def _derivative() -> Array:
    """Return the matrix from Chebyshev coefficients to those of the derivative on [-1, 1]."""
    columns = [np.polynomial.chebyshev.chebder(row) for row in np.eye(DEGREE + 1)]
    return np.array([np.pad(column, (0, DEGREE + 1 - column.size)) for column in columns]).T


_TRANSFORMS = {degree: _transform(degree) for degree in (LOW_DEGREE, DEGREE)}
_DERIVATIVE = _derivative()


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
    function: Function,
    pieces: Pieces,
    left: Array,
    right: Array,
    tolerance: Tolerance,
    most: int | None = None,
    motion_degree: int = 0,
) -> ChebyshevCurve:
    """Interpolate `function` on segments, halving them until the error bound meets the tolerance.

    At most `most` segments are made (100 000 by default, at least twice those given); what is not resolved by
    then is marked so.

    A polynomial can vanish at as many points as its degree: one of a high degree could be hidden between the
    samples. There are always more of them than `motion_degree`, the degree of the motion the function belongs to.

    A segment is halved at most 30 times: what is left of a jump then is narrower than 1e-9 of its piece, and
    the values on both of its sides are known. A segment with values that are no finite numbers stays as it
    is.
    """
    done: list[tuple[Pieces, Array, Array, Array, Array]] = []
    whole, segments = right - left, pieces.size
    largest: Array | None = None
    count, resolved = 0, True
    most = max(_MAX_SEGMENTS if most is None else most, 2 * segments)
    degree = LOW_DEGREE if pieces.size > _MANY and motion_degree <= LOW_DEGREE else DEGREE
    checks = CHECKS if motion_degree <= DEGREE else _MANY_CHECKS
    while pieces.size:
        coefficients, error, magnitude = _interpolate(function, pieces, left, right, degree, checks)
        largest = magnitude if largest is None else np.maximum(largest, magnitude)
        narrow = right - left <= whole * 0.5**_MAX_HALVINGS
        good = (error <= tolerance(largest)).all(axis=1) | narrow | ~np.isfinite(error).all(axis=1)
        count += int(good.sum())
        if degree == DEGREE and count + 2 * int((~good).sum()) > most:
            good[:] = True
            resolved = False
        done.append((pieces[good], left[good], right[good], coefficients[good], error[good]))
        if degree < DEGREE:
            degree, pieces, whole, left, right = (
                DEGREE,
                pieces[~good],
                whole[~good],
                left[~good],
                right[~good],
            )
            continue
        pieces, whole = np.repeat(pieces[~good], 2), np.repeat(whole[~good], 2)
        middle = 0.5 * (left[~good] + right[~good])
        left = np.stack([left[~good], middle], axis=1).ravel()
        right = np.stack([middle, right[~good]], axis=1).ravel()
    pieces = np.concatenate([part[0] for part in done])
    left, right, series, bounds = (np.concatenate([part[i] for part in done]) for i in range(1, 5))
    order = np.lexsort((left, pieces))
    return ChebyshevCurve(pieces[order], left[order], right[order], series[order], bounds[order], resolved)


def _interpolate(
    function: Function, pieces: Pieces, left: Array, right: Array, degree: int, checks: Array
) -> tuple[Array, Array, Array]:
    """Return coefficients (S, k, DEGREE + 1), error bounds (S, k) and the largest magnitudes (k,).

    The error bound is four times the largest of the last quarter of the coefficients, or what is seen at points
    that are no nodes, if that is more.
    """
    points = np.concatenate([NODES[:: DEGREE // degree], checks])
    x = 0.5 * (left + right)[:, None] + 0.5 * (right - left)[:, None] * points
    values = function(pieces, x)
    nodes, others = values[:, : degree + 1], values[:, degree + 1 :]
    basis = np.cos(np.outer(_ORDERS[: degree + 1], np.arccos(checks)))
    coefficients = np.einsum("ij,sjk->ski", _TRANSFORMS[degree], nodes)
    tail = _SAFETY * np.abs(coefficients[:, :, -(degree // 4) :]).max(axis=2)
    seen = np.abs(np.einsum("ski,ic->sck", coefficients, basis) - others).max(axis=1)
    padded = np.zeros((*coefficients.shape[:2], DEGREE + 1))
    padded[:, :, : degree + 1] = coefficients
    return padded, np.maximum(tail, seen), np.abs(values).max(axis=(0, 1))


def evaluate(coefficients: Array, theta: Array) -> Array:
    """Evaluate series (R, .) at one angle each (R,): the sum of c_k cos(k theta)."""
    return np.einsum("rk,rk->r", coefficients, np.cos(np.multiply.outer(theta, _ORDERS)))


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


_COSINES = np.cos(np.outer(_ORDERS, _THETA))
_FIRST = -_ORDERS[:, None] * np.sin(np.outer(_ORDERS, _THETA))
_SECOND = -(_ORDERS**2)[:, None] * np.cos(np.outer(_ORDERS, _THETA))


def enclosures(coefficients: Array) -> tuple[Array, Array, Array, Array]:
    """Return the smallest and largest value of series (R, .) on a grid, and bounds of their values anywhere.

    A trigonometric polynomial of degree n is at most 1 / cos(n pi / N) times its largest magnitude on N
    equidistant angles of the circle (Ehlich, Zeller, Math. Z. 86 (1964) 41-44); here N is twice the grid and
    the polynomial is the series less the middle of its range.
    """
    values = coefficients @ _COSINES
    low, high = values.min(axis=1), values.max(axis=1)
    slack = 0.5 * (high - low) * (1.0 / np.cos(0.5 * np.pi * DEGREE / _GRID) - 1.0)
    return low, high, low - slack, high + slack


def critical_points(coefficients: Array) -> tuple[Pieces, Array]:
    """Return the row and angle of every interior extremum of series (R, .), and of both ends of every row.

    The second derivative's sign changes on a grid eight times finer than the nodes, refined, and the grid
    itself bracket those of the first derivative: two extrema between neighbouring grid points are found, too.
    """
    rows = np.arange(len(coefficients))
    first, second = coefficients @ _FIRST, coefficients @ _SECOND
    row, cell = np.nonzero((second[:, :-1] < 0) != (second[:, 1:] < 0))
    bend = bracketed_root(
        _slopes(coefficients[row], 2),
        (_THETA[cell], _THETA[cell + 1]),
        (second[row, cell], second[row, cell + 1]),
        _COARSE,
    )
    grid_rows = np.repeat(rows, _GRID + 1)
    points = np.concatenate([np.tile(_THETA, len(rows)), bend])
    slopes = np.concatenate([first.ravel(), _slopes(coefficients[row], 1)(bend)[0]])
    found = _sign_changes(coefficients, 1, np.concatenate([grid_rows, row]), points, slopes)
    ends = np.concatenate([np.zeros(len(rows)), np.full(len(rows), np.pi)])
    return np.concatenate([found[0], rows, rows]), np.concatenate([found[1], ends])


def zeros(coefficients: Array) -> tuple[Pieces, Array]:
    """Return the row and angle of every sign change of series (R, .)."""
    _, _, low, high = enclosures(coefficients)
    crossing = np.flatnonzero((low <= 0) & (high >= 0))
    row, theta = critical_points(coefficients[crossing])
    found = _sign_changes(coefficients[crossing], 0, row, theta, evaluate(coefficients[crossing][row], theta))
    return crossing[found[0]], found[1]


def _sign_changes(
    coefficients: Array, order: int, row: Pieces, theta: Array, values: Array
) -> tuple[Pieces, Array]:
    """Return row and angle of the roots between neighbours of the same row whose values differ in sign."""
    sequence = np.argsort(row * 4.0 + theta, kind="stable")
    row, theta, values = row[sequence], theta[sequence], values[sequence]
    index = np.flatnonzero((row[1:] == row[:-1]) & ((values[1:] < 0) != (values[:-1] < 0)))
    roots = bracketed_root(
        _slopes(coefficients[row[index]], order),
        (theta[index], theta[index + 1]),
        (values[index], values[index + 1]),
        _FINE,
    )
    return row[index], roots


def integrals(coefficients: Array) -> Array:
    """Return the integrals of series (R, .) over [-1, 1]: the sum over even k of 2 c_k / (1 - k^2)."""
    even = _ORDERS[::2]
    return coefficients[:, ::2] @ (2.0 / (1.0 - even**2))
