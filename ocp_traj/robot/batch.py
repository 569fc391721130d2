"""A robot's torques at many states at once: the fast way, for populations and samples."""

from __future__ import annotations

import logging
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.arrays import Array, ArrayLike
from ocp_traj.exceptions import RobotError, UnavailableError
from ocp_traj.robot.symbolic import SymbolicRobot

if TYPE_CHECKING:
    from ocp_traj.codegen.batch_program import BatchProgram

logger = logging.getLogger(__name__)


class BatchRobot:
    """Inverse dynamics as machine code where there is a C compiler, else its operations over NumPy arrays.

    Both equal CasADi's interpreter to the last bit where NumPy's sine and cosine do. `Robot.batch` makes it.

    Parameters
    ----------
    symbolic : SymbolicRobot
        The same robot's functions.
    """

    def __init__(self, symbolic: SymbolicRobot) -> None:
        self._symbolic = symbolic

    def torque(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Return the torques (N, n) of many states, N m.

        Raises
        ------
        RobotError
            The robot has no link masses, or a shape is wrong.
        """
        return self._program(*state_rows(self._symbolic.n, q, v, a))[0]

    def torque_columns(self, q: Array, v: Array, a: Array, out: Array) -> None:
        """Write the torques of many states, one per column: `torque` without transposing.

        Parameters
        ----------
        q, v, a, out : (n, N)
            Arrays of doubles whose rows are contiguous.

        Raises
        ------
        RobotError
            The robot has no link masses.
        """
        self._program.run_columns((q, v, a), (out,))

    @cached_property
    def _program(self) -> BatchProgram:
        from ocp_traj.codegen.array_program import ArrayProgram
        from ocp_traj.codegen.compiled import find_compiler
        from ocp_traj.codegen.compiled_program import CompiledProgram

        function = self._symbolic.inverse_dynamics
        if find_compiler() is None:
            return ArrayProgram(function)
        try:
            return CompiledProgram(function)
        except UnavailableError as error:
            name = self._symbolic.name
            logger.warning("inverse dynamics of %s run in NumPy, not compiled: %s", name, error)
            return ArrayProgram(function)


def state_rows(n: int, *arrays: ArrayLike) -> tuple[Array, ...]:
    """Return q, v, a as rows (N, n) of doubles.

    Raises
    ------
    RobotError
        A shape is wrong.
    """
    rows = tuple(np.atleast_2d(np.asarray(array, dtype=np.float64)) for array in arrays)
    for array in rows:
        if array.shape != rows[0].shape or array.ndim != 2 or array.shape[1] != n:
            shapes = ", ".join(str(item.shape) for item in rows)
            raise RobotError(f"q, v, a have shapes {shapes}, expected (N, {n}) each")
    return rows
