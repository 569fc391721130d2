"""Interval arithmetic with slopes, over arrays: what a formula can give for any argument in a box.

The spline families compute with whatever has +, -, *, / and integer powers; given `Enclosure` objects as durations
they return intervals that contain every value, and intervals that contain every partial derivative by the
durations. Rounding errors (1e-15 relative) are far below the margin the certificates leave.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.arrays import Array


@dataclass(frozen=True)
class Enclosure:
    """Intervals of a value and of its partial derivatives.

    Attributes
    ----------
    low, high : (1 + G, P, m) arrays
        Entry 0 holds the value, entry 1 + g its derivative by the g-th variable; m broadcasts.
    """

    low: Array
    high: Array

    __array_ufunc__ = None  # arrays on the left leave the operation to us

    @classmethod
    def variables(cls, low: Array, high: Array) -> list[Enclosure]:
        """Return the G variables, (P, 1) each, that range over boxes `low`, `high` (P, G)."""
        found = []
        for index in range(low.shape[1]):
            ends = [np.zeros((1 + low.shape[1], len(low), 1)) for _ in range(2)]
            for end, values in zip(ends, (low, high)):
                end[0, :, 0] = values[:, index]
                end[1 + index] = 1.0
            found.append(cls(*ends))
        return found

    def __add__(self, other: Any) -> Enclosure:
        if isinstance(other, Enclosure):
            return Enclosure(self.low + other.low, self.high + other.high)
        return Enclosure(_shifted(self.low, other), _shifted(self.high, other))

    __radd__ = __add__

    def __neg__(self) -> Enclosure:
        return Enclosure(-self.high, -self.low)

    def __sub__(self, other: Any) -> Enclosure:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Enclosure:
        return (-self).__add__(other)

    def __mul__(self, other: Any) -> Enclosure:
        if not isinstance(other, Enclosure):
            with np.errstate(invalid="ignore"):  # infinity times a zero weight: nothing is known
                low, high = self.low * other, self.high * other
            low = np.where(np.isnan(low), -np.inf, low)
            high = np.where(np.isnan(high), np.inf, high)
            return Enclosure(np.minimum(low, high), np.maximum(low, high))
        value = _product(self.low[:1], self.high[:1], other.low[:1], other.high[:1])
        left = _product(self.low[1:], self.high[1:], other.low[:1], other.high[:1])
        right = _product(self.low[:1], self.high[:1], other.low[1:], other.high[1:])
        return Enclosure(*(np.concatenate([value[k], left[k] + right[k]]) for k in range(2)))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Enclosure:
        inverse: Any = other**-1 if isinstance(other, Enclosure) else 1.0 / other
        return self.__mul__(inverse)

    def __rtruediv__(self, other: Any) -> Enclosure:
        return (self**-1).__mul__(other)

    def __pow__(self, power: int) -> Enclosure:
        if power == 0:
            ends = [np.zeros_like(end) for end in (self.low, self.high)]
            for end in ends:
                end[0] = 1.0
            return Enclosure(*ends)
        value = _power(self.low[:1], self.high[:1], power)
        factor = tuple(power * end for end in _power(self.low[:1], self.high[:1], power - 1))
        outer = (np.minimum(*factor), np.maximum(*factor))
        slopes = _product(*outer, self.low[1:], self.high[1:])
        return Enclosure(*(np.concatenate([value[k], slopes[k]]) for k in range(2)))


def _shifted(end: Array, constant: Any) -> Array:
    shape = np.broadcast_shapes(end.shape[1:], np.shape(constant))
    result = np.array(np.broadcast_to(end, (len(end), *shape)))
    result[0] += constant
    return result


def _product(low: Array, high: Array, other_low: Array, other_high: Array) -> tuple[Array, Array]:
    with np.errstate(invalid="ignore", over="ignore"):
        corners = (low * other_low, low * other_high, high * other_low, high * other_high)
    lowest = np.minimum(np.minimum(corners[0], corners[1]), np.minimum(corners[2], corners[3]))
    highest = np.maximum(np.maximum(corners[0], corners[1]), np.maximum(corners[2], corners[3]))
    # infinity times zero: nothing is known
    return np.where(np.isnan(lowest), -np.inf, lowest), np.where(np.isnan(highest), np.inf, highest)


def _power(low: Array, high: Array, power: int) -> tuple[Array, Array]:
    """Return the interval of x^power; for negative powers everything where x may be 0."""
    if power == 0:
        return np.ones_like(low), np.ones_like(high)
    with np.errstate(divide="ignore", over="ignore"):
        ends = (low**power, high**power)
    lowest, highest = np.minimum(*ends), np.maximum(*ends)
    around = (low <= 0) & (high >= 0)
    if power > 0:
        return (np.where(around, 0.0, lowest) if power % 2 == 0 else lowest), highest
    return np.where(around, -np.inf, lowest), np.where(around, np.inf, highest)
