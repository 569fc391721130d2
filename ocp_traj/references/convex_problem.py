"""The convex timing problem, compiled once for its size and solved again with other numbers.

Verscheure et al. (2009), Eqs. 22 to 31: with x = sdot^2 at the grid points and constant sddot in every cell,

    minimise    sum_i (d_i + e_i) / N
    subject to  c_i^2 <= x_i,   w_i <= d_i (c_i + c_(i+1)),   w_i |k tau_i|^2 <= e_i (c_i + c_(i+1)),
                rows in (x_i, x_(i+1)),  x given at both ends,

where w_i = 2 N (s_(i+1) - s_i), so that d_i / N is the time spent in cell i, and k = sqrt(thermal weight) / tau_max.
All numbers enter linearly (disciplined parametrised programming).
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np

from ocp_traj.arrays import Array

LARGEST_PARAMETRISED = 1200
"""Cells up to which the problem is compiled with parameters: cvxpy's cost of that grows with the cells' square."""


@dataclass(frozen=True)
class TimingNumbers:
    """Numbers of one timing problem with N cells, r rows and, with a thermal term, n torques.

    Attributes
    ----------
    root_weights : (N,) array
        sqrt(w_i).
    by_start, by_end, bound : (N, r) arrays
        Rows by_start x_i + by_end x_(i+1) <= bound.
    end_x : (2,) array
    torque_start, torque_end, torque_constant : (N, n) arrays or None
        sqrt(w_i) k tau at the middle of the cells is torque_start x_i + torque_end x_(i+1) + torque_constant.
    """

    root_weights: Array
    by_start: Array
    by_end: Array
    bound: Array
    end_x: Array
    torque_start: Array | None = None
    torque_end: Array | None = None
    torque_constant: Array | None = None

    def given(self) -> dict[str, Array]:
        """Return the numbers that are there, by name."""
        return {name: value for name, value in vars(self).items() if value is not None}


@dataclass(frozen=True)
class TimingAnswer:
    """The solver's answer: status, x (N + 1,), objective and the rows' multipliers (N, r)."""

    status: str
    x: Array | None = None
    objective: float = np.inf
    multipliers: Array | None = None


class TimingProblem:
    """The problem as cvxpy sees it, over parameters (to be compiled once) or over constants.

    Tables enter as lists of columns: that compiles ten times faster than the same rows as one matrix expression.
    """

    def __init__(self, numbers: dict[str, Any]) -> None:
        cp: Any = import_module("cvxpy")  # its own annotations are incomplete

        bounds = numbers["bound"]
        cells = numbers["root_weights"].size
        self._x = x = cp.Variable(cells + 1)
        c, d = cp.Variable(cells + 1), cp.Variable(cells)
        pace = c[:-1] + c[1:]
        start, end = numbers["by_start"], numbers["by_end"]
        self._rows = [
            cp.multiply(start[k], x[:-1]) + cp.multiply(end[k], x[1:]) <= bounds[k]
            for k in range(len(bounds))
        ]
        constraints = [
            x[[0, cells]] == numbers["end_x"],
            *self._rows,
            cp.SOC(x + 1, cp.vstack([2 * c, x - 1])),
            cp.SOC(d + pace, cp.vstack([2 * numbers["root_weights"], d - pace])),
        ]
        objective = cp.sum(d) / cells
        if "torque_constant" in numbers:
            e = cp.Variable(cells)
            start, end, constant = (numbers[f"torque_{part}"] for part in ("start", "end", "constant"))
            torque = [
                2 * (cp.multiply(start[k], x[:-1]) + cp.multiply(end[k], x[1:]) + constant[k])
                for k in range(len(constant))
            ]
            constraints.append(cp.SOC(e + pace, cp.vstack([*torque, e - pace])))
            objective = objective + cp.sum(e) / cells
        self._problem = cp.Problem(cp.Minimize(objective), constraints)

    def solve(self, end_x: Array) -> TimingAnswer:
        """Solve with Clarabel at its own settings; status as cvxpy names it."""
        cp: Any = import_module("cvxpy")  # its own annotations are incomplete

        try:
            with warnings.catch_warnings():  # the status says it when the answer is inaccurate
                warnings.filterwarnings("ignore", message="Solution may be inaccurate")
                self._problem.solve(solver=cp.CLARABEL, canon_backend="COO")
        except cp.error.SolverError as error:
            return TimingAnswer(f"solver failed: {error}")
        status = str(self._problem.status)
        if self._x.value is None or status not in ("optimal", "optimal_inaccurate"):
            return TimingAnswer(status)
        x = np.maximum(np.asarray(self._x.value, dtype=np.float64), 0.0)
        x[[0, -1]] = end_x
        multipliers = np.stack([row.dual_value for row in self._rows], axis=1)
        return TimingAnswer(status, x, float(self._problem.value), multipliers)


class _ParametrisedProblem:
    """A compiled problem and its parameters."""

    def __init__(self, shapes: tuple[tuple[str, tuple[int, ...]], ...]) -> None:
        cp: Any = import_module("cvxpy")  # its own annotations are incomplete

        self.parameters = {
            name: [cp.Parameter(shape[0]) for _ in range(shape[1])]
            if len(shape) == 2
            else cp.Parameter(shape)
            for name, shape in shapes
        }
        self.problem = TimingProblem(self.parameters)

    def solve(self, given: dict[str, Array]) -> TimingAnswer:
        """Put in numbers and solve."""
        for name, value in given.items():
            parameter = self.parameters[name]
            if isinstance(parameter, list):
                for column, entry in zip(value.T, parameter):
                    entry.value = column
            else:
                parameter.value = value
        return self.problem.solve(given["end_x"])


@lru_cache(maxsize=8)
def _compiled(shapes: tuple[tuple[str, tuple[int, ...]], ...]) -> _ParametrisedProblem:
    return _ParametrisedProblem(shapes)


def solve_numbers(numbers: TimingNumbers) -> TimingAnswer:
    """Solve the problem with these numbers; of equal sizes only the first is compiled."""
    given = numbers.given()
    if len(numbers.root_weights) > LARGEST_PARAMETRISED:
        columns: dict[str, Any] = {
            name: list(value.T) if value.ndim == 2 else value for name, value in given.items()
        }
        return TimingProblem(columns).solve(numbers.end_x)
    return _compiled(tuple((name, value.shape) for name, value in given.items())).solve(given)
