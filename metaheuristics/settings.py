"""Whether a setting is of the kind its field says: what comes from a command line may be a word."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from numbers import Integral, Real
from typing import Any

import numpy as np


def check_settings(owner: str, kind: type[Any], values: Mapping[str, Any]) -> None:
    """Refuse values that are not what the fields of a dataclass are declared to be.

    Fields declared as anything but ``int``, ``float``, ``bool`` or ``str`` are not looked at, nor are names that are
    no fields.

    Parameters
    ----------
    owner
        Whose settings these are, for the message.
    kind
        A dataclass whose annotations are texts (``from __future__ import annotations``).
    values
        Settings by name.

    Raises
    ------
    ValueError
        If a value is of another kind, or no number; says which setting, what was given and what was expected.
    """
    for entry in fields(kind):
        if entry.name in values:
            expected = _expected(str(entry.type), values[entry.name])
            if expected:
                given = values[entry.name]
                raise ValueError(f"The setting {entry.name!r} of {owner} is {given!r}, expected {expected}.")


def _expected(declared: str, value: Any) -> str:
    """Return what is expected instead of a value; empty where it fits."""
    truth = isinstance(value, (bool, np.bool_))
    if declared == "int" and (truth or not isinstance(value, Integral)):
        return "a whole number"
    if declared == "float" and (truth or not isinstance(value, Real) or math.isnan(value)):
        return "a number"
    if declared == "bool" and not truth:
        return "true or false"
    if declared == "str" and not isinstance(value, str):
        return "a word"
    return ""
