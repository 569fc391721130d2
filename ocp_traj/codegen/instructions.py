"""The instruction list of a CasADi SX function, every value computed once and named by its own number."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from ocp_traj.exceptions import InputError

INPUT, CONSTANT = int(ca.OP_INPUT), int(ca.OP_CONST)

UNARY = {
    ca.OP_NEG: "negative", ca.OP_SQ: "square", ca.OP_SQRT: "sqrt", ca.OP_SIN: "sin", ca.OP_COS: "cos",
    ca.OP_TAN: "tan", ca.OP_EXP: "exp", ca.OP_LOG: "log", ca.OP_FABS: "absolute", ca.OP_SIGN: "sign",
    ca.OP_INV: "reciprocal", ca.OP_ASIN: "arcsin", ca.OP_ACOS: "arccos", ca.OP_ATAN: "arctan",
    ca.OP_TANH: "tanh", ca.OP_FLOOR: "floor", ca.OP_CEIL: "ceil", ca.OP_ASSIGN: "positive",
}  # fmt: skip
BINARY = {
    ca.OP_ADD: "add", ca.OP_SUB: "subtract", ca.OP_MUL: "multiply", ca.OP_DIV: "divide", ca.OP_FMIN:
    "minimum", ca.OP_FMAX: "maximum", ca.OP_ATAN2: "arctan2", ca.OP_POW: "power", ca.OP_CONSTPOW: "power",
    ca.OP_HYPOT: "hypot", ca.OP_LT: "less", ca.OP_LE: "less_equal", ca.OP_EQ: "equal", ca.OP_NE: "not_equal",
}  # fmt: skip
"""NumPy's names of the operations known here."""


@dataclass(frozen=True)
class Instruction:
    """One value: the operation by NumPy's name, and the numbers of the values it takes.

    ``input`` has `place` (argument, row), ``constant`` has `number`.
    """

    operation: str
    operands: tuple[int, ...] = ()
    place: tuple[int, int] = (0, 0)
    number: float = 0.0


@dataclass(frozen=True)
class Listing:
    """A function of dense column vectors as a list of values.

    Attributes
    ----------
    name : str
    rows_in, rows_out : tuple of int
        Rows of each argument and result.
    instructions : tuple of Instruction
        Value k is the result of instruction k.
    results : tuple of ((result, row), value)
    """

    name: str
    rows_in: tuple[int, ...]
    rows_out: tuple[int, ...]
    instructions: tuple[Instruction, ...]
    results: tuple[tuple[tuple[int, int], int], ...]


def list_instructions(function: ca.Function) -> Listing:
    """Return the values a function computes, in its own order.

    Raises
    ------
    InputError
        The function holds an operation that is not known here, or an argument or result is a matrix.
    """
    for kind, count, shape in (
        ("input", function.n_in(), function.size_in),
        ("output", function.n_out(), function.size_out),
    ):
        if any(shape(index)[1] != 1 for index in range(count)):
            raise InputError(f"{function.name()} has a matrix {kind}, expected column vectors")
    instructions: list[Instruction] = []
    results = []
    register: dict[int, int] = {}
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        source, target = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            results.append(((target[0], target[1]), register[source[0]]))
            continue
        if operation == CONSTANT:
            made = Instruction("constant", number=float(function.instruction_constant(k)))
        elif operation == INPUT:
            made = Instruction("input", place=(source[0], source[1]))
        else:
            made = _operation(function.name(), operation, [register[entry] for entry in source])
        register[target[0]] = len(instructions)
        instructions.append(made)
    return Listing(
        function.name(),
        tuple(function.size1_in(index) for index in range(function.n_in())),
        tuple(function.size1_out(index) for index in range(function.n_out())),
        tuple(instructions),
        tuple(results),
    )


def _operation(name: str, operation: int, operands: list[int]) -> Instruction:
    if operation == ca.OP_TWICE:
        return Instruction("add", (operands[0], operands[0]))
    if operation in UNARY:
        return Instruction(UNARY[operation], (operands[0],))
    if operation in BINARY:
        return Instruction(BINARY[operation], (operands[0], operands[1]))
    raise InputError(f"function {name!r} holds CasADi operation number {operation}, which is not supported")
