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


def motion_of(task: TrajectoryTask, durations: np.ndarray, offsets: np.ndarray) -> Motion:
    """Return SciPy's spline through waypoints and virtual knots; a free derivative is natural."""
    degree, per_gap = DEGREES[task.family], task.virtual_knots + 1
    knots = np.empty((GAPS * per_gap + 1, task.n))
    for knot in range(len(knots)):
        gap, share = min(knot // per_gap, GAPS - 1), knot / per_gap
        share -= gap
        knots[knot] = task.waypoints[gap] * (1 - share) + task.waypoints[gap + 1] * share
        if knot % per_gap:
            knots[knot] += (
                offsets[gap * (per_gap - 1) + knot % per_gap - 1] * np.ptp(task.waypoints, axis=0) / 2
            )
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
    durations = x[: nlp.segments] if str(nlp.encoding) == "durations" else np.exp(x[: nlp.segments])
    return motion_of(task, durations * scale, x[nlp.segments :].reshape(-1, task.n))


def grid(per_gap: int) -> list[float]:
    count = max(2, 2 * round(SAMPLES / (2 * per_gap)))
    return [1.0 - k / count for k in range(count + 1)]
