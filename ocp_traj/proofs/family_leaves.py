"""Which joint, quantity and instant of a 3-5-3 curve refute a box of durations: hints for the checker."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.proofs import checker

INSTANTS = 128
"""Instants of the quintic that are looked at; the ends of the cubics, where theirs are extreme, are enough."""
FINEST = 4096
"""Instants are multiples of 1/FINEST of 1/INSTANTS of a piece."""
NEAR = 1.02
"""Ratio of value and limit below which the instant is moved to the extremum."""


class FamilyLeaves:
    """Finds, for a box, the derivative that is farthest beyond its limit at the box's centre.

    Parameters
    ----------
    search : checker.Search
    """

    def __init__(self, search: checker.Search) -> None:
        self.search = search
        self.travel = np.diff(np.array(search.task.waypoints, dtype=np.float64), axis=0)  # (3, n)
        self.quintic = [(order, Fraction(k, INSTANTS)) for order in (1, 2) for k in range(INSTANTS + 1)]
        self.cubics = [(order, Fraction(u)) for order in (1, 2) for u in (0, 1)]
        self.tables = {
            piece: [_table(piece, order, u) for order, u in (self.quintic if piece == 1 else self.cubics)]
            for piece in range(3)
        }

    def __call__(self, low: list[Fraction], high: list[Fraction]) -> list[Any] | None:
        """Return a leaf that refutes the box, or None."""
        task = self.search.task
        for joint, row in enumerate(self.search.joints):
            for gap in range(3) if row else ():
                if row[gap].W * high[gap] < row[gap].near or -row[gap].V * high[gap] > row[gap].far:
                    return ["joint", joint + 1, gap + 1, gap + 1]
        centre = np.array([float(a + b) / 2 for a, b in zip(low, high)])
        if not (centre > 0).all():
            return None
        ratio, joint, order, piece, u = self._worst(centre)
        if ratio <= 1.0:
            return None
        if piece == 1 and ratio < NEAR:
            u = self._extremum(centre, joint, order, u)
        if checker.is_beyond(task, joint, order, piece, u, low, high, self.search.total):
            return ["instant", joint + 1, order, piece + 1, float(u).hex()]
        return None

    def _worst(self, h: Array) -> tuple[float, int, int, int, Fraction]:
        """Return the largest ratio of value and limit, and where it is."""
        best = (0.0, 0, 1, 0, Fraction(0))
        for piece, tables in self.tables.items():
            places = self.quintic if piece == 1 else self.cubics
            values = np.array([weights * np.prod(h**powers, axis=1) for weights, powers in tables])  # by way
            travels = self.travel[_ways(piece)]
            ratios = np.abs(values @ travels) / self._limits(piece, places, values @ travels)
            where = np.unravel_index(int(np.argmax(ratios)), ratios.shape)
            if ratios[where] > best[0]:
                order, u = places[where[0]]
                best = (float(ratios[where]), int(where[1]), order, piece, u)
        return best

    def _limits(self, piece: int, places: list[tuple[int, Fraction]], values: Array) -> Array:
        rows = {}
        for order in (1, 2):
            pairs = [self.search.task.limit(checker.ORDERS[order], piece, j) for j in range(values.shape[1])]
            rows[order] = np.array(pairs, dtype=np.float64).T
        limits = np.array([rows[order] for order, _ in places])
        return np.maximum(np.where(values < 0, -limits[:, 0], limits[:, 1]), 1e-300)

    def _extremum(self, h: Array, joint: int, order: int, u: Fraction) -> Fraction:
        """Return an instant nearer to the extremum of a derivative of the quintic, by a parabola, twice."""
        for step in (Fraction(1, INSTANTS), Fraction(1, 8 * INSTANTS)):
            left, middle, right = (abs(self._value(h, joint, order, x)) for x in (u - step, u, u + step))
            bend = left - 2 * middle + right
            shift = max(-1.0, min(1.0, 0.5 * (left - right) / bend)) if bend < 0 else 0.0
            u = min(max(u + Fraction(round(shift * FINEST), FINEST) * step, Fraction(0)), Fraction(1))
        return u

    def _value(self, h: Array, joint: int, order: int, u: Fraction) -> float:
        weights, powers = _table(1, order, u)
        return float(weights * np.prod(h**powers, axis=1) @ self.travel[_ways(1), joint])


def _table(piece: int, order: int, u: Fraction) -> tuple[Array, Array]:
    """Return weights (T,) and powers (T, 3) of the terms of a derivative; their ways are those of `_ways`."""
    terms = checker.monomials(piece, order, u)
    return np.array([float(term[0]) for term in terms]), np.array([term[2] for term in terms], dtype=np.float64)


def _ways(piece: int) -> list[int]:
    """Return the gap whose way each term carries."""
    return [term[1] for term in checker.monomials(piece, 1, Fraction(1, 3))]
