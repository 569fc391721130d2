"""The condensed form as symbols: the same rows and numbers as its batched evaluation."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from ocp_traj.spline import EndConditions, Piece
from ocp_traj.spline.hermite import derivative_row
from ocp_traj.transcription.condensed.encodings import Encoding
from ocp_traj.transcription.condensed.extrema import SymbolicOperations, extremes
from ocp_traj.transcription.condensed.limit_rows import LimitRows
from ocp_traj.transcription.condensed.rows import CondensedRows, KinematicRows
from ocp_traj.transcription.curve import end_conditions, pieces_through
from ocp_traj.transcription.nlp import Symbol
from ocp_traj.transcription.quadrature import gauss_legendre


def condensed_symbols(encoding: Encoding) -> tuple[Symbol, Symbol, Symbol]:
    """Return x, f, g of the condensed problem whose variables an encoding gives their meaning.

    Raises
    ------
    UnavailableError
        The encoding has no symbols.
    """
    rows, task = encoding.rows, encoding.task
    x = ca.SX.sym("x", len(encoding.lower))
    durations, positions = encoding.symbolic_curve(x)
    given = end_conditions(task)
    start, end = ({order: ca.DM(value) for order, value in side.items()} for side in (given.start, given.end))
    pieces = pieces_through(task, ca.vertsplit(durations), positions, EndConditions(start, end))
    kinematic = [_kinematic_rows(entry, pieces) for entry in rows.kinematic]
    sums = [ca.sum1(durations[row.segments.tolist()]) / row.scale for row in encoding.sums]
    cost: Symbol = ca.sum1(durations)
    cost = task.objective.time * cost
    for term in rows.squared:
        cost += term.weight(task) * _squared_integral(term.order, pieces)
    if not rows.instants and not rows.terms:
        return x, cost, ca.vertcat(*kinematic, *sums)
    motion = [
        ca.horzcat(*[_derivative(piece, order, at).T for at in rows.fractions for piece in pieces])
        for order in range(4)
    ]
    outputs = [cost, durations, ca.vertcat(*kinematic), ca.vertcat(*sums), *motion]
    return _with_instants(rows, ca.Function("motion", [x], outputs))


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


def _in_order(values: Any, block: LimitRows) -> Any:
    """Return values (k, N S), segments fastest, as scaled rows: values slowest, segments fastest."""
    scale = np.tile(block.scale, (1, len(block.fractions)))
    return ca.vec((values / ca.DM(scale)).T)


def _squared_integral(order: int, pieces: list[Piece]) -> Symbol:
    degree = max(piece.degree for piece in pieces)
    nodes, weights = gauss_legendre(degree - order + 1)
    total = 0
    for piece in pieces:
        for node, weight in zip(nodes, weights):
            value = _derivative(piece, order, node)
            total += float(weight) * piece.duration * ca.sumsqr(value)
    return total


def _with_instants(rows: CondensedRows, motion: Any) -> tuple[Symbol, Symbol, Symbol]:
    """Return x, f, g with rows and terms of torques, their functions mapped over the samples (MX).

    Parameters
    ----------
    rows : CondensedRows
    motion : casadi.Function
        x -> cost and durations, rows of derivatives and of durations, and q, v, a, jerk (n, samples) each.
    """
    x = ca.MX.sym("x", motion.size1_in(0))
    f, h, g_kinematic, g_sums, *columns = motion(x)
    segments, points = h.numel(), len(rows.fractions)
    g = [g_kinematic]
    for entry in rows.instants:
        values = entry.function.map(segments * points)(*columns)
        g.append(_in_order(values, entry.block))
    for term in rows.terms:
        values = term.function.map(segments * points)(*columns)
        if term.term.shape == "absolute":
            values = ca.fabs(values)
        elif term.term.shape == "positive":
            values = ca.fmax(values, 0)
        integrand = ca.reshape(ca.sum1(values), segments, points)
        f += term.weight * ca.dot(ca.mtimes(integrand, ca.DM(rows.simpson)), h)
    return x, f, ca.vertcat(*g, g_sums)
