"""CasADi functions as machine code: generated as C, compiled once by the system's compiler, kept on disk.

The library of a function is kept in the user's cache folder under the hash of its C text, of the compiler and
of the versions involved. The folder belongs to the user alone (mode 0700), a record beside each library holds
the library's own SHA-256, and nothing is loaded that does not match it. Files appear by atomic renaming, so
processes may share the folder. Without a compiler, or with ``OCP_TRAJ_NO_COMPILER=1``, the interpreter is
used, with the same results.
"""

from __future__ import annotations

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

from ocp_traj.exceptions import InputError, UnavailableError
from ocp_traj.version import __version__

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
        try:
            done = subprocess.run([path, "--version"], capture_output=True, text=True, check=False)
        except OSError as error:
            logger.warning("the compiler %s cannot be started: %s", path, error)
            continue
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


def _sources(functions: Sequence[ca.Function]) -> str:
    generator = ca.CodeGenerator("functions.c", {"with_header": False})
    for function in functions:
        generator.add(function)
    return generator.dump()


def build_library(text: str, optimize: int) -> Path:
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
    try:
        return _compiled(text, [compiler[0], *flags], folder, key)
    except OSError as error:  # a full disk, no file descriptors left, no memory for the compiler
        raise UnavailableError(f"nothing could be compiled in {folder}: {error.strerror or error}") from error


def _compiled(text: str, command: list[str], folder: Path, key: str) -> Path:
    """Return the library of a C text, compiled and put into the cache with its record."""
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        source, built = Path(scratch) / "functions.c", Path(scratch) / "functions.so"
        source.write_text(text)
        whole = [*command, str(source), "-o", str(built), "-lm"]
        done = subprocess.run(whole, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise UnavailableError(f"{command[0]} failed with status {done.returncode}: {done.stderr[-500:]}")
        digest = hashlib.sha256(built.read_bytes()).hexdigest()
        # The digest is part of the name: two processes that compile at once never mix library and record.
        library = folder / f"{key[:16]}-{digest[:16]}.so"
        os.replace(built, library)
        note = Path(scratch) / "record.json"
        note.write_text(json.dumps({"library": library.name, "sha256": digest}))
        os.replace(note, folder / f"{key}.json")
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
        library = build_library(_sources(_with_derivatives(function, derivatives)), optimize)
        return ca.external(function.name(), str(library))
    except (UnavailableError, RuntimeError) as error:  # the second where a library cannot be loaded
        logger.warning("%s is interpreted, not compiled: %s", function.name(), error)
        return function
