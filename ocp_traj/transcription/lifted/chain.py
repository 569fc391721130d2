"""The chain of integrators: a C^(p-1) spline of degree p as knot states q, v, a, ..., derivative p - 1.

Between two knots the derivative p is constant, so the states at the end of a segment follow from those at its
start and from the highest one at its end; a motion is a spline exactly when they agree (the defects vanish). For
the cubic these are q+ = q + v h + a h^2/3 + a+ h^2/6 and v+ = v + (a + a+) h/2.
"""

from __future__ import annotations

from functools import cache
from math import factorial
from typing import Any

import casadi as ca

from ocp_traj.transcription.lifted.elements import Formula
from ocp_traj.transcription.quadrature import gauss_legendre


def chain_value(degree: int, order: int, fraction: Any, h: Any, states: list[Any], top: Any) -> Any:
    """Return the derivative `order` at `fraction` of a segment.

    Parameters
    ----------
    degree, order : int
        0 <= order <= degree.
    fraction : number or symbol in [0, 1]
    h : segment duration, s
    states : derivatives `order` to degree - 1 at the start of the segment (empty for order = degree)
    top : (derivative degree - 1 at the end) - (the same at the start)
    """
    value = top * fraction ** (degree - order) * h ** (degree - 1 - order) / factorial(degree - order)
    for index, state in enumerate(states):
        value = value + state * (fraction * h) ** index / factorial(index) if index else value + state
    return value


@cache
def defect_formula(degree: int) -> Formula:
    """Return the degree - 1 scaled defects of one joint over one segment.

    Local variables: scaled duration, scaled states at the start (p), scaled states at the end (p). Parameters:
    scale of every state (p), scale of the duration.
    """
    h, start, end = ca.SX.sym("h"), ca.SX.sym("start", degree), ca.SX.sym("end", degree)
    scales = ca.SX.sym("scales", degree + 1)
    duration = h * scales[degree]
    states = [start[j] * scales[j] for j in range(degree)]
    top = (end[degree - 1] - start[degree - 1]) * scales[degree - 1]
    defects = [
        chain_value(degree, j, 1.0, duration, states[j:], top) / scales[j] - end[j] for j in range(degree - 1)
    ]
    return Formula("defect", ca.vertcat(h, start, end), scales, ca.vertcat(*defects))


@cache
def sample_formula(degree: int, order: int) -> Formula:
    """Return a scaled derivative at a point of a segment.

    Local variables: scaled duration, scaled states `order` to p - 1 at the start, scaled state p - 1 at the end.
    Parameters: their scales (p - order), scale of the duration, fraction, scale of the value.
    """
    count = degree - order
    h, start, end = ca.SX.sym("h"), ca.SX.sym("start", count), ca.SX.sym("end")
    parameters = ca.SX.sym("parameters", count + 3)
    duration = h * parameters[count]
    states = [start[index] * parameters[index] for index in range(count)]
    top = (end - start[count - 1]) * parameters[count - 1]
    value = chain_value(degree, order, parameters[count + 1], duration, states, top)
    return Formula(f"sample{order}", ca.vertcat(h, start, end), parameters, value / parameters[count + 2])


@cache
def bernstein_formula() -> Formula:
    """Return the middle Bernstein coefficient v + a h / 2 of a cubic's velocity, scaled.

    A quadratic lies inside the hull of its Bernstein coefficients, so bounding this one bounds the velocity inside
    the segment: sufficient, not necessary, and all but exact with virtual knots. Local variables: scaled
    duration, v, a at the start; parameters as in `sample_formula` of order 1 (the fraction is not used).
    """
    local, parameters = ca.SX.sym("local", 3), ca.SX.sym("parameters", 5)
    value = local[1] * parameters[0] + local[2] * parameters[1] * local[0] * parameters[2] / 2
    return Formula("bernstein", local, parameters, value / parameters[4])


@cache
def squared_formula(degree: int, order: int) -> Formula:
    """Return the integral over a segment of a squared derivative, exact by Gauss-Legendre quadrature.

    Local variables: scaled duration, scaled states `order` to p - 1 at start, state p - 1 at both ends.
    Parameters: their scales, scale of the duration.
    """
    count = max(degree - order, 1)
    first = degree - count
    h, start, end = ca.SX.sym("h"), ca.SX.sym("start", count), ca.SX.sym("end")
    parameters = ca.SX.sym("parameters", count + 1)
    duration = h * parameters[count]
    states = [start[index] * parameters[index] for index in range(count)]
    top = (end - start[count - 1]) * parameters[count - 1]
    total = 0
    for node, weight in zip(*gauss_legendre(degree - order + 1)):
        total += weight * chain_value(degree, order, node, duration, states[order - first :], top) ** 2
    return Formula(f"squared{order}", ca.vertcat(h, start, end), parameters, total * duration)
