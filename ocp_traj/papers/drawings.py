"""The pictures of the papers' pages: convergence, motions against their limits, tool paths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array, ArrayLike
from ocp_traj.comparison.report.profiles import best_at, course_of
from ocp_traj.comparison.report.statistics import quartiles
from ocp_traj.comparison.runs.store import StoredRun
from ocp_traj.papers.records import Records, number_of
from ocp_traj.pictures.motion import motion_picture, path_picture
from ocp_traj.pictures.picture import Band, Line, Panel, Picture

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

LEAST_SHOWN_PERCENT = 1e-3
"""Distances from the best below this, %, are drawn here."""

KINEMATIC_PANELS = 4
"""Panels of a motion that papers show: position, velocity, acceleration, jerk."""

GRID_POINTS = 300
LARGEST_VIOLATION = 1e-9
"""Up to this total violation an entry of a joint's history counts as feasible."""


def convergence_picture(
    records: Records, labels: Sequence[str], group: str, title: str, caption: str, unit: str
) -> Picture:
    """Return the median distance of the best verified cost from the best of all runs, with quartile bands.

    Both axes are logarithmic: on plain ones the first generation hides all that follows.
    """
    curves = {}
    for label in labels:
        rows = [row for row in records.runs(label, group) if len(row.record.history.get("cost", ())) > 1]
        if rows:
            last = max(number_of(row, "evaluations") or 1 for row in rows)
            first = min(row.record.history["evaluations"][0] or 1 for row in rows)
            grid = np.geomspace(max(first, 1), last, GRID_POINTS)
            curves[label] = grid, np.stack([best_at(course_of(row, last), grid, "evaluations") for row in rows])
    best = min((float(costs.min()) for _, costs in curves.values()), default=np.inf)
    lines, bands = [], []
    for colour, (label, (grid, costs)) in enumerate(curves.items()):
        above = np.full_like(costs, np.inf) if np.isinf(best) else 100.0 * (costs / best - 1.0)
        line, band = _spread(grid, np.maximum(above, LEAST_SHOWN_PERCENT), label, colour)
        lines.append(line)
        bands.append(band)
    known = bool(np.isfinite(best))
    y_label = f"above the best of all runs ({best:.4g} {unit}), %" if known else "no run is feasible"
    panel = Panel("", "evaluations", y_label, tuple(lines), tuple(bands), log_x=known, log_y=known)
    return Picture("convergence", title, caption, (panel,), columns=1)


def joints_picture(
    records: Records, labels: Sequence[str], group: str, joints: Sequence[int], title: str, caption: str
) -> Picture:
    """Return the convergence of joints optimised alone, one panel per joint: median over seeds and quartiles."""
    panels = []
    for joint in joints:
        drawn = []
        for colour, label in enumerate(labels):
            histories = [part["history"] for part in records.parts(label, group, joint) if part]
            if histories:
                grid = np.arange(1, histories[0]["generation"][-1] + 2)
                costs = np.stack([_best_of_generations(entry, grid - 1) for entry in histories])
                drawn.append(_spread(grid, costs, label, colour))
        lines, bands = tuple(line for line, _ in drawn), tuple(band for _, band in drawn)
        axes = ("generation, the first population being 1", "best feasible total, s")
        panels.append(Panel(f"joint {joint}", *axes, lines, bands, log_x=True))
    return Picture("joints", title, caption, tuple(panels), columns=min(3, len(panels)))


def _best_of_generations(history: Mapping[str, Any], generations: Array) -> Array:
    """Return the best feasible cost after each generation, infinite before there is one."""
    violation = np.array([np.inf if value is None else value for value in history["violation"]])
    cost = np.array([np.inf if value is None else value for value in history["cost"]], dtype=np.float64)
    places = np.searchsorted(np.array(history["generation"]), generations, side="right") - 1
    return np.asarray(np.where(violation > LARGEST_VIOLATION, np.inf, cost)[places])


def _spread(x: ArrayLike, curves: Array, label: str, colour: int) -> tuple[Line, Band]:
    """Return median and quartiles of curves (S, N) where they are finite; the line starts where half of them are."""
    low, middle, high = quartiles(curves)
    x, shown = np.asarray(x, dtype=np.float64), np.isfinite(middle)
    words = label if shown.any() else f"{label}: feasible in less than half of the runs"
    inside = shown & np.isfinite(high)
    return Line(x[shown], middle[shown], words, colour), Band(x[inside], low[inside], high[inside], colour)


def motions_picture(task: TrajectoryTask, motions: Mapping[str, Trajectory], title: str, caption: str) -> Picture:
    """Return position, velocity, acceleration and jerk of every joint, one column per motion, with their limits."""
    pictures = {
        name: motion_picture(task, motion).panels[:KINEMATIC_PANELS] for name, motion in motions.items()
    }
    alone = len(motions) == 1
    panels = tuple(
        panels[row] if alone else replace(panels[row], title=f"{panels[row].title}, {name}")
        for row in range(KINEMATIC_PANELS)
        for name, panels in pictures.items()
    )
    return Picture("motion", title, caption, panels, columns=2 if alone else len(motions))


def tool_picture(task: TrajectoryTask, motion: Trajectory, title: str, caption: str) -> Picture:
    """Return the tool's path over time and from three sides."""
    return replace(path_picture(task, motion), name="tool", title=title, caption=caption)


def segments_picture(records: Records, label: str, group: str, joint: int, title: str, caption: str) -> Picture | None:
    """Return the durations of one joint's best candidate over the generations of the first run, if there is one."""
    parts = records.parts(label, group, joint)[:1]
    if not any(parts):
        return None
    history = parts[0]["history"]
    curves = {f"segment {gap}": curve for gap, curve in enumerate(np.array(history["x"]).T, start=1)}
    return lines_picture(
        f"segments-{joint}", title, caption, ("generation", "duration, s"), history["generation"], curves
    )


def lines_picture(
    name: str,
    title: str,
    caption: str,
    axes: tuple[str, str],
    x: ArrayLike,
    curves: Mapping[str, ArrayLike],
    step: bool = False,
) -> Picture:
    """Return a few named curves in one panel; `axes` are the labels of x and y."""
    lines = tuple(
        Line(np.asarray(x), np.asarray(values), label, colour, step=step)
        for colour, (label, values) in enumerate(curves.items())
    )
    return Picture(name, title, caption, (Panel("", *axes, lines),), columns=1)


def best_motion(task: TrajectoryTask, rows: Sequence[StoredRun], field: str) -> Trajectory | None:
    """Rebuild the best (feasible first) run's motion from its gap durations (families without virtual knots)."""
    from ocp_traj.transcription import trajectory_from_durations

    usable = [row for row in rows if row.record.details.get("segments") and number_of(row, field) is not None]
    if not usable:
        return None
    best = min(usable, key=lambda row: (not row.record.feasible, number_of(row, field)))
    return trajectory_from_durations(task, best.record.details["segments"])
