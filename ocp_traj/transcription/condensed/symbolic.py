"""The condensed form as symbols: the same rows and numbers as its batched evaluation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from ocp_traj.spline import EndConditions, Piece, get_family
from ocp_traj.spline.hermite import derivative_row
from ocp_traj.transcription.condensed.extrema import SymbolicOperations, extremes
from ocp_traj.transcription.curve import decided_knots, end_conditions

if TYPE_CHECKING:
    from ocp_traj.transcription.condensed.condensed import CondensedNlp
    from ocp_traj.transcription.condensed.limit_rows import Block
    from ocp_traj.transcription.condensed.rows import KinematicRows


def condensed_symbols(nlp: CondensedNlp) -> tuple[Any, Any, Any]:
    """Return x, f, g of a condensed problem with encoding durations or log-durations."""
    rows, task = nlp.rows_of, nlp.task
    x = ca.SX.sym("x", nlp.dimension)
    durations = ca.exp(x[: nlp.segments]) if nlp.encoding == "log-durations" else x[: nlp.segments]
    pieces = _pieces(nlp, durations, x[nlp.segments :])
    kinematic = [_kinematic_rows(entry, pieces) for entry in rows.kinematic]
    sums = [ca.sum1(durations[segments.tolist()]) / scale for segments, scale, *_ in nlp._code.sums]
    cost = task.objective.time * ca.sum1(durations)
    for term in rows.squared:
        cost += term.weight(task) * _squared_integral(term.order, pieces)
    if not rows.instants and not rows.terms:
        return x, cost, ca.vertcat(*kinematic, *sums)
    return _with_instants(nlp, x, durations, pieces, cost, kinematic, sums)


def _pieces(nlp: CondensedNlp, durations: Any, offsets: Any) -> list[Piece]:
    task = nlp.task
    per_gap = task.virtual_knots + 1
    half = np.ptp(task.waypoints, axis=0) / 2
    positions: list[Any] = []
    for gap in range(task.gaps):
        start, end = task.waypoints[gap], task.waypoints[gap + 1]
        positions.append(ca.DM(start).T)
        for knot in range(1, per_gap):
            first = (gap * task.virtual_knots + knot - 1) * task.n
            chord = start + (end - start) * (knot / per_gap)
            positions.append(ca.DM(chord).T + (ca.DM(half) * offsets[first : first + task.n]).T)
    positions.append(ca.DM(task.waypoints[-1]).T)
    starts, ends = decided_knots(task)
    for knot in (*starts, *ends):
        positions[knot] = None
    given = end_conditions(task)
    symbolic = EndConditions(
        {order: ca.DM(value) for order, value in given.start.items()},
        {order: ca.DM(value) for order, value in given.end.items()},
    )
    return get_family(task.family).pieces([durations[k] for k in range(nlp.segments)], positions, symbolic)


def _derivative(piece: Piece, order: int, fraction: float) -> Any:
    """Return a derivative at a fraction of a piece, (1, n)."""
    row = derivative_row(piece.degree, order, fraction)
    coefficients = piece.coefficients()
    value = sum(weight * coefficient for weight, coefficient in zip(row, coefficients) if weight != 0.0)
    return value / piece.duration**order


def _kinematic_rows(entry: KinematicRows, pieces: list[Piece]) -> Any:
    order, joints = entry.limit.order, entry.block.joints.tolist()
    if not entry.exact:
        columns = [
            _derivative(piece, order, fraction)[:, joints].T
            for fraction in entry.block.fractions
            for piece in pieces
        ]
        return _in_order(ca.horzcat(*columns), entry.block)
    sides: list[list[Any]] = [[], []]
    for piece in pieces:
        coefficients = piece.coefficients()
        for _ in range(order):
            coefficients = [power * value for power, value in enumerate(coefficients)][1:]
        found = extremes([value[:, joints] for value in coefficients], SymbolicOperations())
        for side, value in zip(sides, found):
            side.append((value / piece.duration**order).T)
    return _in_order(ca.horzcat(*sides[0], *sides[1]), entry.block)


def _in_order(values: Any, block: Block) -> Any:
    """Return values (k, N S), segments fastest, as scaled rows: values slowest, segments fastest."""
    scale = np.tile(block.scale, (1, len(block.fractions)))
    return ca.vec((values / ca.DM(scale)).T)


def _squared_integral(order: int, pieces: list[Piece]) -> Any:
    degree = max(piece.degree for piece in pieces)
    nodes, weights = np.polynomial.legendre.leggauss(degree - order + 1)
    total = 0
    for piece in pieces:
        for node, weight in zip((nodes + 1) / 2, weights / 2):
            value = _derivative(piece, order, float(node))
            total += float(weight) * piece.duration * ca.sumsqr(value)
    return total


def _with_instants(
    nlp: CondensedNlp,
    x: Any,
    durations: Any,
    pieces: list[Piece],
    cost: Any,
    kinematic: list[Any],
    sums: list[Any],
) -> tuple[Any, Any, Any]:
    """Add rows and terms of torques by mapping their functions over the samples (MX)."""
    rows = nlp.rows_of
    motion = [
        ca.horzcat(*[_derivative(piece, order, at).T for at in rows.fractions for piece in pieces])
        for order in range(4)
    ]
    inner = ca.Function("motion", [x], [cost, durations, ca.vertcat(*kinematic), ca.vertcat(*sums), *motion])
    outer = ca.MX.sym("x", nlp.dimension)
    f, h, g_kinematic, g_sums, *columns = inner(outer)
    count = len(pieces) * len(rows.fractions)
    g = [g_kinematic]
    for entry in rows.instants:
        values = entry.function.map(count)(*columns)
        g.append(_in_order(values, entry.block))
    for term in rows.terms:
        values = term.function.map(count)(*columns)
        if term.term.shape == "absolute":
            values = ca.fabs(values)
        elif term.term.shape == "positive":
            values = ca.fmax(values, 0)
        integrand = ca.reshape(ca.sum1(values), len(pieces), len(rows.fractions))
        f += term.weight * ca.dot(ca.mtimes(integrand, ca.DM(rows.simpson)), h)
    return outer, f, ca.vertcat(*g, g_sums)
