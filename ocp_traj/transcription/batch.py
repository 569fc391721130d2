"""A whole population of curves at once: durations to splines, and splines to samples, in NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.spline import Piece, get_family
from ocp_traj.spline.hermite import derivative_row, hermite_matrix
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.curve import decided_knots, end_conditions


@dataclass(frozen=True)
class CurveBatch:
    """Curves of p candidates.

    Attributes
    ----------
    durations : (p, S) of all segments, s
    groups : tuple of (degree, segments, states)
        Segments of one degree, with their scaled end states (2 r + 2, segments, p, n).
    """

    durations: Array
    groups: tuple[tuple[int, Any, Array], ...]

    def sample(self, order: int, fractions: Array) -> Array:
        """Return a derivative at `fractions` of every segment, (S, N, p, n)."""
        count, p = self.durations.shape[1], self.durations.shape[0]
        n = self.groups[0][2].shape[3]
        values = np.empty((count, len(fractions), p, n))
        for degree, segments, states in self.groups:
            rows = sample_rows(degree, order, tuple(fractions))
            flat = rows @ states.reshape(states.shape[0], -1)
            values[segments] = np.moveaxis(flat.reshape(len(fractions), len(segments), p, n), 1, 0)
        if order:
            values /= (self.durations.T**order)[:, None, :, None]
        return values

    def coefficients(self, degree: int, segments: Any, states: Array) -> Array:
        """Return ascending coefficients in normalised time, (degree + 1, segments, p, n)."""
        flat = hermite_matrix(degree) @ states.reshape(states.shape[0], -1)
        return flat.reshape(degree + 1, len(segments), *states.shape[2:])


_ROWS: dict[tuple[int, int, tuple[float, ...]], Array] = {}


def sample_rows(degree: int, order: int, fractions: tuple[float, ...]) -> Array:
    """Return the (N, degree + 1) matrix from scaled end states to derivatives by tau at `fractions`."""
    key = (degree, order, fractions)
    if key not in _ROWS:
        rows = np.stack([derivative_row(degree, order, float(fraction)) for fraction in fractions])
        _ROWS[key] = rows @ hermite_matrix(degree)
    return _ROWS[key]


def knot_positions(task: TrajectoryTask, offsets: Array) -> list[Any]:
    """Return positions at all knots, each (1 or p, n), from offsets (p, virtual knots of all gaps, n).

    An offset is measured from the chord between the waypoints, at the knot's share of the gap's segments, in units
    of half the joint's travel in the case. Positions that the end conditions decide are None.
    """
    per_gap = task.virtual_knots + 1
    half = np.ptp(task.waypoints, axis=0) / 2
    positions: list[Any] = []
    for gap in range(task.gaps):
        start, end = task.waypoints[gap][None, :], task.waypoints[gap + 1][None, :]
        positions.append(start)
        for knot in range(1, per_gap):
            chord = start + (end - start) * (knot / per_gap)
            positions.append(chord + half * offsets[:, gap * task.virtual_knots + knot - 1])
    positions.append(task.waypoints[-1][None, :])
    starts, ends = decided_knots(task)
    for knot in (*starts, *ends):
        positions[knot] = None
    return positions


def build_curves(task: TrajectoryTask, durations: Array, offsets: Array) -> CurveBatch:
    """Return the curves of p candidates.

    Parameters
    ----------
    durations : (p, S) s
    offsets : (p, virtual knots, n)
    """
    columns = [np.ascontiguousarray(durations[:, [k]]) for k in range(durations.shape[1])]
    pieces = get_family(task.family).pieces(columns, knot_positions(task, offsets), end_conditions(task))
    shape = (durations.shape[0], task.n)
    groups = []
    for degree in sorted({piece.degree for piece in pieces}):
        segments = np.array([index for index, piece in enumerate(pieces) if piece.degree == degree])
        groups.append((degree, segments, _stack_states([pieces[index] for index in segments], shape)))
    return CurveBatch(durations, tuple(groups))


def _stack_states(pieces: list[Piece], shape: tuple[int, int]) -> Array:
    states = np.empty((len(pieces[0].states), len(pieces), *shape))
    for index, piece in enumerate(pieces):
        for row, state in enumerate(piece.states):
            states[row, index] = state
    return states
