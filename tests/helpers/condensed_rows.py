"""Candidates of the condensed form, and the motions they should stand for (`helpers.row_oracle`)."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import PPoly

from helpers.row_oracle import (
    DEGREES,
    GAPS,
    Motion,
    spline,
)
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.condensed.condensed import CondensedNlp

SAMPLES = 6
CANDIDATES = 3
ENDS = ("velocity", "acceleration", "jerk")


def durations_of(nlp: CondensedNlp, x: np.ndarray) -> np.ndarray:
    """Return the durations of the segments: of the gaps first, then ratios to each gap's first segment."""
    per_gap = nlp.task.virtual_knots + 1
    durations = []
    for gap in range(GAPS):
        total = x[gap] if str(nlp.encoding) == "durations" else np.exp(x[gap])
        shares = [1.0] + [np.exp(x[GAPS + gap * (per_gap - 1) + k]) for k in range(per_gap - 1)]
        durations += [total * share / sum(shares) for share in shares]
    return np.array(durations)


def local_travel(task: TrajectoryTask, gap: int) -> np.ndarray:
    """Return each joint's largest travel over a gap and its neighbours; a tenth of the largest where it rests."""
    near = [np.abs(task.waypoints[k + 1] - task.waypoints[k]) for k in range(max(gap - 1, 0), min(gap + 2, GAPS))]
    travel = np.max(near, axis=0)
    return np.where(travel == 0, 0.1 * travel.max(), travel)


def anchors_of(task: TrajectoryTask, durations: np.ndarray) -> np.ndarray:
    """Return SciPy's spline through the waypoints at the knots, (GAPS per_gap + 1, n)."""
    degree, per_gap = DEGREES[task.family], task.virtual_knots + 1
    parts = durations.reshape(GAPS, per_gap)
    ends: list[list[Any]] = [[], []]
    for side in (0, 1):
        for order in range(1, (degree - 1) // 2 + 1):
            given = getattr(task.boundary, ENDS[order - 1])
            ends[side].append((degree - order, np.zeros(task.n)) if given is None else (order, given[side]))
    through = spline(degree, parts.sum(axis=1), np.asarray(task.waypoints), *ends)
    inside = [
        through.at(0, gap, parts[gap, :k].sum() / parts[gap].sum()) for gap in range(GAPS) for k in range(per_gap)
    ]
    return np.array([*inside, task.waypoints[-1]])


def motion_of(task: TrajectoryTask, durations: np.ndarray, offsets: np.ndarray) -> Motion:
    """Return SciPy's spline through waypoints and virtual knots; a free derivative is natural."""
    degree, per_gap = DEGREES[task.family], task.virtual_knots + 1
    knots, index = anchors_of(task, durations), 0
    for knot in range(len(knots)):
        if knot % per_gap:
            knots[knot] += offsets[index] * local_travel(task, knot // per_gap)
            index += 1
    ends: list[list[Any]] = [[], []]
    for side in (0, 1):
        for order in range(1, (degree - 1) // 2 + 1):
            given = getattr(task.boundary, ENDS[order - 1])
            instead = getattr(task.boundary, ENDS[degree - order - 1]) if degree - order <= 3 else None
            if given is None and instead is not None:
                order, given = degree - order, instead
            ends[side].append((degree - order, np.zeros(task.n)) if given is None else (order, given[side]))
    return spline(degree, durations, knots, *ends)


def decoded(nlp: CondensedNlp, x: np.ndarray) -> Motion:
    """Return the motion the problem makes of x, as SciPy's polynomials; for families that SciPy has not."""
    trajectory = nlp.decode(x)
    pieces = PPoly(np.moveaxis(np.asarray(trajectory.coefficients), 2, 0)[::-1], trajectory.breakpoints)
    return Motion(pieces, np.empty((len(trajectory.breakpoints), 3, nlp.task.n)))


def candidates(nlp: CondensedNlp, count: int = CANDIDATES) -> np.ndarray:
    return np.random.default_rng(12).uniform(nlp.lower, nlp.upper, (count, nlp.dimension))


def motion_for(nlp: CondensedNlp, x: np.ndarray, scale: float = 1.0) -> Motion:
    task = nlp.task
    if task.family not in DEGREES:
        return decoded(nlp, x)
    durations, offsets = durations_of(nlp, x), x[GAPS * (task.virtual_knots + 1) :]
    return motion_of(task, durations * scale, offsets.reshape(-1, task.n))


def grid(per_gap: int) -> list[float]:
    count = max(2, 2 * round(SAMPLES / (2 * per_gap)))
    return [1.0 - k / count for k in range(count + 1)]
