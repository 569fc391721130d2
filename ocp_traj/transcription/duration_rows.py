"""The rows that bound sums of durations, in both forms of a problem."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.nlp import RowBlock


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
    """Return the rows of the total duration and of the durations of gaps that have a bound."""
    segments = np.arange(task.gaps * (task.virtual_knots + 1)).reshape(task.gaps, -1)
    intervals = [(segments.ravel(), np.asarray(task.objective.duration), 0)]
    intervals += zip(segments, np.asarray(task.objective.gap_durations), range(task.gaps))
    rows = []
    for columns, (low, high), gap in intervals:
        if low > 0 or np.isfinite(high):
            scale = float(high if np.isfinite(high) else low)
            label = RowBlock("duration", np.array([-1]), np.array([gap]), np.array([0.0]))
            lower = float(low) / scale if low > 0 else -np.inf
            rows.append(DurationRow(columns, scale, lower, float(high) / scale, label))
    return rows
