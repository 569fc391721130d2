"""The rows that bound sums of durations, in both forms of a problem."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.nlp import RowBlock

NEAR = 2.0
"""Bounds whose ratio is at most this share a row."""


@dataclass(frozen=True, eq=False)
class DurationRow:
    """A bounded sum of durations: lower <= sum / scale <= upper.

    Attributes
    ----------
    segments : (k,) integer array
    scale : float, s
    lower, upper : float
    label : RowBlock
        One row.
    """

    segments: Any
    scale: float
    lower: float
    upper: float
    label: RowBlock


def duration_rows(task: TrajectoryTask) -> list[DurationRow]:
    """Return the rows of the total duration and of the durations of gaps that have bounds."""
    segments = np.arange(task.gaps * (task.virtual_knots + 1)).reshape(task.gaps, -1)
    intervals = [(segments.ravel(), np.asarray(task.objective.duration), 0)]
    intervals += zip(segments, np.asarray(task.objective.gap_durations), range(task.gaps))
    rows = []
    for columns, (low, high), gap in intervals:
        label = RowBlock("duration", np.array([-1]), np.array([gap]), np.array([0.0]))
        for scale, lower, upper in _sides(float(low), float(high)):
            rows.append(DurationRow(columns, scale, lower, upper, label))
    return rows


def _sides(low: float, high: float) -> list[tuple[float, float, float]]:
    """Return scale, lower and upper bound of the rows of one interval: a row per side, in units of its own bound.

    In units of the other bound an excess over a side means nothing where the two are far apart.
    """
    if low > 0 and high <= NEAR * low:
        return [(high, low / high, 1.0)]
    sides = []
    if low > 0:
        sides.append((low, 1.0, np.inf))
    if np.isfinite(high):
        sides.append((high, -np.inf, 1.0))
    return sides
