"""Exact extrema of many polynomials at once.

Between two neighbouring critical points a polynomial is monotone, so a sign change there holds exactly one
root. Walking down the derivatives, from the linear one to the polynomial itself, therefore finds every root
of every derivative inside [0, 1] by bracketed Newton steps, whatever the size of the leading coefficients:
there is no division by them. A double root that rounding hides is no loss: the polynomial below has no
extremum there.
"""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.audit.numerics.roots import bracketed_root


def evaluate(coefficients: Array, x: Array) -> Array:
    """Evaluate polynomials.

    Parameters
    ----------
    coefficients : (R, D + 1) array
        Ascending powers, one row a polynomial.
    x : (R, C) array
        Where; row r belongs to polynomial r.

    Returns
    -------
    (R, C) array
    """
    values = np.repeat(coefficients[:, -1:], x.shape[1], axis=1)
    for power in range(coefficients.shape[1] - 2, -1, -1):
        values = values * x + coefficients[:, power : power + 1]
    return values


def differentiate(coefficients: Array) -> Array:
    """Return the coefficients of the derivative, (R, D); of a constant, (R, 1) zeros."""
    if coefficients.shape[1] == 1:
        return np.zeros_like(coefficients)
    return coefficients[:, 1:] * np.arange(1.0, coefficients.shape[1])


def candidate_points(coefficients: Array, orders: int) -> list[Array]:
    """Return, for every derivative below `orders`, points of [0, 1] that include its extrema on [0, 1].

    Parameters
    ----------
    coefficients : (R, D + 1) array
        Ascending powers, one row a polynomial.
    orders : int
        Number of derivatives wanted: entry d of the result belongs to the d-th derivative.

    Returns
    -------
    list of (R, C_d) arrays
        Ascending along the rows; first 0, last 1, between them the roots of derivative d + 1 (and, where
        there are fewer roots than its degree, some points more). The d-th derivative is monotone between
        neighbours.
    """
    rows = coefficients.shape[0]
    derivatives = [coefficients]
    while derivatives[-1].shape[1] > 1 or len(derivatives) <= orders:
        derivatives.append(differentiate(derivatives[-1]))
    nodes = np.tile([0.0, 1.0], (rows, 1))
    found = [nodes] * orders
    for order in range(len(derivatives) - 2, 0, -1):
        degree = derivatives[order].shape[1] - 1
        if degree > 0:
            roots = _roots_between(derivatives[order], derivatives[order + 1], nodes)
            nodes = np.concatenate([np.zeros((rows, 1)), roots, np.ones((rows, 1))], axis=1)
        if order <= orders:
            found[order - 1] = nodes
    return found


def roots_in_unit_interval(coefficients: Array) -> Array:
    """Return 0, the roots inside [0, 1] and 1, ascending along the rows, (R, C).

    Where there are fewer roots than the degree some points stand more; no sign changes between neighbours.
    """
    nodes = candidate_points(coefficients, 1)[0]
    roots = _roots_between(coefficients, differentiate(coefficients), nodes)
    ends = np.zeros((len(coefficients), 1))
    return np.concatenate([ends, roots, ends + 1.0], axis=1)


def _roots_between(coefficients: Array, slope: Array, nodes: Array) -> Array:
    """Return the root between each pair of neighbouring nodes, or the right node where there is none."""
    values = evaluate(coefficients, nodes)
    left, right = nodes[:, :-1], nodes[:, 1:]
    crossing = (values[:, :-1] < 0) != (values[:, 1:] < 0)
    roots: Array = right.copy()
    row, column = np.nonzero(crossing)
    if row.size:
        rows, tangents = coefficients[row], slope[row]

        def value_and_slope(x: Array) -> tuple[Array, Array]:
            return evaluate(rows, x[:, None])[:, 0], evaluate(tangents, x[:, None])[:, 0]

        ends = left[row, column], right[row, column]
        roots[row, column] = bracketed_root(
            value_and_slope, ends, (values[row, column], values[row, column + 1])
        )
    return roots
