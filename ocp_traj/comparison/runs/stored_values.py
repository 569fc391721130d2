"""Values read back from a comparison's file, held apart from what a damaged file gives."""

from __future__ import annotations

import json
import math
import sqlite3
from typing import Any

COLUMNS = {
    "case_digest": "TEXT NOT NULL", "solver": "TEXT NOT NULL", "settings_digest": "TEXT NOT NULL",
    "seed": "INTEGER NOT NULL", "case_name": "TEXT NOT NULL", "seed_index": "INTEGER NOT NULL",
    "budget": "INTEGER", "time_limit": "REAL", "memory_limit": "INTEGER",
    "status": "TEXT NOT NULL", "reason": "TEXT NOT NULL", "message": "TEXT NOT NULL",
    "claimed": "INTEGER NOT NULL", "feasible": "INTEGER NOT NULL",
    "objective": "REAL", "duration": "REAL", "energy": "REAL",
    "worst_limit": "TEXT", "worst_joint": "INTEGER", "worst_time": "REAL", "worst_ratio": "REAL",
    "waypoint_error": "REAL", "smallest_feasible_scale": "REAL", "findings": "TEXT NOT NULL",
    "dimension": "INTEGER", "evaluations": "INTEGER",
    "build_time": "REAL", "solve_time": "REAL", "wall_time": "REAL", "peak_memory": "INTEGER",
    "trajectory": "TEXT", "plan": "INTEGER NOT NULL REFERENCES plans (id)", "finished": "TEXT NOT NULL",
}  # fmt: skip
"""Columns of a stored run and what each holds, in the words of SQLite.

Version 1 of the schema; a later column belongs to a step of its own, and not into the table of version 1.
"""


def check_columns(entry: sqlite3.Row) -> None:
    """Raise ValueError where a column of a run holds another kind of value than was ever written to it."""
    for name, kind in COLUMNS.items():
        value, required = entry[name], "NOT NULL" in kind
        if kind.startswith("TEXT"):
            fits, expected = isinstance(value, str), "a text"
        elif required:
            fits, expected = isinstance(value, int), "a whole number"
        else:
            fits, expected = _is_number(value), "a finite number"
        if not (fits or (value is None and not required)):
            raise ValueError(f"{name} holds {value!r}, expected {expected}{'' if required else ' or nothing'}")


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
        for name, value in values.items():
            if name != "failed" and not _is_number(value):
                raise ValueError(f"reference {part}: {name} is {value!r}, expected a number or null")
    return found


def _is_number(value: object) -> bool:
    if value is None:
        return True
    return isinstance(value, (int, float)) and math.isfinite(value)
