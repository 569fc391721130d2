"""The nearest variables of the lifted form that are exactly a spline, with durations inside their bounds.

A solver leaves small defects between knot states. A spline through the knots' positions alone would turn a defect d
over a segment of duration h into d / h^2 of acceleration; the least change of all scaled states does not.
"""

from __future__ import annotations

from math import factorial
from typing import Any

import numpy as np
import scipy.sparse as sparse

from ocp_traj.arrays import Array
from ocp_traj.transcription.lifted.layout import Layout
from ocp_traj.transcription.lifted.state_bounds import state_bounds

LARGEST_DEFECT = 1e-3
"""Defects, in scaled units, above which variables are no motion yet and stay as they are."""

LARGEST_MISS = 1e-4
"""Relative miss of a bound of durations that counts as rounding."""

ROUNDS = 2
"""Linear solves: the second takes out the rounding of the first."""


def consistent_variables(layout: Layout, x: Array) -> Array:
    """Return durations inside their bounds and states without defects, as near to x as possible.

    Durations that miss their bounds by rounding are scaled by gaps, then in total. With durations held the defects
    are linear in the states, so the least change of the scaled states solves one sparse linear system; given states
    at the ends and the positions at waypoints are held.

    Parameters
    ----------
    layout : Layout
    x : (layout.size,)
    """
    x = np.array(x, dtype=np.float64)
    if not np.isfinite(x).all() or not (x[: layout.segments] > 0).all():
        return x
    _scale_durations(layout, x)
    if not layout.task.virtual_knots or not len(layout.moving):
        return x  # positions at waypoints and durations decide the spline
    held, values = _held(layout, x)
    start = np.array(x)
    start[held] = values
    matrix, wanted = _conditions(layout, start)
    if max(np.abs(start - x).max(), np.abs(matrix @ start - wanted).max()) > LARGEST_DEFECT:
        return x
    free = np.setdiff1d(np.arange(layout.segments, layout.size), held)
    change = _least_change(matrix[:, free], matrix, start, free, wanted)
    return change if np.isfinite(change).all() else x


def _scale_durations(layout: Layout, x: Array) -> None:
    """Bring the durations of gaps, then of all, into their bounds where only rounding kept them out."""
    objective = layout.task.objective
    parts = [slice(gap * layout.per_gap, (gap + 1) * layout.per_gap) for gap in range(layout.task.gaps)]
    intervals = [*zip(parts, np.asarray(objective.gap_durations))]
    intervals.append((slice(0, layout.segments), np.asarray(objective.duration)))
    for part, (low, high) in intervals:
        total = float(x[part].sum()) * layout.duration_scale
        factor = float(np.clip(total, low, high)) / total
        if 0.0 < abs(factor - 1.0) < LARGEST_MISS:
            x[part] *= factor


def _held(layout: Layout, x: Array) -> tuple[Any, Array]:
    """Return the states that no change may touch, positions at waypoints and what is given at the ends; their values.

    A waypoint with a box stays where it is in it.
    """
    lower, upper = state_bounds(layout)
    joints = np.arange(len(layout.moving))
    knots = np.arange(layout.task.gaps + 1)[:, None] * layout.per_gap
    ends = [layout.state(knot, joints[:, None], np.arange(layout.degree)) for knot in (0, layout.segments)]
    at_ends = np.concatenate([end.ravel() for end in ends])
    given = at_ends[lower[at_ends] == upper[at_ends]]
    held = np.union1d(given, layout.state(knots, joints[None, :], 0).ravel())
    return held, np.clip(x[held], lower[held], upper[held])


def _conditions(layout: Layout, x: Array) -> tuple[Any, Array]:
    """Return the matrix (rows, size) and the right side of the conditions on the states, durations held.

    They are the defects of `defect_formula`, and a cubic's given end jerks.
    """
    degree, (segment, joint) = layout.degree, layout.places
    h = x[segment] * layout.duration_scale
    scales = layout.state_scales[:, joint]
    rows, columns, values = [], [], []
    top = degree - 1
    for order in range(top):
        row = np.arange(len(segment)) * top + order
        on_top = scales[top] / scales[order] * h ** (top - order) / factorial(degree - order)
        entries = [
            (layout.state(segment, joint, i), scales[i] / scales[order] * h ** (i - order) / factorial(i - order))
            for i in range(order, degree)
        ]
        entries += [
            (layout.state(segment, joint, top), -on_top),
            (layout.state(segment + 1, joint, top), on_top),
            (layout.state(segment + 1, joint, order), np.full(len(segment), -1.0)),
        ]
        for column, value in entries:
            rows.append(row)
            columns.append(column)
            values.append(value)
    count = len(segment) * top
    matrix = sparse.csr_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(count, layout.size)
    )
    jerk_rows, wanted = _end_jerks(layout, x)
    return sparse.vstack([matrix, jerk_rows], format="csr"), np.concatenate([np.zeros(count), wanted])


def _end_jerks(layout: Layout, x: Array) -> tuple[Any, Array]:
    """Return the conditions that a cubic's given end jerks are."""
    given = layout.task.boundary.jerk
    if given is None or layout.degree != 3:
        return sparse.csr_matrix((0, layout.size)), np.empty(0)
    joints = np.arange(len(layout.moving))
    segment = np.repeat([0, layout.segments - 1], len(joints))
    joint = np.tile(joints, 2)
    row = np.arange(len(joint))
    columns = np.concatenate([layout.state(segment + 1, joint, 2), layout.state(segment, joint, 2)])
    values = np.concatenate([np.ones(len(row)), -np.ones(len(row))])
    jerk = np.asarray(given)[:, layout.moving].ravel()
    wanted = jerk * x[segment] * layout.duration_scale / layout.state_scales[2, joint]
    return sparse.csr_matrix((values, (np.tile(row, 2), columns)), shape=(len(row), layout.size)), wanted


def _least_change(part: Any, matrix: Any, x: Array, free: Any, wanted: Array) -> Array:
    """Return x with the least change of its free entries that fulfils matrix @ x = wanted."""
    from scipy.sparse.linalg import splu  # loads slowly, and a problem without virtual knots needs none of it

    count = len(wanted)
    small = 1e-15 * sparse.identity(count)
    system = sparse.bmat([[sparse.identity(len(free)), part.T], [part, -small]], format="csc")
    factors = splu(system)
    changed = np.array(x)
    for _ in range(ROUNDS):
        residual = wanted - matrix @ changed
        changed[free] += factors.solve(np.concatenate([np.zeros(len(free)), residual]))[: len(free)]
    return changed
