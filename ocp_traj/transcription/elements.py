"""Elements: one small function repeated over many places of a numerical problem.

A trajectory problem is the same few formulas at every segment, joint and sample. Each formula is differentiated
once, as a tiny symbolic function; the problem's sparse derivatives are then gathered from its mapped values. So
building a problem costs milliseconds however many segments it has.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from ocp_traj.arrays import Array

IndexArray = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Formula:
    """A small function e(z, parameters) with its sparse Jacobian and the Hessian of its weighted sum.

    Parameters
    ----------
    name : str
    local : SX (nz,)
        Local variables z.
    parameters : SX
    value : SX (ne,)
    jacobian : SX (ne, nz), optional
        Left out, it is differentiated here; given where its structure is known better.
    hessian : tuple of (SX multipliers (ne,), SX (nz, nz)), optional
        Hessian of multipliers' value; left out, it is differentiated here.
    """

    name: str
    local: Any
    parameters: Any
    value: Any
    jacobian: Any = None
    hessian: Any = None
    functions: dict[str, Any] = field(init=False, repr=False)
    jacobian_pattern: tuple[IndexArray, IndexArray] = field(init=False, repr=False)
    hessian_pattern: tuple[IndexArray, IndexArray] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        value = ca.densify(self.value)
        jacobian = ca.jacobian(value, self.local) if self.jacobian is None else self.jacobian
        if self.hessian is None:
            multipliers = ca.SX.sym("lambda", value.numel())
            hessian = ca.hessian(ca.dot(multipliers, value), self.local)[0]
        else:
            multipliers, hessian = self.hessian
        hessian = ca.triu(hessian)
        arguments = [self.local, self.parameters]
        functions = {
            "value": ca.Function(f"{self.name}_value", arguments, [value]),
            "jacobian": ca.Function(f"{self.name}_jacobian", arguments, [_nonzeros(jacobian)]),
            "hessian": ca.Function(f"{self.name}_hessian", [*arguments, multipliers], [_nonzeros(hessian)]),
        }
        object.__setattr__(self, "functions", functions)
        object.__setattr__(self, "jacobian_pattern", _pattern(jacobian))
        object.__setattr__(self, "hessian_pattern", _pattern(hessian))

    @property
    def rows(self) -> int:
        """Number of values ne."""
        return int(self.value.numel())


def _nonzeros(matrix: Any) -> Any:
    nonzeros = matrix.nonzeros()
    return ca.vertcat(*nonzeros) if nonzeros else ca.SX(0, 1)


def _pattern(matrix: Any) -> tuple[IndexArray, IndexArray]:
    rows, columns = matrix.sparsity().get_triplet()
    return np.array(rows, dtype=np.int64), np.array(columns, dtype=np.int64)


@dataclass(frozen=True)
class Elements:
    """One formula at N places.

    Parameters
    ----------
    formula : Formula
    variables : (N, nz) indices of the local variables among the problem's
    parameters : (N, number of parameters)
    """

    formula: Formula
    variables: IndexArray
    parameters: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "variables", np.asarray(self.variables, dtype=np.int64))
        object.__setattr__(
            self, "parameters", np.asarray(self.parameters, dtype=np.float64).reshape(len(self.variables), -1)
        )

    @property
    def count(self) -> int:
        """Number of places N."""
        return len(self.variables)

    def call(self, what: str, x: Any, multipliers: Any = None) -> Any:
        """Return the mapped ``value``, ``jacobian`` or ``hessian`` nonzeros as one column, place after place."""
        gathered = ca.reshape(x[self.variables.ravel().tolist()], self.variables.shape[1], self.count)
        arguments = [gathered, ca.DM(self.parameters.T)]
        if multipliers is not None:
            arguments.append(ca.reshape(multipliers, self.formula.rows, self.count))
        function = self.formula.functions[what]
        return ca.vec((function.map(self.count) if self.count > 1 else function)(*arguments))

    def jacobian_triplets(self) -> tuple[IndexArray, IndexArray]:
        """Rows (from 0 for this set) and columns of every Jacobian nonzero, in the order of `call`."""
        rows, columns = self.formula.jacobian_pattern
        offsets = np.arange(self.count)[:, None] * self.formula.rows
        return (offsets + rows).ravel(), self.variables[:, columns].ravel()

    def hessian_triplets(self) -> tuple[IndexArray, IndexArray]:
        """Rows and columns (row <= column) of every Hessian nonzero, in the order of `call`."""
        rows, columns = self.formula.hessian_pattern
        first, second = self.variables[:, rows], self.variables[:, columns]
        return np.minimum(first, second).ravel(), np.maximum(first, second).ravel()
