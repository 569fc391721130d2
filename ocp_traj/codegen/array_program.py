"""A CasADi function as straight-line NumPy: one ufunc call an instruction, over blocks of points.

Without a C compiler this is the fastest way to evaluate a small function for a whole population: the
function's instruction list is turned once into Python source of statements such as ``multiply(w3, x0[2], w3)``,
whose operands are rows of one work array, so a block stays in the processor's cache and nothing is allocated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.codegen.batch_program import BatchProgram
from ocp_traj.codegen.instructions import Listing, list_instructions

_LINE = 8
"""Doubles in a cache line: work rows start at a line and are no power of two apart."""


class ArrayProgram(BatchProgram):
    """Evaluate a CasADi SX function for many points with NumPy.

    Parameters
    ----------
    function : casadi.Function
        An SX function whose inputs and outputs are dense vectors.
    block : int
        Largest number of points evaluated at a time; blocks are of about equal size.

    Raises
    ------
    InputError
        The function holds an operation that has no NumPy counterpart here, or a sparse or matrix argument.
    """

    def __init__(self, function: ca.Function, block: int = 3072) -> None:
        listing = list_instructions(function)
        self.block = block
        self.rows_in, self.rows_out = listing.rows_in, listing.rows_out
        self._run, self.registers = _compile(listing)

    def run_columns(self, inputs: Sequence[Array], outputs: Sequence[Array]) -> None:
        """Write the outputs, each (rows, N), of inputs (rows, N): one point a column, nothing checked or copied."""
        count = outputs[0].shape[1]
        if not count:
            return
        blocks = -(-count // self.block)
        width = -(-count // blocks)
        work = _aligned_rows(self.registers, width)
        for start in range(0, count, width):
            part = slice(start, min(start + width, count))
            arguments = [array[:, part] for array in (*inputs, *outputs)]
            self._run(work[:, : part.stop - part.start], *arguments)


def _aligned_rows(rows: int, width: int) -> Array:
    """Return rows (rows, width) that start at cache lines: wide loads across two lines cost twice."""
    stride = (width // _LINE + 2) * _LINE
    stride += _LINE * (stride // _LINE % 2 == 0)
    memory = np.empty(rows * stride + _LINE)
    first = -(memory.ctypes.data // memory.itemsize) % _LINE
    return memory[first : first + rows * stride].reshape(rows, stride)[:, :width]


def _compile(listing: Listing) -> tuple[Callable[..., None], int]:
    """Return the program as a function of work rows, inputs and outputs, and the number of work rows."""
    scope: dict[str, Any] = {"copyto": np.copyto}
    lines: list[str] = []
    names: list[str] = []
    rows = _Rows(listing)
    for k, instruction in enumerate(listing.instructions):
        if instruction.operation == "input":
            argument, row = instruction.place
            names.append(f"x{argument}[{row}]")
        elif instruction.operation == "constant":
            names.append(f"c{k}")
            scope[names[k]] = np.array(instruction.number)
        else:
            scope[instruction.operation] = getattr(np, instruction.operation)
            operands = ", ".join(names[operand] for operand in instruction.operands)
            names.append(f"w{rows.take(k)}")
            lines.append(f"{instruction.operation}({operands}, out={names[k]})")
    lines += [f"copyto(y{result}[{row}], {names[value]})" for (result, row), value in listing.results]
    arguments = [f"x{i}" for i in range(len(listing.rows_in))] + [
        f"y{i}" for i in range(len(listing.rows_out))
    ]
    unpack = "".join(f"w{i}, " for i in range(rows.count)) + "= w" if rows.count else "pass"
    text = "\n    ".join([f"def run(w, {', '.join(arguments)}):", unpack, *lines])
    # The text holds ufunc names from a table, names of rows and numbers, nothing from outside.
    exec(compile(text, f"<{listing.name}>", "exec"), scope)  # noqa: S102
    program: Callable[..., None] = scope["run"]
    return program, rows.count


class _Rows:
    """Gives values work rows; the row freed last is used again first, since it is still in the nearest cache."""

    def __init__(self, listing: Listing) -> None:
        self.listing, self.count = listing, 0
        self._row: dict[int, int] = {}
        self._free: list[int] = []
        self._last = {value: k for k, entry in enumerate(listing.instructions) for value in entry.operands}
        self._last.update({value: len(listing.instructions) for _, value in listing.results})

    def take(self, k: int) -> int:
        """Return the row of value k; operands that are needed no more give theirs back first."""
        for operand in set(self.listing.instructions[k].operands):
            if self._last[operand] == k and operand in self._row:
                self._free.append(self._row.pop(operand))
        if not self._free:
            self._free.append(self.count)
            self.count += 1
        self._row[k] = self._free.pop()
        return self._row[k]
