"""Elements: one small function repeated over many places of a numerical problem.

A trajectory problem is the same few formulas at every segment, joint and sample. Each formula is differentiated
once, as a tiny symbolic function; the problem's sparse derivatives are then gathered from its mapped values. So
building a problem costs milliseconds however many segments it has.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from ocp_traj.arrays import Array
from ocp_traj.transcription.nlp import Symbol

IndexArray = npt.NDArray[np.int64]


class Places(ABC):
    """Values computed at N places of a problem, with their sparse derivatives.

    Attributes
    ----------
    count : int
        Number of places N.
    rows : int
        Values a place.
    """

    count: int
    rows: int

    @abstractmethod
    def call(self, what: str, x: Any, multipliers: Any = None) -> Any:
        """Return the ``value``, ``jacobian`` or ``hessian`` nonzeros as one MX column, place after place.

        Parameters
        ----------
        x : MX (d,)
        multipliers : MX (N * rows,), optional
            Weights of the values, for the Hessian.
        """

    @abstractmethod
    def jacobian_triplets(self) -> tuple[IndexArray, IndexArray]:
        """Rows (from 0 for these places) and columns of every Jacobian nonzero, in the order of `call`."""

    @abstractmethod
    def hessian_triplets(self) -> tuple[IndexArray, IndexArray]:
        """Rows and columns (row <= column) of every Hessian nonzero, in the order of `call`."""


@dataclass(frozen=True, eq=False)
class Formula:
    """A small function e(z, parameters) with its sparse Jacobian and the Hessian of its weighted sum.

    Parameters
    ----------
    name : str
    local : SX (nz,)
        Local variables z.
    parameters : SX
    value : SX (ne,)
    """

    name: str
    local: Any
    parameters: Any
    value: Any
    functions: dict[str, Any] = field(init=False, repr=False)
    jacobian_pattern: tuple[IndexArray, IndexArray] = field(init=False, repr=False)
    hessian_pattern: tuple[IndexArray, IndexArray] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        made = differentiate(self.name, ca.densify(self.value), [self.local, self.parameters])
        for name, value in zip(("functions", "jacobian_pattern", "hessian_pattern"), made):
            object.__setattr__(self, name, value)

    @property
    def rows(self) -> int:
        """Number of values ne."""
        return int(self.value.numel())


def differentiate(
    name: str, value: Symbol, arguments: list[Symbol]
) -> tuple[dict[str, Any], tuple[IndexArray, IndexArray], tuple[IndexArray, IndexArray]]:
    """Return functions of the arguments, and rows and columns of the nonzeros of their Jacobian and Hessian.

    Parameters
    ----------
    name : str
        What names of the functions begin with.
    value : SX (ne,), dense
    arguments : list of SX
        Derivatives are by the first one.

    Returns
    -------
    dict of ``value``, ``jacobian`` (nonzeros) and ``hessian`` (upper triangular nonzeros of the sum of values weighted
    by one more argument), and the two patterns.
    """
    jacobian = ca.jacobian(value, arguments[0])
    multipliers = ca.SX.sym("lambda", value.numel())
    hessian = ca.triu(ca.hessian(ca.dot(multipliers, value), arguments[0])[0])
    functions = {
        "value": ca.Function(f"{name}_value", arguments, [value]),
        "jacobian": ca.Function(f"{name}_jacobian", arguments, [nonzeros(jacobian)]),
        "hessian": ca.Function(f"{name}_hessian", [*arguments, multipliers], [nonzeros(hessian)]),
    }
    return functions, pattern(jacobian), pattern(hessian)


def nonzeros(matrix: Any) -> Any:
    """Return the nonzeros of an SX matrix as a column."""
    entries = matrix.nonzeros()
    return ca.vertcat(*entries) if entries else ca.SX(0, 1)


def pattern(matrix: Any) -> tuple[IndexArray, IndexArray]:
    """Return rows and columns of the nonzeros of an SX matrix."""
    rows, columns = matrix.sparsity().get_triplet()
    return np.array(rows, dtype=np.int64), np.array(columns, dtype=np.int64)


def gather(x: Any, indices: IndexArray) -> Any:
    """Return x at indices (N, k) as an MX of shape (k, N)."""
    return ca.reshape(x[indices.ravel().tolist()], indices.shape[1], indices.shape[0])


def apply_mapped(function: Any, count: int, *arguments: Any) -> Any:
    """Call a function once a column of its arguments."""
    return (function.map(count) if count > 1 else function)(*arguments)


def spread_triplets(
    variables: IndexArray, rows: int, jacobian: tuple[IndexArray, IndexArray]
) -> tuple[IndexArray, IndexArray]:
    """Return the Jacobian triplets of N places with local variables `variables` (N, nz)."""
    offsets = np.arange(len(variables))[:, None] * rows
    return (offsets + jacobian[0]).ravel(), variables[:, jacobian[1]].ravel()


def ordered_triplets(
    variables: IndexArray, hessian: tuple[IndexArray, IndexArray]
) -> tuple[IndexArray, IndexArray]:
    """Return the upper triangular Hessian triplets of N places with local variables `variables` (N, nz)."""
    first, second = variables[:, hessian[0]], variables[:, hessian[1]]
    return np.minimum(first, second).ravel(), np.maximum(first, second).ravel()


@dataclass(frozen=True, eq=False)
class Elements(Places):
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
        variables = np.asarray(self.variables, dtype=np.int64)
        parameters = np.asarray(self.parameters, dtype=np.float64).reshape(len(variables), -1)
        object.__setattr__(self, "variables", variables)
        object.__setattr__(self, "parameters", parameters)
        object.__setattr__(self, "count", len(variables))
        object.__setattr__(self, "rows", self.formula.rows)

    def call(self, what: str, x: Any, multipliers: Any = None) -> Any:
        """Return mapped values; see `Places.call`."""
        arguments = [gather(x, self.variables), ca.DM(self.parameters.T)]
        if multipliers is not None:
            arguments.append(ca.reshape(multipliers, self.rows, self.count))
        return ca.vec(apply_mapped(self.formula.functions[what], self.count, *arguments))

    def jacobian_triplets(self) -> tuple[IndexArray, IndexArray]:
        """See `Places.jacobian_triplets`."""
        return spread_triplets(self.variables, self.rows, self.formula.jacobian_pattern)

    def hessian_triplets(self) -> tuple[IndexArray, IndexArray]:
        """See `Places.hessian_triplets`."""
        return ordered_triplets(self.variables, self.formula.hessian_pattern)
