"""What evaluates a small function for many points at once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError


class BatchProgram(ABC):
    """A function of column vectors, for many points.

    Attributes
    ----------
    rows_in, rows_out : tuple of int
        Rows of each argument and result.
    """

    rows_in: tuple[int, ...]
    rows_out: tuple[int, ...]

    @abstractmethod
    def run_columns(self, inputs: Sequence[Array], outputs: Sequence[Array]) -> None:
        """Write the outputs, each (rows, N), of inputs (rows, N), one point a column."""

    def __call__(self, *inputs: Array) -> tuple[Array, ...]:
        """Return the outputs, each (N, rows), of inputs (N, rows).

        Raises
        ------
        InputError
            The number or a shape of the inputs is wrong.
        """
        count = inputs[0].shape[0] if inputs else 0
        shapes = [array.shape for array in inputs]
        if shapes != [(count, rows) for rows in self.rows_in]:
            expected = ", ".join(f"(N, {rows})" for rows in self.rows_in)
            raise InputError(f"inputs have shapes {shapes}, expected {expected}")
        outputs = tuple(np.empty((rows, count)) for rows in self.rows_out)
        self.run_columns([np.ascontiguousarray(array.T, dtype=np.float64) for array in inputs], outputs)
        return tuple(np.ascontiguousarray(array.T) for array in outputs)
