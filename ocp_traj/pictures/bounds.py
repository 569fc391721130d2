"""Bounds, estimates, references and results of one problem on one axis of time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.comparison.report.judging import ComparedProblem, Judgement
from ocp_traj.exceptions import InputError
from ocp_traj.pictures.picture import LIMIT, Line, Panel, Picture

if TYPE_CHECKING:
    from ocp_traj.references import ReferenceSet

PROVED, ESTIMATED, TIMED, FOUND = "proved bound", "estimate", "fixed path", "solver's result"

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
    entries = [
        ("kinematic bound", found.bound.lower, PROVED),
        ("kinematic estimate", found.bound.estimate, ESTIMATED),
    ]
    entries += [(f"TOPP-RA, {result.path} path", result.duration, TIMED) for result in found.toppra]
    entries += [(f"convex, {result.path} path", result.duration, TIMED) for result in found.convex]
    if found.jerk is not None:
        entries.append(("with bounded jerk, estimate", found.jerk.estimate, ESTIMATED))
        entries += [
            (f"with bounded jerk, {result.path} path", result.duration, TIMED) for result in found.jerk_paths
        ]
    if found.certificate is not None:
        family = found.task.family
        entries.append((f"{family}: no durations below", found.certificate.lower, PROVED))
        entries.append((f"{family}: best durations", found.certificate.upper, FOUND))
    return [TimeEntry(name, seconds, kind) for name, seconds, kind in entries if seconds is not None]


def result_entries(durations: Mapping[str, float]) -> list[TimeEntry]:
    """Return the durations of solvers' feasible results."""
    return [TimeEntry(name, seconds, FOUND) for name, seconds in durations.items() if np.isfinite(seconds)]


def problem_entries(judgement: Judgement, problem: ComparedProblem) -> list[TimeEntry]:
    """Return what a comparison knows of one problem's duration: references, and the shortest of every solver."""
    known = [
        ("kinematic bound", problem.lower_bound, PROVED),
        ("kinematic estimate", problem.estimate, ESTIMATED),
        ("with bounded jerk, estimate", problem.jerk_estimate, ESTIMATED),
        (f"TOPP-RA, {problem.toppra_path} path", problem.toppra, TIMED),
    ]
    durations = {
        solver: float(group.durations().min())
        for solver in judgement.solvers
        if (group := judgement.group(problem, solver)) is not None
    }
    entries = [TimeEntry(name, seconds, kind) for name, seconds, kind in known if seconds is not None]
    return entries + result_entries(durations)


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
