"""Largest and smallest value of a low-degree polynomial on [0, 1], in closed form, for arrays and for symbols.

The same formulas run on NumPy arrays (a population at once) and on CasADi expressions, so a population solver and
a gradient solver see the same numbers.
"""

from __future__ import annotations

from math import pi
from typing import Any, Protocol

import numpy as np

TINY = 1e-13
"""Leading coefficients below this share of the largest one are treated as this share."""


class Operations(Protocol):
    """The few functions the formulas need, with NumPy's names and arguments."""

    where: Any
    sqrt: Any
    cos: Any
    arccos: Any
    cbrt: Any
    absolute: Any
    maximum: Any
    minimum: Any


class ArrayOperations:
    """NumPy."""

    where: Any = staticmethod(np.where)
    sqrt: Any = staticmethod(np.sqrt)
    cos: Any = staticmethod(np.cos)
    arccos: Any = staticmethod(np.arccos)
    cbrt: Any = staticmethod(np.cbrt)
    absolute: Any = staticmethod(np.absolute)
    maximum: Any = staticmethod(np.maximum)
    minimum: Any = staticmethod(np.minimum)


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
        # The small shift keeps the derivative of the real cube root finite at 0.
        self.cbrt: Any = lambda x: ca.sign(x) * (ca.fabs(x) + 1e-300) ** (1.0 / 3.0)


def extremes(coefficients: list[Any], ops: Operations) -> tuple[Any, Any]:
    """Return (largest, smallest) value on [0, 1] of the polynomial with ascending coefficients, degree <= 4.

    A point computed as critical only approximately costs the square of its error, so the closed forms below are
    exact to rounding wherever an extremum matters.
    """
    start, end = coefficients[0], sum(coefficients[1:], coefficients[0])
    largest, smallest = ops.maximum(start, end), ops.minimum(start, end)
    derivative = [power * value for power, value in enumerate(coefficients)][1:]
    for root in _roots(derivative, ops):
        at = ops.minimum(ops.maximum(root, 0.0), 1.0)
        value = evaluate(coefficients, at)
        largest, smallest = ops.maximum(largest, value), ops.minimum(smallest, value)
    return largest, smallest


def evaluate(coefficients: list[Any], t: Any) -> Any:
    """Horner's rule."""
    value = coefficients[-1]
    for coefficient in reversed(coefficients[:-1]):
        value = value * t + coefficient
    return value


def _roots(coefficients: list[Any], ops: Operations) -> list[Any]:
    """Return real numbers among which all real roots are; where there are fewer, any number fills up."""
    degree = len(coefficients) - 1
    if degree <= 0:
        return []
    scale = sum((ops.absolute(value) for value in coefficients[1:]), ops.absolute(coefficients[0])) + 1e-300
    monic = [value / scale for value in coefficients]
    leading = ops.where(ops.absolute(monic[-1]) < TINY, TINY, monic[-1])
    if degree == 1:
        return [-monic[0] / leading]
    if degree == 2:
        return _quadratic_roots(monic[0], monic[1], leading, ops)
    if degree == 3:
        return _guarded_cubic_roots(monic, ops)
    raise ValueError(f"closed form of degree {degree} asked for, expected at most 3")


def _quadratic_roots(c: Any, b: Any, a: Any, ops: Operations) -> list[Any]:
    """Roots of a t^2 + b t + c without cancellation."""
    root = ops.sqrt(ops.maximum(b * b - 4 * a * c, 0.0) + 1e-300)
    half = -0.5 * (b + ops.where(b < 0, -root, root))
    half = ops.where(ops.absolute(half) < 1e-150, 1e-150, half)
    return [half / a, c / half]


def _guarded_cubic_roots(monic: list[Any], ops: Operations) -> list[Any]:
    """Roots of a cubic whose leading coefficient may vanish: then those of the quadratic start the polishing."""
    flat = ops.absolute(monic[3]) < 1e-5
    leading = ops.where(flat, 1.0, monic[3])
    square = ops.where(ops.absolute(monic[2]) < TINY, TINY, monic[2])
    fallback = [*_quadratic_roots(monic[0], monic[1], square, ops), 0.0]
    roots = []
    for root, other in zip(
        _cubic_roots(monic[0] / leading, monic[1] / leading, monic[2] / leading, ops), fallback
    ):
        at = _polish(monic, ops.where(flat, other, root), ops)
        roots.append(_polish(monic, at, ops))
    return roots


def _cubic_roots(c: Any, b: Any, a: Any, ops: Operations) -> list[Any]:
    """Roots of t^3 + a t^2 + b t + c: trigonometric for three real ones, Cardano's for one."""
    shift = a / 3
    p = b - a * shift
    q = c - shift * b + 2 * shift**3
    third = p / 3
    discriminant = q * q / 4 + third**3
    one_real = discriminant > 0
    radical = ops.sqrt(ops.maximum(discriminant, 0.0) + 1e-300)
    # Take the larger cube root, the other follows from their product -p / 3.
    base = -q / 2 + ops.where(q > 0, -radical, radical)
    u = ops.cbrt(base)
    single = u - third / ops.where(ops.absolute(u) < 1e-100, 1e-100, u)
    radius = ops.sqrt(ops.maximum(-third, 0.0) + 1e-300)
    angle = ops.arccos(ops.minimum(ops.maximum(-q / (2 * radius**3 + 1e-300), -1 + 1e-16), 1 - 1e-16)) / 3
    roots = []
    for turn in (0.0, 2 * pi / 3, 4 * pi / 3):
        roots.append(ops.where(one_real, single, 2 * radius * ops.cos(angle - turn)) - shift)
    return roots


def _polish(coefficients: list[Any], root: Any, ops: Operations) -> Any:
    """One guarded Newton step for a root inside (or near) [0, 1]."""
    derivative = [power * value for power, value in enumerate(coefficients)][1:]
    at = ops.minimum(ops.maximum(root, -1.0), 2.0)
    slope = evaluate(derivative, at)
    slope = ops.where(ops.absolute(slope) < 1e-8, 1e-8, slope)
    step = ops.minimum(ops.maximum(evaluate(coefficients, at) / slope, -1e-2), 1e-2)
    return at - step
