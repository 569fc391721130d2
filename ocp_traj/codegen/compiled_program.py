"""A CasADi function as machine code that evaluates eight points at a time.

The function's instruction list is written as C over vectors of eight doubles (GCC's and Clang's vector extension),
once for every width of vector the processor may have; the widest one there is runs. A point's operations are those of
the interpreter in the same order, so the results are equal to the last bit.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.codegen.batch_program import BatchProgram
from ocp_traj.codegen.compiled import build_library
from ocp_traj.codegen.instructions import Listing, list_instructions
from ocp_traj.exceptions import InputError, UnavailableError

_OPERATORS = {
    "add": "{0} + {1}", "subtract": "{0} - {1}", "multiply": "{0} * {1}", "divide": "{0} / {1}",
    "negative": "-{0}", "square": "{0} * {0}", "reciprocal": "1.0 / {0}", "positive": "{0}",
}  # fmt: skip
_LANES = {
    "sqrt": "sqrt({0})", "tan": "tan({0})", "exp": "exp({0})", "log": "log({0})", "absolute": "fabs({0})",
    "arcsin": "asin({0})", "arccos": "acos({0})", "arctan": "atan({0})", "tanh": "tanh({0})",
    "floor": "floor({0})", "ceil": "ceil({0})", "sign": "{0} < 0 ? -1.0 : {0} > 0 ? 1.0 : {0}",
    "minimum": "fmin({0}, {1})", "maximum": "fmax({0}, {1})", "arctan2": "atan2({0}, {1})",
    "power": "pow({0}, {1})", "hypot": "hypot({0}, {1})", "less": "{0} < {1}", "less_equal": "{0} <= {1}",
    "equal": "{0} == {1}", "not_equal": "{0} != {1}",
}  # fmt: skip
"""Operations on whole vectors, and those done lane by lane."""

_HEAD = """
#include <math.h>
#include <string.h>
#define LANES 8
typedef double V __attribute__((vector_size(8 * LANES)));
"""

# Compilers make one call of a sine and a cosine of the same number, which costs little more than one of them.
_SINE_AND_COSINE = """V sin{k}, cos{k};
for (int l = 0; l < LANES; ++l) {{ const double t = {angle}[l]; sin{k}[l] = sin(t); cos{k}[l] = cos(t); }}"""

# A rest of less than eight points is run in a padded copy.
_DRIVER = """
typedef void (*kernel)(const double* const*, double* const*);

static kernel widest(void) {{
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f")) return run_avx512;
  if (__builtin_cpu_supports("avx2")) return run_avx2;
#endif
  return run_plain;
}}

int evaluate_columns(long count, const double** inputs, double** outputs, const long* strides) {{
  const double* x[{rows_in} + 1];
  double* y[{rows_out} + 1];
  double padded_x[{rows_in} + 1][LANES], padded_y[{rows_out} + 1][LANES];
  static const long in[] = {{{sizes_in}}}, out[] = {{{sizes_out}}};
  const kernel run = widest();
  long i, k, row, j;
  for (i = 0; i < count; i += LANES) {{
    const long points = count - i < LANES ? count - i : LANES;
    for (j = 0, k = 0; k < {n_in}; ++k)
      for (row = 0; row < in[k]; ++row, ++j) {{
        x[j] = inputs[k] + row * strides[k] + i;
        if (points == LANES) continue;
        memset(padded_x[j], 0, sizeof padded_x[j]);
        memcpy(padded_x[j], x[j], points * sizeof(double));
        x[j] = padded_x[j];
      }}
    for (j = 0, k = 0; k < {n_out}; ++k)
      for (row = 0; row < out[k]; ++row, ++j)
        y[j] = points == LANES ? outputs[k] + row * strides[{n_in} + k] + i : padded_y[j];
    run(x, y);
    if (points == LANES) continue;
    for (j = 0, k = 0; k < {n_out}; ++k)
      for (row = 0; row < out[k]; ++row, ++j)
        memcpy(outputs[k] + row * strides[{n_in} + k] + i, padded_y[j], points * sizeof(double));
  }}
  return 0;
}}
"""


class CompiledProgram(BatchProgram):
    """Evaluate a CasADi function for many points with machine code.

    Parameters
    ----------
    function : casadi.Function
        An SX function whose inputs and outputs are dense column vectors.

    Raises
    ------
    InputError
        The function holds an operation that is not known here, or a matrix argument.
    UnavailableError
        There is no compiler, or it failed.
    """

    def __init__(self, function: ca.Function) -> None:
        listing = list_instructions(function)
        self.rows_in, self.rows_out = listing.rows_in, listing.rows_out
        path = build_library(source_text(listing), optimize=1)
        try:
            library = ctypes.CDLL(str(path))
        except OSError as error:
            raise UnavailableError(f"the compiled library {path} cannot be loaded: {error}") from error
        self._evaluate = library.evaluate_columns
        self._evaluate.argtypes = [ctypes.c_long, *[ctypes.c_void_p] * 3]

    def run_columns(self, inputs: Sequence[Array], outputs: Sequence[Array]) -> None:
        """Write the outputs, each (rows, N), of inputs (rows, N), one point a column.

        Raises
        ------
        InputError
            A row is not contiguous doubles.
        """
        arrays = (*inputs, *outputs)
        count = outputs[0].shape[1]
        # The step along a row says nothing where a row has one entry.
        if any(array.dtype != np.float64 or (count > 1 and array.strides[1] != 8) for array in arrays):
            raise InputError(
                "the arrays of columns have rows that are not contiguous doubles, expected such rows"
            )
        strides = (ctypes.c_long * len(arrays))(*(array.strides[0] // array.itemsize for array in arrays))
        self._evaluate(count, _addresses(inputs), _addresses(outputs), strides)


def _addresses(arrays: Sequence[Array]) -> ctypes.Array[ctypes.c_void_p]:
    return (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))


def source_text(listing: Listing) -> str:
    """Return the C text that evaluates a function eight points at a time."""
    body = _body(listing)
    kernels = [
        _kernel("plain", "", body),
        "#if defined(__x86_64__)",
        _kernel("avx2", '__attribute__((target("avx2")))', body),
        _kernel("avx512", '__attribute__((target("avx512f")))', body),
        "#endif",
    ]
    driver = _DRIVER.format(
        rows_in=sum(listing.rows_in),
        rows_out=sum(listing.rows_out),
        sizes_in=", ".join(map(str, [*listing.rows_in, 0])),
        sizes_out=", ".join(map(str, [*listing.rows_out, 0])),
        n_in=len(listing.rows_in),
        n_out=len(listing.rows_out),
    )
    return "\n".join([_HEAD, *kernels, driver])


def _kernel(name: str, target: str, body: str) -> str:
    return f"{target} static void run_{name}(const double* const* x, double* const* y) {{\n{body}\n}}"


def _body(listing: Listing) -> str:
    """Return the statements of one pass, every value in a variable of its own."""
    first_in, first_out = (np.cumsum([0, *rows]) for rows in (listing.rows_in, listing.rows_out))
    lines: list[str] = []
    names: list[str] = []
    turned: dict[int, int] = {}
    for k, instruction in enumerate(listing.instructions):
        names.append(f"v{k}")
        if instruction.operation == "input":
            argument, row = instruction.place
            lines.append(f"V v{k}; memcpy(&v{k}, x[{first_in[argument] + row}], sizeof(V));")
        elif instruction.operation == "constant":
            lines.append(f"const V v{k} = {instruction.number.hex()} - (V){{}};")
        elif instruction.operation in ("sin", "cos"):
            (angle,) = instruction.operands
            if angle not in turned:
                turned[angle] = k
                lines.append(_SINE_AND_COSINE.format(k=k, angle=names[angle]))
            names[k] = f"{instruction.operation}{turned[angle]}"
        else:
            operands = [names[operand] for operand in instruction.operands]
            lines.append(_statement(instruction.operation, operands, names[k]))
    for (result, row), value in listing.results:
        lines.append(f"memcpy(y[{first_out[result] + row}], &{names[value]}, sizeof(V));")
    return "\n".join(lines)


def _statement(operation: str, operands: list[str], name: str) -> str:
    if operation in _OPERATORS:
        return f"const V {name} = {_OPERATORS[operation].format(*operands)};"
    each = _LANES[operation].format(*(f"{operand}[l]" for operand in operands))
    return f"V {name}; for (int l = 0; l < LANES; ++l) {name}[l] = {each};"
