"""Assembly: elements and linear rows become one sparse numerical problem with exact derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import scipy.sparse as sparse

from ocp_traj.arrays import Array
from ocp_traj.transcription.lifted.elements import IndexArray, Places
from ocp_traj.transcription.nlp import Symbol

WeightedPlaces = tuple[Places, Array]
"""Places with one value each, and their (N,) weights in the cost."""


@dataclass(frozen=True)
class SymbolicProblem:
    """min f(x) subject to bounds on g(x), with derivative functions a solver can use as they are.

    Attributes
    ----------
    x, f, g : MX
    derivatives : dict
        ``grad_f``, ``jac_g``, ``hess_lag`` in the form CasADi's nlpsol takes them; empty where CasADi shall
        differentiate itself.
    """

    x: Symbol
    f: Symbol
    g: Symbol
    derivatives: dict[str, Any]


def assemble(
    size: int, rows: list[Places], linear: sparse.csr_matrix, costs: list[WeightedPlaces], gradient: Array
) -> SymbolicProblem:
    """Assemble a problem.

    Parameters
    ----------
    size : int
        Number of variables d.
    rows : list of Places
        Their values are the first rows of g, set after set.
    linear : (r, d) sparse matrix
        The last rows of g.
    costs : list of (Places with one value, (N,) weights)
        Nonlinear terms of f.
    gradient : (d,)
        Linear term of f.
    """
    x, p = ca.MX.sym("x", size), ca.MX.sym("p", 0)
    f = ca.dot(ca.DM(gradient), x)
    for places, weights in costs:
        f += ca.dot(ca.DM(weights), places.call("value", x))
    values = [places.call("value", x) for places in rows]
    if linear.shape[0]:
        values.append(ca.mtimes(_to_dm(linear), x))
    g = ca.vertcat(*values) if values else ca.MX(0, 1)
    derivatives = {
        "grad_f": _gradient(x, p, f, costs, gradient),
        "jac_g": _jacobian(x, p, g, rows, linear),
        "hess_lag": _hessian(x, p, g.numel(), rows, costs),
    }
    return SymbolicProblem(x, f, g, derivatives)


def _to_dm(matrix: sparse.csr_matrix) -> Any:
    columns = sparse.csc_matrix(matrix)
    columns.sort_indices()
    rows, width = (int(size) for size in matrix.shape)
    return ca.DM(ca.Sparsity(rows, width, columns.indptr.tolist(), columns.indices.tolist()), columns.data)


def _gradient(x: Any, p: Any, f: Any, costs: list[WeightedPlaces], gradient: Array) -> Any:
    columns: list[IndexArray] = [np.arange(len(gradient))]
    values = [ca.MX(ca.DM(gradient))]
    for places, weights in costs:
        row, column = places.jacobian_triplets()
        columns.append(column)
        values.append(places.call("jacobian", x) * ca.DM(weights[row]))
    total = _sum_into(np.concatenate(columns), len(gradient), ca.vertcat(*values)) if costs else values[0]
    return ca.Function("nlp_grad_f", [x, p], [f, total], ["x", "p"], ["f", "grad:f:x"])


def _jacobian(x: Any, p: Any, g: Any, rows: list[Places], linear: sparse.csr_matrix) -> Any:
    row_parts, column_parts, values = [], [], []
    offset = 0
    for places in rows:
        row, column = places.jacobian_triplets()
        row_parts.append(row + offset)
        column_parts.append(column)
        values.append(places.call("jacobian", x))
        offset += places.count * places.rows
    coordinates = linear.tocoo()
    row_parts.append(coordinates.row + offset)
    column_parts.append(coordinates.col)
    values.append(ca.MX(ca.DM(coordinates.data)))
    row, column = np.concatenate(row_parts), np.concatenate(column_parts)
    order = np.lexsort((row, column))
    sparsity = ca.Sparsity.triplet(
        offset + linear.shape[0], x.numel(), row[order].tolist(), column[order].tolist()
    )
    jacobian = ca.MX(sparsity, ca.vertcat(*values)[order.tolist()])
    return ca.Function("nlp_jac_g", [x, p], [g, jacobian], ["x", "p"], ["g", "jac:g:x"])


def _hessian(x: Any, p: Any, count: int, rows: list[Places], costs: list[WeightedPlaces]) -> Any:
    factor, multipliers = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", count)
    row_parts: list[IndexArray] = []
    column_parts: list[IndexArray] = []
    values = []
    offset = 0
    weighted = [(places, factor * ca.DM(weights)) for places, weights in costs]
    for places in rows:
        weighted.append((places, multipliers[offset : offset + places.count * places.rows]))
        offset += places.count * places.rows
    for places, weights in weighted:
        row, column = places.hessian_triplets()
        if len(row):
            row_parts.append(row)
            column_parts.append(column)
            values.append(places.call("hessian", x, weights))
    size = x.numel()
    hessian = ca.MX(size, size)
    if values:
        key = np.concatenate(column_parts) * size + np.concatenate(row_parts)
        unique, position = np.unique(key, return_inverse=True)
        sparsity = ca.Sparsity.triplet(size, size, (unique % size).tolist(), (unique // size).tolist())
        hessian = ca.MX(sparsity, _sum_into(position, len(unique), ca.vertcat(*values)))
    return ca.Function(
        "nlp_hess_l",
        [x, p, factor, multipliers],
        [hessian],
        ["x", "p", "lam:f", "lam:g"],
        ["triu:hess:gamma:x:x"],
    )


def _sum_into(positions: IndexArray, size: int, values: Any) -> Any:
    """Return a column of `size` sums: value k is added at positions[k]."""
    count = len(positions)
    sparsity = ca.Sparsity(int(size), count, list(range(count + 1)), positions.tolist())
    return ca.mtimes(ca.DM(sparsity, 1.0), values)
