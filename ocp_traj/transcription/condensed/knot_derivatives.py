"""Interpolating splines of a whole population: one small banded system a candidate, all eliminated together.

A spline of degree 2 r + 1 with r derivatives given (or natural) at its ends is the curve of least
integral (d^(r+1) q / dt^(r+1))^2 through its knots. In the derivatives 1 to r at the knots that integral is a
quadratic form, block tridiagonal and positive definite for any durations, so elimination needs no pivoting, and the
conditions of continuity are its gradient.
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache

import numpy as np

from ocp_traj.arrays import Array, read_only
from ocp_traj.spline.hermite import falling, hermite_matrix

Known = dict[int, Array]
"""Derivatives given at an end: order -> values broadcasting to (n, p)."""


@lru_cache
def bending(degree: int) -> Array:
    """Return the matrix of integral_0^1 (d^(r+1) q / d tau^(r+1))^2 in a piece's scaled end states."""
    high = (degree + 1) // 2
    # In fractions: the entries cancel, and their errors would come back multiplied by the system's condition.
    matrix = [
        [Fraction(entry).limit_denominator(1000) for entry in row] for row in hermite_matrix(degree).tolist()
    ]
    powers = range(high, degree + 1)
    bent = [[int(falling(power, high)) * entry for entry in matrix[power]] for power in powers]
    entries = [
        [
            float(sum(a[i] * b[j] / (k + m + 1) for k, a in enumerate(bent) for m, b in enumerate(bent)))
            for j in range(degree + 1)
        ]
        for i in range(degree + 1)
    ]
    return read_only(entries)


def knot_derivatives(degree: int, h: Array, positions: Array, start: Known, end: Known) -> Array:
    """Return the derivatives 1 to r at all knots, (r, S + 1, n, p).

    Parameters
    ----------
    degree : int
    h : (S, p) durations, s
    positions : (S + 1, n, p) or (S + 1, n, 1)
    start, end : dict
        Given derivatives of order at most r; one that is missing is natural.
    """
    order, last = (degree - 1) // 2, len(h)
    n, p = positions.shape[1], h.shape[1]
    values = np.empty((order, last + 1, n, p))
    unknown = [list(range(1, order + 1)) for _ in range(last + 1)]
    for knot, given in ((0, start), (last, end)):
        unknown[knot] = [j for j in unknown[knot] if j not in given]
        for j, value in given.items():
            values[j - 1, knot] = value
    if any(unknown):
        _System(degree, h, positions, values, unknown).solve()
    return values


class _System:
    """The block tridiagonal system of one population; `values` holds what is given and receives the solution."""

    def __init__(
        self, degree: int, h: Array, positions: Array, values: Array, unknown: list[list[int]]
    ) -> None:
        order = (degree - 1) // 2
        states = bending(degree).reshape(2, order + 1, 2, order + 1)
        exponents = np.arange(order + 1)[:, None] + np.arange(order + 1)[None, :]
        inverse = 1.0 / h
        powers = [inverse]
        for _ in range(2 * order):
            powers.append(powers[-1] * inverse)
        # (r + 1, r + 1, S, p); bending scales with h^(i + j - 2 r - 1)
        spread = np.stack(powers[::-1])[exponents]
        left, across, right = (states[a, :, b, :, None, None] for a, b in ((0, 0), (0, 1), (1, 1)))
        self.left, self.right = left[1:, 1:] * spread[1:, 1:], right[1:, 1:] * spread[1:, 1:]
        self.across = across * spread
        self.values, self.unknown = values, unknown
        knots, p = len(h) + 1, h.shape[1]
        self.diagonal = np.zeros((order, order, knots, p))
        self.diagonal[:, :, 1:] = self.right
        self.diagonal[:, :, :-1] += self.left
        # The positions enter by their differences alone: a constant bends nothing.
        rise = positions[1:] - positions[:-1]
        self.load = np.zeros((order, knots, *values.shape[2:]))
        self.load[:, 1:] = self.across[0, 1:, :, None] * rise
        self.load[:, :-1] -= self.across[1:, 0, :, None] * rise
        for knot in (0, knots - 1):
            self._move_given(knot)

    def _move_given(self, knot: int) -> None:
        """Bring the derivatives given at an end to the right-hand sides of that end and of its neighbour."""
        given = [j for j in range(self.values.shape[0]) if j + 1 not in self.unknown[knot]]
        piece, neighbour = (0, 1) if knot == 0 else (knot - 1, knot - 1)
        own = self.left if knot == 0 else self.right
        for j in given:
            value = self.values[j, knot]
            if value.any():
                across = self.across[j + 1, 1:] if knot == 0 else self.across[1:, j + 1]
                self.load[:, knot] -= own[:, j, piece, None] * value
                self.load[:, neighbour] -= across[:, piece, None] * value

    def solve(self) -> None:
        """Eliminate from the first knot to the last, then substitute back."""
        knots = [knot for knot, orders in enumerate(self.unknown) if orders]
        eliminated = []
        first = self._rows(knots[0])
        block, load = self.diagonal[np.ix_(first, first)][:, :, knots[0]], self.load[first, knots[0]]
        for knot in knots:
            following = knot + 1 if knot < knots[-1] else None
            window = self._window(knot, block, load, following)
            size = len(self.unknown[knot])
            _eliminate(window, size)
            eliminated.append(window[:size])
            if following is not None:
                width = len(self.unknown[following])
                block, load = window[size:, size : size + width], window[size:, size + width :]
        below = np.empty((0, *self.values.shape[2:]))
        for knot, rows in zip(reversed(knots), reversed(eliminated)):
            below = _substitute(rows, below)
            for index, j in enumerate(self.unknown[knot]):
                self.values[j - 1, knot] = below[index]

    def _window(self, knot: int, block: Array, load: Array, following: int | None) -> Array:
        """Return the rows of two neighbouring knots: their matrix beside their right-hand sides."""
        size = block.shape[0]
        if following is None:
            return np.concatenate([block, load], axis=1)
        rows, columns = self._rows(knot), self._rows(following)
        coupling = self.across[1:, 1:, knot]
        diagonal = self.diagonal[:, :, following]
        if len(rows) < len(coupling) or len(columns) < len(coupling):
            coupling, diagonal = coupling[np.ix_(rows, columns)], diagonal[np.ix_(columns, columns)]
        width = len(columns)
        window = np.empty((size + width, size + width + load.shape[1], load.shape[2]))
        window[:size, :size], window[:size, size : size + width] = block, coupling
        window[size:, :size] = coupling.transpose(1, 0, 2)
        window[size:, size : size + width] = diagonal
        window[:size, size + width :] = load
        window[size:, size + width :] = self.load[columns, following]
        return window

    def _rows(self, knot: int) -> list[int]:
        return [j - 1 for j in self.unknown[knot]]


def _eliminate(window: Array, size: int) -> None:
    """Eliminate the first `size` unknowns from the rows below them, in place; pivots become their reciprocals."""
    for pivot in range(size):
        row = window[pivot]
        np.divide(1.0, row[pivot], out=row[pivot])
        below = window[pivot + 1 :]
        if len(below):
            factors = below[:, pivot] * row[pivot]
            below[:, pivot + 1 :] -= factors[:, None] * row[pivot + 1 :]


def _substitute(rows: Array, below: Array) -> Array:
    """Return the unknowns (size, n, p) of eliminated rows, given those of the next knot."""
    size = rows.shape[0]
    width = size + below.shape[0]
    solved = np.empty((width, *below.shape[1:]))
    solved[size:] = below
    for pivot in reversed(range(size)):
        value = solved[pivot]
        value[...] = rows[pivot, width:]
        if pivot + 1 < width:
            value -= (rows[pivot, pivot + 1 : width, None] * solved[pivot + 1 :]).sum(axis=0)
        value *= rows[pivot, pivot]
    return solved[:size]
