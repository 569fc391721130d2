"""The exact curves of stored runs, one file each in the folder of a comparison."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ocp_traj.comparison.runs.plan import RunSpec
from ocp_traj.comparison.runs.stored_values import load_object
from ocp_traj.exceptions import InputError
from ocp_traj.files import read_regular, write_atomically

LARGEST_BYTES = 2**28
"""Largest file of a curve that is read, bytes."""


def write_curve(folder: Path, spec: RunSpec, curve: dict[str, Any]) -> str:
    """Write the curve of a run, with the task it carries, into `folder`; return the name of its file.

    Raises
    ------
    InputError
        It cannot be written.
    """
    safe = "".join(
        letter if letter.isalnum() or letter in "-." else "_" for letter in f"{spec.case_name}-{spec.solver}"
    )
    name = f"{safe[:80]}-{spec.seed}-{spec.case_digest[:6]}{spec.settings_digest[:6]}.spline.json"
    try:
        write_atomically(folder / name, json.dumps(curve))
    except OSError as error:
        raise InputError(f"cannot write {folder / name}: {error.strerror or error}") from None
    return name


def read_curve(folder: Path, name: str) -> dict[str, Any]:
    """Return the curve in a file of `folder`.

    Raises
    ------
    InputError
        The file is not there, is no regular file, is damaged, or does not lie in the folder.
    """
    if Path(name).name != name or name == ".." or "\0" in name:
        raise InputError(f"trajectory {name!r} leads out of {folder}")
    path = folder / name
    try:
        return load_object(read_regular(path, LARGEST_BYTES).decode("utf-8"))
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is damaged: {error}") from None
