"""Values read back from a comparison's file, held apart from what a damaged file gives."""

from __future__ import annotations

import json
import math
import sqlite3
from typing import Any

TEXTS = (
    "case_digest", "case_name", "solver", "settings_digest", "status", "reason", "message", "findings",
)  # fmt: skip
"""Columns of a run that always hold a text."""

NUMBERS = (
    "objective", "duration", "energy", "worst_joint", "worst_time", "worst_ratio", "waypoint_error",
    "smallest_feasible_scale", "dimension", "evaluations", "build_time", "solve_time", "wall_time",
    "peak_memory", "budget", "time_limit",
)  # fmt: skip
"""Columns of a run that hold a finite number or nothing."""


def check_columns(entry: sqlite3.Row) -> None:
    """Raise ValueError where a column of a run holds another kind of value than was ever written to it."""
    for name in TEXTS:
        if not isinstance(entry[name], str):
            raise ValueError(f"{name} holds {entry[name]!r}, expected a text")
    for name in NUMBERS:
        if not _is_number(entry[name]):
            raise ValueError(f"{name} holds {entry[name]!r}, expected a finite number or nothing")
    for name in ("seed", "seed_index"):
        if not isinstance(entry[name], int):
            raise ValueError(f"{name} holds {entry[name]!r}, expected a whole number")
    for name in ("worst_limit", "trajectory"):
        if not (entry[name] is None or isinstance(entry[name], str)):
            raise ValueError(f"{name} holds {entry[name]!r}, expected a text or nothing")


def load_history(texts: dict[str, str]) -> dict[str, list[float | None]]:
    """Return the equally long lists of a convergence history; ValueError where they are something else."""
    history: dict[str, list[float | None]] = {part: json.loads(text) for part, text in texts.items()}
    for part, values in history.items():
        if not (isinstance(values, list) and all(_is_number(value) for value in values)):
            raise ValueError(f"history: {part} holds something else than numbers")
    if len({len(values) for values in history.values()}) > 1:
        raise ValueError("history: its lists differ in length")
    return history


def load_texts(text: str) -> tuple[str, ...]:
    """Return a list of texts; ValueError where it is something else."""
    found = json.loads(text)
    if not (isinstance(found, list) and all(isinstance(value, str) for value in found)):
        raise ValueError("findings hold something else than texts")
    return tuple(found)


def load_object(text: str) -> dict[str, Any]:
    """Return a JSON object; ValueError where it is something else."""
    found = json.loads(text)
    if not isinstance(found, dict):
        raise ValueError(f"a {type(found).__name__} stands where an object was written")
    return found


def load_choice(text: str) -> dict[str, Any]:
    """Return what a case was chosen by, its name or path and its overrides; ValueError where it is none."""
    found = load_object(text)
    overrides = found.get("overrides")
    texts = [found.get("case"), *(overrides if isinstance(overrides, list) else [None])]
    if not all(isinstance(value, str) for value in texts):
        raise ValueError("a case's choice holds something else than a name and a list of overrides")
    return found


def load_reference(text: str | None) -> dict[str, Any] | None:
    """Return a case's references by part, each a table of numbers and texts, or None; else ValueError."""
    if text is None:
        return None
    found = load_object(text)
    for part, values in found.items():
        if not isinstance(values, dict):
            raise ValueError(f"reference {part} is no table")
        for name in ("lower", "estimate"):
            if not _is_number(values.get(name)):
                raise ValueError(f"reference {part}: {name} is {values[name]!r}, expected a number or null")
    return found


def _is_number(value: object) -> bool:
    if value is None:
        return True
    return isinstance(value, (int, float)) and math.isfinite(value)
