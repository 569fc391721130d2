"""Largest and smallest value of a low-degree polynomial on [0, 1], in closed form, for arrays and for symbols.

The same formulas run on NumPy arrays (a population at once) and on CasADi expressions, so a population solver and
a gradient solver see the same numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import Any

import numpy as np

LARGEST_DEGREE = 4
"""Of a polynomial whose extrema have a closed form here."""

TINY = 1e-13
"""Leading coefficients below this share of the largest one are treated as this share."""


class ArrayOperations:
    """NumPy; what is done to every root is done to all roots at once."""

    where: Any = staticmethod(np.where)
    sqrt: Any = staticmethod(np.sqrt)
    cos: Any = staticmethod(np.cos)
    arccos: Any = staticmethod(np.arccos)
    cbrt: Any = staticmethod(np.cbrt)
    absolute: Any = staticmethod(np.absolute)
    maximum: Any = staticmethod(np.maximum)
    minimum: Any = staticmethod(np.minimum)
    copysign: Any = staticmethod(np.copysign)

    def total(self, values: Any) -> Any:
        """Return the sum of the values."""
        return np.add.reduce(values, axis=0)

    def each(self, function: Callable[[Any], Any], values: list[Any]) -> Any:
        """Return the function of each value, along the first axis."""
        return function(np.array(values))

    def differentiate(self, coefficients: Any) -> Any:
        """Return the coefficients of the derivative, in one array."""
        powers = np.arange(1.0, len(coefficients))
        return coefficients[1:] * powers.reshape(-1, *(1,) * (coefficients.ndim - 1))

    def normalise(self, coefficients: Any) -> Any:
        """Return the coefficients divided by the sum of their magnitudes, in one array."""
        return coefficients / (np.add.reduce(np.absolute(coefficients), axis=0) + 1e-300)


class SymbolicOperations:
    """CasADi, element by element."""

    def __init__(self) -> None:
        import casadi as ca

        self.where: Any = ca.if_else
        self.sqrt: Any = ca.sqrt
        self.cos: Any = ca.cos
        self.arccos: Any = ca.acos
        self.absolute: Any = ca.fabs
        self.maximum: Any = ca.fmax
        self.minimum: Any = ca.fmin
        self.copysign: Any = lambda size, sign: ca.if_else(sign < 0, -size, size)
        # The small shift keeps the derivative of the real cube root finite at 0.
        self.cbrt: Any = lambda x: ca.sign(x) * (ca.fabs(x) + 1e-300) ** (1.0 / 3.0)

    def total(self, values: Any) -> Any:
        """Return the sum of the values."""
        return sum(values[1:], values[0])

    def each(self, function: Callable[[Any], Any], values: list[Any]) -> Any:
        """Return the function of each value, in a list."""
        return [function(value) for value in values]

    def differentiate(self, coefficients: Any) -> Any:
        """Return the coefficients of the derivative, in a list."""
        return [power * value for power, value in enumerate(coefficients)][1:]

    def normalise(self, coefficients: Any) -> Any:
        """Return the coefficients divided by the sum of their magnitudes, in a list."""
        scale = sum((self.absolute(value) for value in coefficients), 1e-300)
        return [value / scale for value in coefficients]


Operations = ArrayOperations | SymbolicOperations
"""The few functions the formulas need, with NumPy's names and arguments."""


def extremes(coefficients: Any, ops: Operations) -> tuple[Any, Any]:
    """Return (largest, smallest) value on [0, 1] of the polynomial with ascending coefficients, degree <= 4.

    A point computed as critical only approximately costs the square of its error, so the closed forms below are
    exact to rounding wherever an extremum matters. `coefficients` is an array whose first axis is the power, or a
    list of symbols.
    """
    start, end = coefficients[0], ops.total(coefficients)
    largest, smallest = ops.maximum(start, end), ops.minimum(start, end)
    if len(coefficients) < 3:
        return largest, smallest

    def value_inside(root: Any) -> Any:
        return evaluate(coefficients, ops.minimum(ops.maximum(root, 0.0), 1.0))

    for value in ops.each(value_inside, _roots(ops.differentiate(coefficients), ops)):
        largest, smallest = ops.maximum(largest, value), ops.minimum(smallest, value)
    return largest, smallest


def evaluate(coefficients: Any, t: Any) -> Any:
    """Horner's rule."""
    value = coefficients[-1]
    for power in range(len(coefficients) - 2, -1, -1):
        value = value * t + coefficients[power]
    return value


def _roots(coefficients: Any, ops: Operations) -> list[Any]:
    """Return real numbers among which all real roots are; where there are fewer, any number fills up."""
    degree = len(coefficients) - 1
    if degree == 1:
        return [-coefficients[0] / ops.where(coefficients[1] == 0, 1.0, coefficients[1])]
    monic = ops.normalise(coefficients)
    leading = _away_from_zero(monic[-1], TINY, ops)
    if degree == 2:
        return _quadratic_roots(monic[0], monic[1], leading, ops)
    if degree == 3:
        return _guarded_cubic_roots(monic, ops)
    raise ValueError(f"closed form of degree {degree} asked for, expected at most 3")


def _away_from_zero(value: Any, least: float, ops: Operations) -> Any:
    """Return the value with a magnitude of at least `least`, to divide by."""
    return ops.copysign(ops.maximum(ops.absolute(value), least), value)


def _quadratic_roots(c: Any, b: Any, a: Any, ops: Operations) -> list[Any]:
    """Roots of a t^2 + b t + c without cancellation."""
    root = ops.sqrt(ops.maximum(b * b - 4 * a * c, 0.0) + 1e-300)
    half = -0.5 * (b + ops.copysign(root, b))
    half = _away_from_zero(half, 1e-150, ops)
    return [half / a, c / half]


def _guarded_cubic_roots(monic: Any, ops: Operations) -> list[Any]:
    """Roots of a cubic whose leading coefficient may vanish: then those of the quadratic start the polishing."""
    flat = ops.absolute(monic[3]) < 1e-5
    leading = ops.where(flat, 1.0, monic[3])
    square = _away_from_zero(monic[2], TINY, ops)
    fallback = [*_quadratic_roots(monic[0], monic[1], square, ops), 0.0]
    roots = _cubic_roots(monic[0] / leading, monic[1] / leading, monic[2] / leading, ops)
    starts = [ops.where(flat, other, root) for root, other in zip(roots, fallback)]
    slope = ops.differentiate(monic)
    return list(ops.each(lambda root: _polish(monic, slope, _polish(monic, slope, root, ops), ops), starts))


def _cubic_roots(c: Any, b: Any, a: Any, ops: Operations) -> list[Any]:
    """Roots of t^3 + a t^2 + b t + c: trigonometric for three real ones, Cardano's for one."""
    shift = a / 3
    p = b - a * shift
    q = c - shift * b + 2 * shift * shift * shift
    third = p / 3
    discriminant = q * q / 4 + third * third * third
    one_real = discriminant > 0
    radical = ops.sqrt(ops.maximum(discriminant, 0.0) + 1e-300)
    # Take the larger cube root, the other follows from their product -p / 3.
    base = -(q / 2 + ops.copysign(radical, q))
    u = ops.cbrt(base)
    single = u - third / _away_from_zero(u, 1e-100, ops)
    radius = ops.sqrt(ops.maximum(-third, 0.0) + 1e-300)
    cosine = -q / (2 * radius * radius * radius + 1e-300)
    angle = ops.arccos(ops.minimum(ops.maximum(cosine, -1 + 1e-16), 1 - 1e-16)) / 3

    def root(turned: Any) -> Any:
        return ops.where(one_real, single, 2 * radius * ops.cos(turned)) - shift

    return list(ops.each(root, [angle - turn for turn in (0.0, 2 * pi / 3, 4 * pi / 3)]))


def _polish(coefficients: Any, slope: Any, root: Any, ops: Operations) -> Any:
    """One guarded Newton step for a root inside (or near) [0, 1]; `slope` is the derivative."""
    at = ops.minimum(ops.maximum(root, -1.0), 2.0)
    steep = evaluate(slope, at)
    steep = _away_from_zero(steep, 1e-8, ops)
    step = ops.minimum(ops.maximum(evaluate(coefficients, at) / steep, -1e-2), 1e-2)
    return at - step
