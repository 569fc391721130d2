"""Assembly: elements and linear rows become one sparse numerical problem with exact derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import scipy.sparse as sparse

from ocp_traj.arrays import Array
from ocp_traj.transcription.elements import Elements, IndexArray


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

    x: Any
    f: Any
    g: Any
    derivatives: dict[str, Any]


def assemble(
    size: int, rows: list[Elements], linear: sparse.csr_matrix, costs: list[tuple[Elements, Array]], gradient: Array
) -> SymbolicProblem:
    """Assemble a problem.

    Parameters
    ----------
    size : int
        Number of variables d.
    rows : list of Elements
        Their values are the first rows of g, set after set.
    linear : (r, d) sparse matrix
        The last rows of g.
    costs : list of (Elements with one value, (N,) weights)
        Nonlinear terms of f.
    gradient : (d,)
        Linear term of f.
    """
    x = ca.MX.sym("x", size)
    count = sum(elements.count * elements.formula.rows for elements in rows) + linear.shape[0]
    f = ca.dot(ca.DM(gradient), x)
    for elements, weights in costs:
        f += ca.dot(ca.DM(weights), elements.call("value", x))
    values = [elements.call("value", x) for elements in rows]
    if linear.shape[0]:
        values.append(ca.mtimes(ca.DM(sparse.csc_matrix(linear)), x))
    g = ca.vertcat(*values) if values else ca.MX(0, 1)
    p = ca.MX.sym("p", 0)
    derivatives = {
        "grad_f": _gradient(x, p, f, costs, gradient),
        "jac_g": _jacobian(x, p, g, rows, linear),
        "hess_lag": _hessian(x, p, count, rows, costs),
    }
    return SymbolicProblem(x, f, g, derivatives)


def _gradient(x: Any, p: Any, f: Any, costs: list[tuple[Elements, Array]], gradient: Array) -> Any:
    columns: list[IndexArray] = [np.arange(len(gradient))]
    values = [ca.MX(ca.DM(gradient))]
    for elements, weights in costs:
        _, column = elements.jacobian_triplets()
        per_place = len(elements.formula.jacobian_pattern[1])
        columns.append(column)
        values.append(elements.call("jacobian", x) * ca.DM(np.repeat(weights, per_place)))
    total = _sum_into(np.concatenate(columns), len(gradient), ca.vertcat(*values))
    return ca.Function("nlp_grad_f", [x, p], [f, total], ["x", "p"], ["f", "grad:f:x"])


def _jacobian(x: Any, p: Any, g: Any, rows: list[Elements], linear: sparse.csr_matrix) -> Any:
    row_parts, column_parts, values = [], [], []
    offset = 0
    for elements in rows:
        row, column = elements.jacobian_triplets()
        row_parts.append(row + offset)
        column_parts.append(column)
        values.append(elements.call("jacobian", x))
        offset += elements.count * elements.formula.rows
    coordinates = linear.tocoo()
    row_parts.append(coordinates.row + offset)
    column_parts.append(coordinates.col)
    values.append(ca.MX(ca.DM(coordinates.data)))
    row, column = np.concatenate(row_parts), np.concatenate(column_parts)
    order = np.lexsort((row, column))
    pattern = ca.Sparsity.triplet(
        offset + linear.shape[0], x.numel(), row[order].tolist(), column[order].tolist()
    )
    jacobian = ca.MX(pattern, ca.vertcat(*values)[order.tolist()])
    return ca.Function("nlp_jac_g", [x, p], [g, jacobian], ["x", "p"], ["g", "jac:g:x"])


def _hessian(x: Any, p: Any, count: int, rows: list[Elements], costs: list[tuple[Elements, Array]]) -> Any:
    factor, multipliers = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", count)
    row_parts: list[IndexArray] = []
    column_parts: list[IndexArray] = []
    values = []
    offset = 0
    for elements in rows:
        size = elements.count * elements.formula.rows
        part = multipliers[offset : offset + size]
        offset += size
        if len(elements.formula.hessian_pattern[0]):
            row, column = elements.hessian_triplets()
            row_parts.append(row)
            column_parts.append(column)
            values.append(elements.call("hessian", x, part))
    for elements, weights in costs:
        row, column = elements.hessian_triplets()
        row_parts.append(row)
        column_parts.append(column)
        values.append(elements.call("hessian", x, factor * ca.DM(weights)))
    size = x.numel()
    if not values:
        hessian = ca.MX(size, size)
    else:
        key = np.concatenate(column_parts) * size + np.concatenate(row_parts)
        unique, position = np.unique(key, return_inverse=True)
        pattern = ca.Sparsity.triplet(size, size, (unique % size).tolist(), (unique // size).tolist())
        hessian = ca.MX(pattern, _sum_into(position, len(unique), ca.vertcat(*values)))
    return ca.Function(
        "nlp_hess_l", [x, p, factor, multipliers], [hessian], ["x", "p", "lam:f", "lam:g"], ["triu:hess:gamma:x:x"]
    )


def _sum_into(positions: IndexArray, size: int, values: Any) -> Any:
    """Return a column of `size` sums: value k is added at positions[k]."""
    selection = sparse.csc_matrix(
        (np.ones(len(positions)), (positions, np.arange(len(positions)))), shape=(size, len(positions))
    )
    return ca.mtimes(ca.DM(selection), values)
