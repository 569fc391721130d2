"""The only place that parses TOML text: size limits, one kind of error, and ``key=value`` overrides."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ocp_traj.exceptions import CaseError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MAX_BYTES = 10_000_000
"""Largest file that is read, bytes."""

_KEY = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*")
_BARE_WORD = re.compile(r"[A-Za-z0-9_./+-]+")
_MAX_DEPTH = 50
_PART = r"""(?:[A-Za-z0-9_-]+|"[^"\n]*"|'[^'\n]*')[ \t]*"""
_DEEP_KEY = re.compile(rf"(?:^|[{{,])[ \t]*\[*[ \t]*(?:{_PART}\.[ \t]*){{{_MAX_DEPTH},}}", re.MULTILINE)
"""A dotted key whose reading would take memory and time with the square of its length."""


def read_text(path: Path, file: str, most: int = MAX_BYTES) -> str:
    """Return the text of a regular file of at most `most` bytes.

    Raises
    ------
    CaseError
        The file is missing, is no regular file, cannot be read, is too large, or is not UTF-8.
    """
    content = _read_bytes(path, file, most)
    if len(content) > most:
        raise CaseError(file, "", f"is larger than {most // 1_000_000} MB, expected a case file")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise CaseError(file, "", f"is not UTF-8 text (byte {error.start})") from None


def _read_bytes(path: Path, file: str, most: int) -> bytes:
    if "\0" in str(path):
        raise CaseError(file, "", "is no path, it holds a null character")
    try:
        if not path.exists():
            raise CaseError(file, "", "does not exist")
        if not path.is_file():
            raise CaseError(file, "", "is not a regular file")
        with path.open("rb") as stream:
            return stream.read(most + 1)
    except OSError as error:
        raise CaseError(file, "", f"cannot be read ({error.strerror or error})") from None


def parse_toml(text: str, file: str) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Raises
    ------
    CaseError
        The text is not TOML; the message has line and column.
    """
    deep = _DEEP_KEY.search(text)
    if deep is not None:
        line = text.count("\n", 0, deep.end()) + 1
        raise CaseError(file, "", f"line {line} has a key of more than {_MAX_DEPTH} parts, expected a case file")
    try:
        tables: dict[str, Any] = tomllib.loads(text)
    except RecursionError:
        raise CaseError(file, "", "is nested too deeply") from None
    except ValueError as error:
        raise CaseError(file, "", f"is not TOML: {error}") from None
    return tables


def read_toml(path: Path, file: str) -> dict[str, Any]:
    """Return the tables of a TOML file; see `read_text` and `parse_toml` for what is raised.

    Parameters
    ----------
    path : Path
    file : str
        Its name in messages.
    """
    return parse_toml(read_text(path, file), file)


def apply_override(tables: dict[str, Any], override: str, file: str) -> str:
    """Set one key of `tables` in place from ``"key=value"`` and return the dotted key.

    The value is read as TOML; a bare word (``spline.family=cubic``) is taken as text.

    Raises
    ------
    CaseError
        There is no ``=``, the key is no dotted key or leads through something that is no table, or the
        value is not TOML.
    """
    key, separator, text = override.partition("=")
    key = key.strip()
    if not separator or not _KEY.fullmatch(key) or key.count(".") > _MAX_DEPTH:
        raise CaseError(
            file, "", f"override {_shortened(override)} is not key=value, for instance limits.velocity=1.5"
        )
    *parents, last = key.split(".")
    table: Any = tables
    for depth, name in enumerate(parents):
        table = table.setdefault(name, {})
        if not isinstance(table, dict):
            raise CaseError(file, key, f"{'.'.join(parents[: depth + 1])} is no table, it has no keys")
    table[last] = _parse_value(key, text.strip(), file)
    return key


def _parse_value(key: str, text: str, file: str) -> Any:
    try:
        parsed: Mapping[str, Any] = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        if _BARE_WORD.fullmatch(text):
            return text
        raise CaseError(file, key, f"{_shortened(text)} is not a TOML value") from None
    if set(parsed) != {"value"}:
        raise CaseError(file, key, f"{_shortened(text)} is more than one TOML value")
    return parsed["value"]


def _shortened(text: str) -> str:
    quoted = repr(text)
    return quoted if len(quoted) <= 60 else f"{quoted[:57]}..."
