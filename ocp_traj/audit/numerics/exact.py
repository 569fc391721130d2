"""Polynomials with float coefficients, evaluated so exactly that rounding plays no part in a verdict.

Values where pieces meet are computed in pairs of floats, high and low, by error-free transformations (Dekker,
Numer. Math. 18 (1971) 224-242): about 100 bits. Extrema of polynomials whose terms cancel are bounded in rational
arithmetic by Bernstein coefficients and halving.
"""

from __future__ import annotations

from fractions import Fraction
from math import comb, lcm, perm
from typing import TypeAlias

import numpy as np

from ocp_traj.arrays import Array

Pair: TypeAlias = tuple[Array, Array]
"""High and low floats of a number that is their sum."""

PAIR_ROUNDING = 2.0**-98
"""Relative error of a product and a sum of pairs, generously."""

_SPLITTER = 2.0**27 + 1.0
_MAX_HALVINGS = 80
_CLOSE = Fraction(1, 2**40)


def difference(a: Array, b: Array) -> Pair:
    """Return a - b of floats without error."""
    return _two_sum(a, -b)


def _two_sum(a: Array, b: Array) -> Pair:
    total = a + b
    virtual = total - a
    return total, (a - (total - virtual)) + (b - virtual)


def _two_product(a: Array, b: Array) -> Pair:
    product = a * b
    a_high, b_high = (_SPLITTER * a - (_SPLITTER * a - a), _SPLITTER * b - (_SPLITTER * b - b))
    a_low, b_low = a - a_high, b - b_high
    return product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


def _times(a: Pair, b: Pair) -> Pair:
    high, low = _two_product(a[0], b[0])
    return _two_sum(high, low + (a[0] * b[1] + a[1] * b[0]))


def _plus(a: Pair, b: Pair) -> Pair:
    high, low = _two_sum(a[0], b[0])
    low_high, low_low = _two_sum(a[1], b[1])
    high, low = _two_sum(high, low + low_high)
    return _two_sum(high, low + low_low)


def values_at_ends(coefficients: Array, breakpoints: Array, order: int) -> tuple[Pair, Pair]:
    """Return a derivative at the start and at the end of every piece, each a pair of (m, n).

    Parameters
    ----------
    coefficients : (m, n, degree + 1) array
        Ascending powers of time since the start of the piece.
    breakpoints : (m + 1,) array
    order : int
        0 position, 1 velocity, ...
    """
    shape = coefficients.shape[:2]
    high, low = difference(breakpoints[1:], breakpoints[:-1])
    length = np.broadcast_to(high[:, None], shape), np.broadcast_to(low[:, None], shape)
    start: Pair = np.zeros(shape), np.zeros(shape)
    end: Pair = np.zeros(shape), np.zeros(shape)
    for power in range(coefficients.shape[2] - 1, order - 1, -1):
        factor = np.full(shape, float(perm(power, order)))
        start = _two_product(coefficients[:, :, power], factor)
        end = _plus(_times(end, length), start)
    return start, end


def distance(a: Pair, b: Pair) -> Array:
    """Return the magnitude of a - b as floats."""
    high, low = _plus(a, (-b[0], -b[1]))
    return np.abs(high + low)


def range_of(coefficients: Array, start: float, end: float, order: int) -> tuple[float, float, float, float]:
    """Return the smallest and largest value of a derivative on one piece, and where, in [0, 1].

    Parameters
    ----------
    coefficients : (degree + 1,) array
        Ascending powers of time since `start`.
    start, end : float
        Ends of the piece, s.
    order : int

    Returns
    -------
    smallest, where, largest, where : float
        Values are outside the true ones by at most 1e-12 of the largest magnitude on the piece.
    """
    length = Fraction(float(end)) - Fraction(float(start))
    terms = [
        Fraction(float(value)) * perm(power, order) * length ** (power - order)
        for power, value in enumerate(coefficients)
        if power >= order
    ] or [Fraction(0)]
    while len(terms) > 1 and not terms[-1]:
        terms.pop()
    degree = len(terms) - 1
    bernstein = [
        sum((Fraction(comb(j, i), comb(degree, i)) * terms[i] for i in range(j + 1)), Fraction(0))
        for j in range(degree + 1)
    ]
    shared = lcm(*(value.denominator for value in bernstein))
    numerators = [int(value * shared) for value in bernstein]
    largest, at_largest = _largest(numerators)
    smallest, at_smallest = _largest([-value for value in numerators])
    return -float(smallest / shared), at_smallest, float(largest / shared), at_largest


def _largest(bernstein: list[int]) -> tuple[Fraction, float]:
    """Return an upper bound of a polynomial with these Bernstein coefficients on [0, 1], and where it lies.

    Halves are searched with all their numerators multiplied by two to the degree for every halving.
    """
    degree = len(bernstein) - 1
    ends = [(Fraction(bernstein[0]), 0.0), (Fraction(bernstein[-1]), 1.0)]
    best, place = max(ends)
    size, highest = max(abs(value) for value, _ in ends), best
    waiting = [(bernstein, 0, 0.0)]
    while waiting:
        hull, depth, left = waiting.pop()
        scale = 1 << (degree * depth)
        bound = Fraction(max(hull), scale)
        if bound <= best + _CLOSE * size or depth == _MAX_HALVINGS:
            highest = max(highest, bound)
            continue
        lower, upper = _halves(hull)
        middle = Fraction(lower[-1], scale << degree)
        size, width = max(size, abs(middle)), 0.5 ** (depth + 1)
        if middle > best:
            best, place = middle, left + width
        waiting += [(lower, depth + 1, left), (upper, depth + 1, left + width)]
    return max(highest, best), place


def _halves(bernstein: list[int]) -> tuple[list[int], list[int]]:
    """Return the coefficients of both halves (de Casteljau), times two to the degree."""
    degree = len(bernstein) - 1
    row, lower, upper = bernstein, [], []
    for level in range(degree + 1):
        lower.append(row[0] << (degree - level))
        upper.append(row[-1] << (degree - level))
        row = [a + b for a, b in zip(row, row[1:])]
    return lower, upper[::-1]
