"""CasADi functions as machine code: generated as C, compiled once by the system's compiler, kept on disk.

The library of a function is kept in the user's cache folder under the hash of its C text, of the compiler and
of the versions involved. The folder belongs to the user alone (mode 0700), a record beside each library holds
the library's own SHA-256, and nothing is loaded that does not match it. Files appear by atomic renaming, so
processes may share the folder. Without a compiler, or with ``OCP_TRAJ_NO_COMPILER=1``, the interpreter is
used, with the same results.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import logging
import os
import shutil
import stat
import subprocess
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np

from ocp_traj import __version__
from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError, UnavailableError

NO_COMPILER_VARIABLE = "OCP_TRAJ_NO_COMPILER"
"""Set it to 1 to use the interpreter always."""

CACHE_VARIABLE = "OCP_TRAJ_CACHE"
"""Folder to be used instead of the user's cache folder."""

# No contraction into fused multiply-adds: the compiled function then rounds exactly as the interpreter does.
_FLAGS = ("-ffp-contract=off", "-fPIC", "-shared", "-w")

logger = logging.getLogger(__name__)


@cache
def _find_compiler(chosen: str | None, search_path: str | None) -> tuple[str, str] | None:
    """Return path and version line of the C compiler, or None."""
    for name in [chosen] if chosen else ["cc", "gcc", "clang"]:
        path = shutil.which(name, path=search_path)
        if path is None:
            continue
        done = subprocess.run([path, "--version"], capture_output=True, text=True, check=False)
        if done.returncode == 0 and done.stdout:
            return path, done.stdout.splitlines()[0]
    return None


def find_compiler() -> tuple[str, str] | None:
    """Return path and version of the C compiler (``CC``, else cc, gcc or clang), None without one."""
    if os.name != "posix" or os.environ.get(NO_COMPILER_VARIABLE, "") not in ("", "0"):
        return None
    return _find_compiler(os.environ.get("CC"), os.environ.get("PATH"))


def cache_folder() -> Path:
    """Return the folder of compiled functions, created with mode 0700 if it is not there.

    Raises
    ------
    UnavailableError
        The folder cannot be made, belongs to somebody else, or others may write to it.
    """
    import platformdirs

    chosen = os.environ.get(CACHE_VARIABLE)
    folder = Path(chosen) if chosen else Path(platformdirs.user_cache_dir("ocp-traj"))
    folder = folder / "compiled"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = folder.lstat()
    except OSError as error:
        raise UnavailableError(f"cache folder {folder} cannot be used: {error}") from error
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid():
        raise UnavailableError(f"cache folder {folder} is not a folder owned by this user")
    if stat.S_IMODE(status.st_mode) & 0o077:
        raise UnavailableError(
            f"cache folder {folder} has mode {stat.S_IMODE(status.st_mode):o}, expected 700"
        )
    return folder


def _sources(functions: Sequence[ca.Function], driver: str) -> str:
    generator = ca.CodeGenerator("functions.c", {"with_header": False})
    for function in functions:
        generator.add(function)
    text: str = generator.dump()
    return text + driver


def _library(text: str, optimize: int) -> Path:
    """Return the compiled library of a C text, from the cache where it is there.

    Raises
    ------
    UnavailableError
        There is no compiler, the cache folder cannot be used, or the compiler failed.
    """
    compiler = find_compiler()
    if compiler is None:
        raise UnavailableError("no C compiler is there, or its use is switched off")
    folder = cache_folder()
    flags = (f"-O{optimize}", *_FLAGS)
    parts = [text, *compiler, *flags, __version__, ca.CasadiMeta.version()]
    key = hashlib.sha256("\0".join(parts).encode()).hexdigest()
    record = folder / f"{key}.json"
    kept = _verified(folder, record)
    if kept is not None:
        return kept
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        source, built = Path(scratch) / "functions.c", Path(scratch) / "functions.so"
        source.write_text(text)
        command = [compiler[0], *flags, str(source), "-o", str(built), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise UnavailableError(
                f"{compiler[0]} failed with status {done.returncode}: {done.stderr[-500:]}"
            )
        digest = hashlib.sha256(built.read_bytes()).hexdigest()
        # The digest is part of the name: two processes that compile at once never mix library and record.
        library = folder / f"{key[:16]}-{digest[:16]}.so"
        os.replace(built, library)
        note = Path(scratch) / "record.json"
        note.write_text(json.dumps({"library": library.name, "sha256": digest}))
        os.replace(note, record)
    return library


def _verified(folder: Path, record: Path) -> Path | None:
    """Return the library a record names if its content is what the record says, else None."""
    try:
        entry = json.loads(record.read_text())
        library = folder / Path(entry["library"]).name
        content = library.read_bytes()
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError) as error:
        logger.warning(
            "record %s in the cache of compiled functions is unreadable (%s), compiling anew", record, error
        )
        return None
    if hashlib.sha256(content).hexdigest() != entry.get("sha256"):
        logger.warning("library %s does not match its record, compiling anew", library)
        return None
    return library


def _with_derivatives(function: ca.Function, derivatives: int) -> list[ca.Function]:
    """Return the function and those CasADi looks for beside it, up to a Hessian's needs."""
    functions = [function]
    if derivatives >= 1:
        functions.append(function.jacobian())
    if derivatives >= 2:
        adjoint = function.reverse(1)
        functions += [function.forward(1), adjoint, adjoint.jacobian()]
    return functions


def compile_function(function: ca.Function, derivatives: int = 0, optimize: int = 1) -> ca.Function:
    """Return a CasADi function compiled, or the function itself where that cannot be.

    Parameters
    ----------
    function : casadi.Function
    derivatives : {0, 1, 2}
        0: the function only, enough for a solver's own derivative functions. 1: its Jacobian as well. 2: also
        forward and adjoint derivatives and the adjoint's Jacobian, enough for an exact Hessian of what calls
        the function. CasADi cannot differentiate a compiled function beyond what was compiled.
    optimize : int
        The compiler's -O level; compile time grows with it.

    Returns
    -------
    casadi.Function
        With the same name, inputs and outputs, and results that are equal to the last bit.

    Raises
    ------
    InputError
        `derivatives` is none of 0, 1, 2.
    """
    if derivatives not in (0, 1, 2):
        raise InputError(f"derivatives is {derivatives!r}, expected 0, 1 or 2")
    if find_compiler() is None:
        return function
    try:
        library = _library(_sources(_with_derivatives(function, derivatives), ""), optimize)
    except UnavailableError as error:
        logger.warning("%s is interpreted, not compiled: %s", function.name(), error)
        return function
    return ca.external(function.name(), str(library))


_DRIVER = """
CASADI_SYMBOL_EXPORT int evaluate_rows(long count, const double** inputs, double** outputs, double* w) {{
  const double* arg[{arguments}];
  double* res[{results}];
  casadi_int iw[{integers}];
  static const long rows_in[] = {{{rows_in}}}, rows_out[] = {{{rows_out}}};
  long i, k;
  for (i = 0; i < count; ++i) {{
    for (k = 0; k < {n_in}; ++k) arg[k] = inputs[k] + i * rows_in[k];
    for (k = 0; k < {n_out}; ++k) res[k] = outputs[k] + i * rows_out[k];
    if ({name}(arg, res, iw, w, 0)) return 1;
  }}
  return 0;
}}

CASADI_SYMBOL_EXPORT int evaluate_columns(long count, const double** inputs, double** outputs, const long* strides,
                                          double* w) {{
  const double* arg[{arguments}];
  double* res[{results}];
  casadi_int iw[{integers}];
  static const long rows_in[] = {{{rows_in}}}, rows_out[] = {{{rows_out}}};
  double point[{total}];
  long i, k, row;
  for (i = 0; i < count; ++i) {{
    double* next = point;
    for (k = 0; k < {n_in}; ++k) {{
      arg[k] = next;
      for (row = 0; row < rows_in[k]; ++row) *next++ = inputs[k][row * strides[k] + i];
    }}
    for (k = 0; k < {n_out}; ++k) {{
      res[k] = next;
      next += rows_out[k];
    }}
    if ({name}(arg, res, iw, w, 0)) return 1;
    for (k = 0; k < {n_out}; ++k)
      for (row = 0; row < rows_out[k]; ++row) outputs[k][row * strides[{n_in} + k] + i] = res[k][row];
  }}
  return 0;
}}
"""


class CompiledProgram:
    """Evaluate a CasADi function for many points with machine code.

    Parameters
    ----------
    function : casadi.Function
        Inputs and outputs are dense column vectors.

    Raises
    ------
    UnavailableError
        There is no compiler, or it failed.
    """

    def __init__(self, function: ca.Function) -> None:
        self.rows_in = [function.size1_in(index) for index in range(function.n_in())]
        self.rows_out = [function.size1_out(index) for index in range(function.n_out())]
        driver = _DRIVER.format(
            name=function.name(),
            n_in=function.n_in(),
            n_out=function.n_out(),
            arguments=max(1, function.sz_arg()),
            results=max(1, function.sz_res()),
            integers=max(1, function.sz_iw()),
            rows_in=", ".join(map(str, self.rows_in)),
            rows_out=", ".join(map(str, self.rows_out)),
            total=max(1, sum(self.rows_in) + sum(self.rows_out)),
        )
        library = ctypes.CDLL(str(_library(_sources([function], driver), optimize=2)))
        self._evaluate = library.evaluate_rows
        self._evaluate.argtypes = [ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
        self._evaluate_columns = library.evaluate_columns
        self._evaluate_columns.argtypes = [ctypes.c_long, *[ctypes.c_void_p] * 4]
        self._work_size = max(1, function.sz_w())

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
        given = [np.ascontiguousarray(array, dtype=np.float64) for array in inputs]
        outputs = tuple(np.empty((count, rows)) for rows in self.rows_out)
        work = np.empty(self._work_size)  # of this call: other threads may be in the library as well
        self._evaluate(count, _addresses(given), _addresses(outputs), work.ctypes.data)
        return outputs

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
        work = np.empty(self._work_size)
        self._evaluate_columns(count, _addresses(inputs), _addresses(outputs), strides, work.ctypes.data)


def _addresses(arrays: Sequence[Array]) -> ctypes.Array[ctypes.c_void_p]:
    return (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))
