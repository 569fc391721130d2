"""Checked access to one table of a case file: every wrong type, shape or key is refused by name."""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import CaseError, did_you_mean

MAX_TEXT = 10_000
"""Longest text of a key, characters."""


def describe(value: Any) -> str:
    """Return a value as it may stand in a message: short, and with its kind where that is the point."""
    if isinstance(value, str):
        return f"the text {value!r}" if len(value) <= 60 else f"the text {value[:57]!r}..."
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return f"{value:g}" if isinstance(value, float) or abs(value) < 10**15 else "an enormous whole number"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return "a list" if value else "an empty list"
    return "a date or time"


@dataclass(frozen=True)
class Section:
    """One table of a case file.

    Parameters
    ----------
    file : str
        The file as the caller named it, for messages.
    key : str
        Dotted key of the table, empty for the whole file.
    data : dict
        The table as parsed.
    """

    file: str
    key: str
    data: dict[str, Any]

    def __contains__(self, name: str) -> bool:
        return name in self.data

    def path(self, name: str) -> str:
        """Return the dotted key of an entry, of the table itself for an empty name."""
        return ".".join(part for part in (self.key, name) if part)

    def error(self, name: str, problem: str) -> CaseError:
        """Return the error that names the file and the key of an entry; the caller raises it."""
        return CaseError(self.file, self.path(name), problem)

    def check_keys(self, known: Collection[str]) -> None:
        """Raise CaseError for the first key that is not among `known`."""
        for name in self.data:
            if name not in known:
                short = name if len(name) <= 60 else f"{name[:57]}..."
                shown = short if short.isprintable() else ascii(short)
                expected = ", ".join(sorted(known))
                raise self.error(shown, f"unknown key, expected one of {expected}{did_you_mean(name, known)}")

    def section(self, name: str) -> Section:
        """Return a table inside this one, empty when it is not there."""
        value = self.data.get(name, {})
        if not isinstance(value, dict):
            raise self.error(name, f"{describe(value)} given, expected a table")
        return Section(self.file, self.path(name), value)

    def sections(self, name: str) -> Iterator[Section]:
        """Yield the tables of a list of tables; their keys count from 1."""
        value = self.data.get(name, [])
        if not isinstance(value, list):
            raise self.error(name, f"{describe(value)} given, expected a list of tables")
        for index, entry in enumerate(value):
            if not isinstance(entry, dict):
                raise self.error(f"{name}[{index + 1}]", f"{describe(entry)} given, expected a table")
            yield Section(self.file, self.path(f"{name}[{index + 1}]"), entry)

    def text(self, name: str, default: str | None = None) -> str:
        """Return a text without control characters; `default` None means it has to be given."""
        value = self._get(name, default, "a text")
        if not isinstance(value, str):
            raise self.error(name, f"{describe(value)} given, expected a text")
        if len(value) > MAX_TEXT:
            raise self.error(name, f"has {len(value)} characters, expected at most {MAX_TEXT}")
        for character in value:
            if unicodedata.category(character) in ("Cc", "Cs") and character not in "\n\t":
                raise self.error(
                    name, f"holds the control character U+{ord(character):04X}, expected plain text"
                )
        return value

    def choice(self, name: str, options: Collection[str], default: str | None = None) -> str:
        """Return a text that is one of `options`."""
        value = self.text(name, default)
        if value not in options:
            expected = ", ".join(options)
            raise self.error(
                name, f"{describe(value)} given, expected one of {expected}{did_you_mean(value, options)}"
            )
        return value

    def texts(self, name: str) -> tuple[str, ...]:
        """Return a list of texts, empty when it is not there."""
        value = self.data.get(name, [])
        if not isinstance(value, list) or not all(isinstance(entry, str) for entry in value):
            raise self.error(name, f"{describe(value)} given, expected a list of texts")
        return tuple(value)

    def integer(self, name: str, default: int | None, largest: int) -> int:
        """Return a whole number from 0 to `largest`."""
        value = self._get(name, default, "a whole number")
        if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= largest:
            raise self.error(name, f"{describe(value)} given, expected a whole number from 0 to {largest}")
        return value

    def number(self, name: str, default: float | None = None) -> float:
        """Return a finite number."""
        value = self._get(name, default, "a number")
        if not _is_number(value):
            raise self.error(name, f"{describe(value)} given, expected a number")
        return self._float(name, value, finite=True)

    def array(self, name: str, *, finite: bool = True) -> Array:
        """Return a number, a list of numbers, or lists of lists of numbers, all of one length, as an array.

        Raises
        ------
        CaseError
            Something is no number, is nan (or infinite where `finite`), or rows differ in length.
        """
        value = self._get(name, None, "numbers")
        shape = self._shape(name, value, depth=0)
        numbers = [self._float(key, entry, finite=finite) for key, entry in _leaves(name, value)]
        return np.array(numbers, dtype=np.float64).reshape(shape)

    def array_of_shape(self, name: str, *shapes: tuple[int, ...], finite: bool = True) -> Array:
        """Return an array that has one of `shapes`."""
        values = self.array(name, finite=finite)
        if values.shape not in shapes:
            expected = " or ".join(shape_in_words(shape) for shape in shapes)
            raise self.error(name, f"{shape_in_words(values.shape)} given, expected {expected}")
        return values

    def _get(self, name: str, default: Any, expected: str) -> Any:
        value = self.data.get(name, default)
        if value is None:
            raise self.error(name, f"missing, expected {expected}")
        return value

    def _float(self, name: str, value: Any, *, finite: bool) -> float:
        try:
            number = float(value)
        except OverflowError:
            raise self.error(name, "an enormous whole number given, expected a number below 1e308") from None
        if math.isnan(number):
            raise self.error(name, f"nan given, expected a {'finite ' if finite else ''}number")
        if finite and math.isinf(number):
            raise self.error(name, f"{number:g} given, expected a finite number")
        return number

    def _shape(self, name: str, value: Any, depth: int) -> tuple[int, ...]:
        if _is_number(value):
            return ()
        if not isinstance(value, list) or depth == 3:
            raise self.error(name, f"{describe(value)} given, expected {'a number' if depth else 'numbers'}")
        shapes = [self._shape(f"{name}[{index + 1}]", entry, depth + 1) for index, entry in enumerate(value)]
        for index, shape in enumerate(shapes):
            if shape != shapes[0]:
                given, first = shape_in_words(shape), shape_in_words(shapes[0])
                raise self.error(
                    f"{name}[{index + 1}]", f"{given} given, expected {first} as in the first row"
                )
        return (len(value), *(shapes[0] if shapes else ()))


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, list):
        for index, entry in enumerate(value):
            yield from _leaves(f"{name}[{index + 1}]", entry)
    else:
        yield name, value


def shape_in_words(shape: tuple[int, ...]) -> str:
    """Return a shape as a person says it: ``"2 rows of 6 numbers"``."""
    if shape == ():
        return "a number"
    last = "1 number" if shape[-1] == 1 else f"{shape[-1]} numbers"
    if len(shape) == 1:
        return last
    return f"{' x '.join(str(size) for size in shape[:-1])} row{'' if shape[-2] == 1 else 's'} of {last}"
