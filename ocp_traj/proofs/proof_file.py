"""Proof files on disk."""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Any

from ocp_traj.exceptions import InputError

LARGEST_BYTES = 5_000_000


def write_proof(document: dict[str, Any], path: str | os.PathLike[str]) -> None:
    """Write a proof; the file is there whole or not at all.

    Parameters
    ----------
    document : dict
        From `prove` or `prove_bound`.
    path : path
        Overwritten when there is one.

    Raises
    ------
    InputError
        The proof is larger than 5 MB, or the file cannot be written.
    """
    path = Path(path)
    data = (json.dumps(document, allow_nan=False, separators=(",", ":")) + "\n").encode()
    if len(data) > LARGEST_BYTES:
        raise InputError(f"{path}: the proof has {len(data)} bytes, expected at most {LARGEST_BYTES}")
    temporary = None
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", delete=False) as stream:
            temporary = Path(stream.name)
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.chmod(0o666 & ~_umask())
        os.replace(temporary, path)
    except OSError as error:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
        raise InputError(f"{path}: cannot be written ({error.strerror or error})") from None


def _umask() -> int:
    """Return the process's mask of permissions, which temporary files ignore."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
