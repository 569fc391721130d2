"""Bounds, estimates, references and results of one problem on one axis of time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.exceptions import InputError
from ocp_traj.pictures.picture import LIMIT, Line, Panel, Picture
from ocp_traj.references.reference import ESTIMATED, FOUND, PROVED, TIMED, Reference
from ocp_traj.references.registry import all_references

if TYPE_CHECKING:
    from ocp_traj.references import ReferenceSet

_COLOURS = {PROVED: 2, ESTIMATED: 4, TIMED: 0, FOUND: 1}
_PLAIN = 8


@dataclass(frozen=True)
class TimeEntry:
    """One duration to show, s, and what kind of knowledge it is."""

    name: str
    seconds: float
    kind: str


def reference_entries(found: ReferenceSet) -> list[TimeEntry]:
    """Return the durations a set of references holds."""
    known = {reference.name: reference for reference in all_references()}
    return [
        entry
        for name, finding in found.findings.items()
        for entry in duration_entries(known[name], finding.seconds)
    ]


def duration_entries(reference: Reference, seconds: Mapping[str, float | None]) -> list[TimeEntry]:
    """Return the durations of one reference, by part."""
    return [
        TimeEntry(reference.describe(part), value, reference.kind_of(part))
        for part, value in seconds.items()
        if value is not None
    ]


def result_entries(durations: Mapping[str, float]) -> list[TimeEntry]:
    """Return the durations of solvers' feasible results."""
    return [TimeEntry(name, seconds, FOUND) for name, seconds in durations.items() if np.isfinite(seconds)]


def bounds_panel(entries: Sequence[TimeEntry], title: str, *, coloured: bool = True) -> Panel:
    """Return the entries by duration, shortest below; gaps are to the kinematic bound, else to the shortest.

    Without `coloured`, colours do not tell the kind of knowledge: for pictures in which they mean something else.

    Raises
    ------
    InputError
        There are no entries.
    """
    if not entries:
        raise InputError("there are no bounds, references or results to draw")
    ordered = sorted(entries, key=lambda entry: entry.seconds)
    base = next((entry for entry in ordered if entry.kind == PROVED), ordered[0])
    shortest, longest = ordered[0].seconds, ordered[-1].seconds
    margin = 0.05 * (longest - shortest) or 0.05 * max(longest, 1e-9)
    left = shortest - margin
    lines = [Line(np.full(2, base.seconds), np.array([-0.3, len(ordered) - 0.3]), "", LIMIT, dashed=True)]
    names = []
    for row, entry in enumerate(ordered):
        end = np.full(2, entry.seconds)
        colour, label = (_COLOURS[entry.kind], entry.kind) if coloured else (_PLAIN, "")
        across = np.array([left, entry.seconds])
        lines.append(Line(across, np.full(2, float(row)), label, colour))
        lines.append(Line(end, row + np.array([-0.25, 0.25]), label, colour, wide=True))
        gap = 100.0 * (entry.seconds / base.seconds - 1.0) if base.seconds > 0 else 0.0
        over = "" if entry is base else f" ({gap:+.3g} %)"
        names.append(f"{entry.name}: {entry.seconds:.4f} s{over}")
    lines.append(Line(np.array([left, longest + margin]), np.full(2, -0.5), "", LIMIT))
    return Panel(
        title, "duration (s)", "", tuple(lines), y_range=(-0.5, len(ordered) - 0.3), row_names=tuple(names)
    )


def bounds_picture(entries: Sequence[TimeEntry], case: str) -> Picture:
    """Return the picture of one problem's bounds, references and results.

    Raises
    ------
    InputError
        There are no entries.
    """
    base = "the proved bound" if any(entry.kind == PROVED for entry in entries) else "the shortest"
    caption = (
        f"Percentages are the gap to {base}. An estimate is a local optimum: a shorter motion may exist."
    )
    return Picture("bounds", f"How far from the best: {case}", caption, (bounds_panel(entries, case),), 1)
