"""Clarabel behind cvxpy, with the one step of cvxpy's compiling replaced that is slow with many parameters.

cvxpy brings the rows of second-order cones into the solver's order by a product of sparse matrices with one column
for every pair of a variable and a parameter: for 1000 cells that is a hundred million columns, two seconds and a
gigabyte. The step only moves rows and changes signs, so here cvxpy does it to the rows' numbers, once, and the
entries follow.
"""

from __future__ import annotations

import copy
from functools import lru_cache
from importlib import import_module
from types import SimpleNamespace
from typing import Any

import numpy as np


def best_backend() -> str:
    """Return cvxpy's compiler to use: the one for large parameters where cvxpy has it (1.8 and later)."""
    settings: Any = import_module("cvxpy.settings")
    return str(getattr(settings, "COO_CANON_BACKEND", settings.SCIPY_CANON_BACKEND))


@lru_cache(maxsize=1)
def timing_solver() -> Any:
    """Return the solver to be given to ``Problem.solve``; everything else is cvxpy's own interface to Clarabel."""
    clarabel: Any = import_module("cvxpy.reductions.solvers.conic_solvers.clarabel_conif").CLARABEL
    sparse: Any = import_module("scipy.sparse")

    class RowMovingClarabel(clarabel):  # type: ignore[misc]
        """Clarabel for problems with many parameters."""

        def name(self) -> str:
            """Return a name that none of cvxpy's own solvers has."""
            return "CLARABEL_BY_ROWS"

        @classmethod
        def format_constraints(cls, problem: Any, exp_cone_order: Any) -> Any:
            """Return the problem with the rows of its constraints in the solver's order.

            Column j of A holds, for parameter j, the coefficients of all variables one after the other, and the
            constants last.
            """
            rows = problem.A.shape[0] // (problem.x.size + 1)
            numbers = copy.copy(problem)
            numbers.x, numbers.P = SimpleNamespace(size=0), None
            numbers.A = sparse.csc_array(np.arange(1.0, rows + 1)[:, None])
            moved = super().format_constraints(numbers, exp_cone_order).A.tocoo()
            source = np.abs(moved.data).astype(np.int64) - 1
            target, sign = np.empty(rows, dtype=np.int64), np.empty(rows)
            target[source], sign[source] = moved.row, np.sign(moved.data)
            given = problem.A.tocoo()
            variable, row = np.divmod(given.row.astype(np.int64), rows)
            entries = (given.data * sign[row], (variable * rows + target[row], given.col))
            formatted = copy.copy(problem)
            formatted.A = sparse.coo_array(entries, shape=given.shape)
            formatted.reduced_A = type(problem.reduced_A)(formatted.A, problem.x.size)
            formatted.formatted = True
            return formatted

    return RowMovingClarabel()
