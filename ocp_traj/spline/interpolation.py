"""Interpolating splines of odd degree with clamped ends: which unknowns there are, and which conditions hold.

A spline of degree p = 2 r + 1 is C^(p-1). Its pieces are two-point Hermite polynomials of the states
(q, v, a, ... up to order r) at the knots, so r unknown derivatives at every inner knot meet r conditions:
continuity of the derivatives r + 1 to p - 1 there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ocp_traj.spline.elimination import Row, solve_banded
from ocp_traj.spline.hermite import end_derivative_weights

Unknown = tuple[int, int]
"""(knot, derivative) of a knot state; derivative 0 is the position of a virtual knot."""


@dataclass(frozen=True)
class EndConditions:
    """Derivatives given at the start and at the end of a spline: order -> value broadcasting to (P, n).

    Parameters
    ----------
    start, end : dict of int to array
        Order of the derivative to its value, in rad (m) and s; 1 is the velocity.
    """

    start: dict[int, Any]
    end: dict[int, Any]


def knot_states(
    degree: int, durations: list[Any], positions: list[Any], ends: EndConditions
) -> list[list[Any]]:
    """Return the knot states of the interpolating spline.

    Parameters
    ----------
    degree : int
        3, 5 or 7.
    durations : list of m entries
        Piece durations, each a number, a (P, 1) array or a symbol.
    positions : list of m + 1 entries
        Positions at the knots, each broadcasting to (P, n); ``None`` where the end conditions decide it (as many
        inner knots next to each end as that end has conditions beyond order r).
    ends : EndConditions
        A derivative of order j <= r that is not given is free: the spline is then natural there, its derivative
        of order degree - j vanishes, or is what is given for it.

    Returns
    -------
    list of m + 1 lists [q, v, ..., derivative r].
    """
    order = (degree - 1) // 2
    last = len(durations)
    known: dict[Unknown, Any] = {(k, 0): q for k, q in enumerate(positions) if q is not None}
    for knot, given in ((0, ends.start), (last, ends.end)):
        known.update({(knot, j): value for j, value in given.items() if j <= order})
    conditions = _conditions(degree, last, ends)
    unknowns = _unknowns(order, last, known)
    columns = {unknown: column for column, unknown in enumerate(unknowns)}
    rows, right = [], []
    for knot, derivative, value in conditions:
        row, constant = _condition_row(degree, durations, known, columns, knot, derivative)
        rows.append(row)
        right.append(value - constant)
    solved = solve_banded(rows, right)
    known.update({unknown: solved[column] for unknown, column in columns.items()})
    return [[known[(k, j)] for j in range(order + 1)] for k in range(last + 1)]


def _unknowns(order: int, last: int, known: dict[Unknown, Any]) -> list[Unknown]:
    """List unknowns in pivot order; a free position comes after its derivatives in the second half."""
    unknowns: list[Unknown] = []
    for knot in range(last + 1):
        orders = [0, *range(1, order + 1)] if 2 * knot <= last else [*range(1, order + 1), 0]
        unknowns += [(knot, j) for j in orders if (knot, j) not in known]
    return unknowns


def _conditions(degree: int, last: int, ends: EndConditions) -> list[tuple[int, int, Any]]:
    """List (knot, derivative, value) in the order of the unknowns they are paired with.

    At an inner knot of evenly spaced neighbours the jump of derivative d depends on the state of order j only
    when d - j is odd; pairing order j with derivative degree - j keeps every pivot away from zero.
    """
    order = (degree - 1) // 2
    free = range(1, order + 1)
    natural_start, natural_end = (
        [(knot, degree - j, given.get(degree - j, 0.0)) for j in free if j not in given]
        for knot, given in ((0, ends.start), (last, ends.end))
    )
    extra_start, extra_end = (
        [(knot, j, given[j]) for j in extra_orders(degree, given)]
        for knot, given in ((0, ends.start), (last, ends.end))
    )
    inner = [(k, degree - j, 0.0) for k in range(1, last) for j in free]
    return [*natural_start, *extra_start, *inner, *natural_end, *extra_end]


def extra_orders(degree: int, given: dict[int, Any]) -> list[int]:
    """Return the given orders above r that take the place of no natural condition, ascending."""
    order = (degree - 1) // 2
    natural = {degree - j for j in range(1, order + 1) if j not in given}
    return [j for j in sorted(given) if j > order and j not in natural]


def _condition_row(
    degree: int,
    durations: list[Any],
    known: dict[Unknown, Any],
    columns: dict[Unknown, int],
    knot: int,
    derivative: int,
) -> tuple[Row, Any]:
    """Return the row of one condition and what its known states contribute.

    At an end: the derivative itself. At an inner knot: its jump, right minus left.
    """
    row: Row = {}
    constant: Any = 0.0
    sides = [(knot - 1, 1.0, -1.0)] if knot > 0 else []
    if knot < len(durations):
        sides.append((knot, 0.0, 1.0))
    if len(sides) == 1:
        sides = [(sides[0][0], sides[0][1], 1.0)]
    for piece, tau, sign in sides:
        weights = end_derivative_weights(degree, derivative, tau)
        h = durations[piece]
        for side in (0, 1):
            for j in range(weights.shape[1]):
                if weights[side, j] == 0.0:
                    continue
                entry = sign * weights[side, j] * h ** (j - derivative)
                unknown = (piece + side, j)
                if unknown in columns:
                    column = columns[unknown]
                    row[column] = row[column] + entry if column in row else entry
                else:
                    constant = constant + entry * known[unknown]
    return row, constant
