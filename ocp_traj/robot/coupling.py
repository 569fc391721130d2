"""Joints that follow others (mimic joints): every joint of the model from the joints of the task."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.arrays import Array, read_only
from ocp_traj.exceptions import RobotError


@dataclass(frozen=True, eq=False)
class Coupling:
    """The positions of the N joints of a model as affine functions of the n joints of a task.

    Parameters
    ----------
    joints : tuple of N str
        Names of the model's joints.
    matrix : (N, n)
        Velocity of every model joint per velocity of every task joint; a row has one entry.
    offset : (N,)
        Positions of the model's joints where the task's are zero, rad or m.

    Raises
    ------
    RobotError
        A shape is wrong or a number is not finite.
    """

    joints: tuple[str, ...]
    matrix: Array
    offset: Array

    def __post_init__(self) -> None:
        matrix, offset = read_only(self.matrix), read_only(self.offset)
        if matrix.ndim != 2 or len(matrix) != len(self.joints) or offset.shape != (len(self.joints),):
            raise RobotError(
                f"coupling of {len(self.joints)} joints has shapes {matrix.shape} and {offset.shape}, expected "
                "one row and one offset a joint"
            )
        if not (np.isfinite(matrix).all() and np.isfinite(offset).all()):
            raise RobotError("coupling has a number that is not finite")
        object.__setattr__(self, "matrix", matrix)
        object.__setattr__(self, "offset", offset)

    @property
    def n(self) -> int:
        """Number of joints of the task."""
        return int(self.matrix.shape[1])

    def positions(self, q: Array) -> Array:
        """Return the positions (..., N) of the model's joints at those of the task (..., n)."""
        return q @ self.matrix.T + self.offset

    def rates(self, v: Array) -> Array:
        """Return velocities or accelerations (..., N) of the model's joints from those of the task (..., n)."""
        return v @ self.matrix.T

    def torques(self, tau: Array) -> Array:
        """Return the torques (..., n) of the task's joints that do the work of the model's (..., N)."""
        return tau @ self.matrix

    def symbols(self, *columns: Any) -> tuple[Any, ...]:
        """Return CasADi columns q, v, a of the model's joints from those of the task; any number of them."""
        import casadi as ca

        matrix = ca.DM(self.matrix)
        rates = [ca.mtimes(matrix, column) for column in columns]
        return (rates[0] + ca.DM(self.offset), *rates[1:])
