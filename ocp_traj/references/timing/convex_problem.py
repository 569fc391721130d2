"""The convex timing problem, compiled once for its size and solved again with other numbers.

Verscheure et al. (2009), Eqs. 22 to 31: with x = sdot^2 at the grid points and constant sddot in every cell,

    minimise    sum_i D_i (d_i + e_i)
    subject to  c_i^2 <= y_i,   1 <= d_i p_i,   |k tau_i|^2 <= e_i p_i,   p_i = f_i c_i + (1 - f_i) c_(i+1),
                rows in (y_i, y_(i+1)),  y given at both ends,

where y_i = x_i / X_i, with a typical profile X that is small near rests (without it Clarabel stalls there),
D_i = 2 (s_(i+1) - s_i) / (sqrt X_i + sqrt X_(i+1)), f_i = sqrt X_i / (sqrt X_i + sqrt X_(i+1)), so that D_i d_i is the
time spent in cell i; k = sqrt(thermal weight) / tau_max. All numbers enter linearly (disciplined parametrised
programming).
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.deadline import NO_DEADLINE, Deadline
from ocp_traj.references.timing.clarabel_solver import best_backend, timing_solver


@dataclass(frozen=True)
class TimingNumbers:
    """Numbers of one timing problem with N cells, r rows and, with a thermal term, n torques.

    Attributes
    ----------
    times : (N,) array
        D_i.
    start_share : (N,) array
        f_i.
    by_start, by_end, bound : (N, r) arrays
        Rows by_start y_i + by_end y_(i+1) <= bound.
    end_y : (2,) array
    torque_start, torque_end, torque_constant : (N, n) arrays or None
        k tau at the middle of the cells is torque_start y_i + torque_end y_(i+1) + torque_constant.
    """

    times: Array
    start_share: Array
    by_start: Array
    by_end: Array
    bound: Array
    end_y: Array
    torque_start: Array | None = None
    torque_end: Array | None = None
    torque_constant: Array | None = None

    def given(self) -> dict[str, Array]:
        """Return the numbers that are there, by name."""
        return {name: value for name, value in vars(self).items() if value is not None}


@dataclass(frozen=True)
class TimingAnswer:
    """The solver's answer: status, y (N + 1,), objective and the rows' multipliers (N, r)."""

    status: str
    y: Array | None = None
    objective: float = np.inf
    multipliers: Array | None = None


class TimingProblem:
    """The problem as cvxpy sees it, over parameters: to be compiled once.

    Tables enter as lists of columns: that compiles ten times faster than the same rows as one matrix expression.
    """

    def __init__(self, shapes: tuple[tuple[str, tuple[int, ...]], ...]) -> None:
        cp: Any = import_module("cvxpy")  # its own annotations are incomplete

        self._parameters: dict[str, Any] = {
            name: [cp.Parameter(shape[0]) for _ in range(shape[1])]
            if len(shape) == 2
            else cp.Parameter(shape)
            for name, shape in shapes
        }
        numbers = self._parameters
        cells = numbers["times"].size
        self._y = y = cp.Variable(cells + 1)
        c, d = cp.Variable(cells + 1), cp.Variable(cells)
        pace = c[1:] + cp.multiply(numbers["start_share"], c[:-1] - c[1:])
        start, end, bounds = (numbers[name] for name in ("by_start", "by_end", "bound"))
        self._rows = [
            cp.multiply(start[k], y[:-1]) + cp.multiply(end[k], y[1:]) <= bounds[k]
            for k in range(len(bounds))
        ]
        constraints = [
            y[[0, cells]] == numbers["end_y"],
            *self._rows,
            cp.SOC(y + 1, cp.vstack([2 * c, y - 1])),
            cp.SOC(d + pace, cp.vstack([np.full(cells, 2.0), d - pace])),
        ]
        spent = d
        if "torque_constant" in numbers:
            e = cp.Variable(cells)
            start, end, constant = (numbers[f"torque_{part}"] for part in ("start", "end", "constant"))
            torque = [
                2 * (cp.multiply(start[k], y[:-1]) + cp.multiply(end[k], y[1:]) + constant[k])
                for k in range(len(constant))
            ]
            constraints.append(cp.SOC(e + pace, cp.vstack([*torque, e - pace])))
            spent = d + e
        self._problem = cp.Problem(cp.Minimize(numbers["times"] @ spent), constraints)

    def solve(self, given: dict[str, Array], deadline: Deadline = NO_DEADLINE) -> TimingAnswer:
        """Put in numbers and solve with Clarabel at its own settings; status as cvxpy names it."""
        cp: Any = import_module("cvxpy")  # its own annotations are incomplete

        for name, value in given.items():
            parameter = self._parameters[name]
            for entry, column in (
                zip(parameter, value.T) if isinstance(parameter, list) else [(parameter, value)]
            ):
                entry.value = column
        try:
            with warnings.catch_warnings():  # the status says it when the answer is inaccurate
                warnings.filterwarnings("ignore", message="Solution may be inaccurate")
                limited = {} if np.isinf(deadline.seconds) else {"time_limit": deadline.left}
                self._problem.solve(solver=timing_solver(), canon_backend=best_backend(), **limited)
        except cp.error.SolverError as error:
            return TimingAnswer(f"solver failed: {error}")
        status = str(self._problem.status)
        if self._y.value is None or status not in ("optimal", "optimal_inaccurate"):
            return TimingAnswer(status)
        y = np.maximum(np.asarray(self._y.value, dtype=np.float64), 0.0)
        y[[0, -1]] = given["end_y"]
        multipliers = np.stack([row.dual_value for row in self._rows], axis=1)
        return TimingAnswer(status, y, float(self._problem.value), multipliers)


@lru_cache(maxsize=8)
def _compiled(shapes: tuple[tuple[str, tuple[int, ...]], ...]) -> TimingProblem:
    return TimingProblem(shapes)


def solve_numbers(numbers: TimingNumbers, deadline: Deadline = NO_DEADLINE) -> TimingAnswer:
    """Solve the problem with these numbers; of equal sizes only the first is compiled."""
    given = numbers.given()
    return _compiled(tuple((name, value.shape) for name, value in given.items())).solve(given, deadline)
