"""What every writer of files needs: files that are never half written, numbers that JSON can hold."""

from __future__ import annotations

import errno
import math
import os
import stat
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def write_atomically(path: Path, text: str) -> None:
    r"""Write a file in one step, lines ending in ``\n``: a reader sees the old one or the new one, never a part.

    Parameters
    ----------
    path : pathlib.Path
    text : str

    Raises
    ------
    OSError
        The file cannot be written; the caller says which in its own words.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        temporary.write_text(text, encoding="utf-8", newline="\n")
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def read_regular(path: Path, most: int) -> bytes:
    """Return the content of a regular file: a device may never end, and a pipe may never begin.

    Parameters
    ----------
    path : pathlib.Path
    most : int
        Bytes at most.

    Raises
    ------
    OSError
        The file cannot be read, is no regular file, or is larger.
    """
    found = path.stat()
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, "it is a folder", str(path))
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, "it is not a regular file", str(path))
    if found.st_size > most:
        raise OSError(errno.EFBIG, f"it is larger than {most} bytes", str(path))
    with path.open("rb") as stream:
        return stream.read(most)


def finite(value: Any) -> Any:
    """Return the same nested value with every infinite or undefined number replaced by None, as JSON needs it.

    Parameters
    ----------
    value : Any
        Numbers, texts, None, and mappings and sequences of such.
    """
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: finite(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(entry) for entry in value]
    return value
