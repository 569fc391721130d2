"""A CasADi function as straight-line NumPy: one ufunc call an instruction, over blocks of points.

Without a C compiler this is the fastest way to evaluate a small function for a whole population: the
function's instruction list is turned once into Python source of statements such as ``multiply(w3, w7, w3)``,
whose operands are rows of one work array, so a block stays in the processor's cache and nothing is allocated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError

_UNARY = {
    ca.OP_NEG: "negative", ca.OP_SQ: "square", ca.OP_SQRT: "sqrt", ca.OP_SIN: "sin", ca.OP_COS: "cos",
    ca.OP_TAN: "tan", ca.OP_EXP: "exp", ca.OP_LOG: "log", ca.OP_FABS: "absolute", ca.OP_SIGN: "sign",
    ca.OP_INV: "reciprocal", ca.OP_ASIN: "arcsin", ca.OP_ACOS: "arccos", ca.OP_ATAN: "arctan",
    ca.OP_TANH: "tanh", ca.OP_FLOOR: "floor", ca.OP_CEIL: "ceil",
}  # fmt: skip
_BINARY = {
    ca.OP_ADD: "add", ca.OP_SUB: "subtract", ca.OP_MUL: "multiply", ca.OP_DIV: "divide", ca.OP_FMIN:
    "minimum", ca.OP_FMAX: "maximum", ca.OP_ATAN2: "arctan2", ca.OP_POW: "power", ca.OP_CONSTPOW: "power",
    ca.OP_HYPOT: "hypot", ca.OP_LT: "less", ca.OP_LE: "less_equal", ca.OP_EQ: "equal", ca.OP_NE: "not_equal",
}  # fmt: skip


class ArrayProgram:
    """Evaluate a CasADi SX function for many points with NumPy.

    Parameters
    ----------
    function : casadi.Function
        An SX function whose inputs and outputs are dense vectors.
    block : int
        Points evaluated at a time.

    Raises
    ------
    InputError
        The function holds an operation that has no NumPy counterpart here, or a sparse or matrix argument.
    """

    def __init__(self, function: ca.Function, block: int = 2048) -> None:
        for kind, shapes in (("input", function.size_in), ("output", function.size_out)):
            count = function.n_in() if kind == "input" else function.n_out()
            if any(shapes(index)[1] != 1 for index in range(count)):
                raise InputError(f"{function.name()} has a matrix {kind}, expected column vectors")
        self.block = block
        self.rows_in = [function.size1_in(index) for index in range(function.n_in())]
        self.rows_out = [function.size1_out(index) for index in range(function.n_out())]
        self.registers = function.sz_w()
        self._run = self._compile(function)

    def _compile(self, function: ca.Function) -> Callable[..., None]:
        constants: dict[int, str] = {}
        used = {"copyto"}
        lines: list[str] = []
        for k in range(function.n_instructions()):
            operation = function.instruction_id(k)
            source, target = function.instruction_input(k), function.instruction_output(k)
            if operation == ca.OP_OUTPUT:
                value = constants.get(source[0], f"w{source[0]}")
                lines.append(f"copyto(y{target[0]}[{target[1]}], {value})")
                continue
            if operation == ca.OP_CONST:
                constants[target[0]] = repr(float(function.instruction_constant(k)))
                continue
            if operation == ca.OP_INPUT:
                lines.append(f"copyto(w{target[0]}, x{source[0]}[{source[1]}])")
            else:
                lines.append(_statement(function.name(), operation, source, target[0], constants, used))
            constants.pop(target[0], None)
        arguments = [f"x{i}" for i in range(function.n_in())] + [f"y{i}" for i in range(function.n_out())]
        names = [f"w{i}" for i in range(self.registers)]
        unpack = f"{', '.join(names)}, = w" if names else "pass"
        text = "\n    ".join([f"def run(w, {', '.join(arguments)}):", unpack, *lines])
        scope: dict[str, Callable[..., None]] = {name: getattr(np, name) for name in used}
        # The text holds ufunc names from the tables above, register names and numbers, nothing from outside.
        exec(compile(text, f"<{function.name()}>", "exec"), scope)  # noqa: S102
        return scope["run"]

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
        self.run_columns([array.T for array in inputs], outputs)
        return tuple(np.ascontiguousarray(array.T) for array in outputs)

    def run_columns(self, inputs: Sequence[Array], outputs: Sequence[Array]) -> None:
        """Write the outputs, each (rows, N), of inputs (rows, N): one point a column, nothing checked or copied."""
        count = outputs[0].shape[1]
        work = np.empty((self.registers, min(self.block, count)))
        for start in range(0, count, self.block):
            part = slice(start, min(start + self.block, count))
            arguments = [array[:, part] for array in (*inputs, *outputs)]
            self._run(work[:, : part.stop - part.start], *arguments)


def _statement(
    name: str, operation: int, source: list[int], target: int, constants: dict[int, str], used: set[str]
) -> str:
    """Return the NumPy statement of one instruction."""
    operands = [constants.get(register, f"w{register}") for register in source]
    if operation == ca.OP_ASSIGN:
        return f"copyto(w{target}, {operands[0]})"
    if operation == ca.OP_TWICE:
        used.add("add")
        return f"add({operands[0]}, {operands[0]}, w{target})"
    ufunc = _UNARY.get(operation) or _BINARY.get(operation)
    if ufunc is None:
        raise InputError(
            f"function {name!r} holds CasADi operation number {operation}, which is not supported"
        )
    used.add(ufunc)
    if ufunc in ("minimum", "maximum"):  # these two take their output by keyword only
        return f"{ufunc}({operands[0]}, {operands[1]}, out=w{target})"
    return f"{ufunc}({', '.join(operands[: 1 if operation in _UNARY else 2])}, w{target})"
