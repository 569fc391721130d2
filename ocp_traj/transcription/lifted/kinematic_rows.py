"""Rows and costs of the lifted form that follow from the polynomials alone, without the robot."""

from __future__ import annotations

from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.costs import SQUARED_DERIVATIVES
from ocp_traj.limits import DERIVATIVE_LIMITS, DerivativeLimit
from ocp_traj.limits.limit import bound_scales
from ocp_traj.transcription.duration_rows import duration_rows
from ocp_traj.transcription.lifted.chain import (
    bernstein_formula,
    defect_formula,
    sample_formula,
    squared_formula,
)
from ocp_traj.transcription.lifted.elements import Elements, IndexArray
from ocp_traj.transcription.lifted.layout import Layout
from ocp_traj.transcription.lifted.parts import Parts
from ocp_traj.transcription.nlp import RowBlock

DerivativePoints = tuple[tuple[int, int, int, float], ...]
"""(order, segment, moving joint, fraction) of single derivatives."""


def add_kinematics(parts: Parts, layout: Layout, extra: DerivativePoints) -> None:
    """Add continuity, limits of derivatives, bounds of durations and smoothness costs."""
    _add_defects(parts, layout)
    for limit in DERIVATIVE_LIMITS:
        if limit.applies(layout.task) and len(layout.moving):
            _add_limit(parts, layout, limit, extra)
    _add_durations(parts, layout)
    _add_end_jerk(parts, layout)
    for term in SQUARED_DERIVATIVES:
        if term.weight(layout.task) > 0:
            _add_squared(parts, layout, term.order, term.weight(layout.task))


def inner_fractions(degree: int) -> list[float]:
    """Return where inside a segment velocity and higher derivatives are limited at first; nowhere for cubics."""
    intervals = 2 ** ((degree - 1) // 2) if degree > 3 else 1
    return [k / intervals for k in range(1, intervals)]


def place_label(layout: Layout, limit: str, segment: Any, joint: Any, fraction: Any) -> RowBlock:
    """Return labels of rows; `joint` counts moving joints, `fraction` is of the segment."""
    return layout.label(limit, segment, np.asarray(layout.moving)[joint], fraction)


def _states_around(layout: Layout, segment: IndexArray, joint: IndexArray, first: int) -> IndexArray:
    """Return indices of duration, states `first` to p - 1 at the start and state p - 1 at the end, (N, .)."""
    orders = np.arange(first, layout.degree)[None, :]
    start = layout.state(segment[:, None], joint[:, None], orders)
    end = layout.state(segment + 1, joint, layout.degree - 1)
    return np.column_stack([segment, start, end])


def _add_defects(parts: Parts, layout: Layout) -> None:
    segment, joint = layout.places
    if not len(joint):
        return
    orders = np.arange(layout.degree)[None, :]
    start = layout.state(segment[:, None], joint[:, None], orders)
    end = layout.state(segment[:, None] + 1, joint[:, None], orders)
    variables = np.concatenate([segment[:, None], start, end], axis=1)
    parameters = np.column_stack(
        [layout.state_scales[:, joint].T, np.full(len(joint), layout.duration_scale)]
    )
    elements = Elements(defect_formula(layout.degree), variables, parameters)
    rows = elements.rows
    label = place_label(layout, "continuity", np.repeat(segment, rows), np.repeat(joint, rows), 1.0)
    parts.add(elements, 0.0, 0.0, label)


def _add_limit(parts: Parts, layout: Layout, limit: DerivativeLimit, extra: DerivativePoints) -> None:
    """Limit a derivative between the knots, where it is not a state.

    The highest derivative is constant in a segment; the one below is linear, so knots are enough. The velocity of a
    cubic with virtual knots is bounded by its Bernstein coefficient, all else at samples and found points.
    """
    if limit.order == layout.degree:
        _add_top_limit(parts, layout, limit)
        return
    segment, joint = layout.places
    inner = inner_fractions(layout.degree) if 0 < limit.order < layout.degree - 1 else []
    places = [(segment, joint, np.full(len(segment), fraction)) for fraction in inner]
    if layout.degree == 3 and limit.order == 1 and not layout.task.virtual_knots:
        quick = _quick_joints(layout)[joint]
        places.append((segment[quick], joint[quick], np.full(int(quick.sum()), 0.5)))
    found = np.array([point[1:] for point in extra if point[0] == limit.order]).reshape(-1, 3)
    places.append((found[:, 0].astype(np.int64), found[:, 1].astype(np.int64), found[:, 2]))
    if layout.degree == 3 and limit.order == 1 and layout.task.virtual_knots:
        _add_sampled(parts, layout, limit, segment, joint, np.full(len(segment), 0.5), bernstein=True)
    joined = [np.concatenate(columns) for columns in zip(*places)]
    _add_sampled(parts, layout, limit, *joined, bernstein=False)


def _quick_joints(layout: Layout) -> Any:
    """Return which moving joints have no acceleration limit that counts, (n',) bool.

    A cubic's velocity is limited at its knots; joints that move alike may all rest there, and then nothing else keeps
    them from passing between in no time.
    """
    most = np.abs(layout.task.limits.get("acceleration")).max(axis=(0, 1))[layout.moving]
    return ~(most <= layout.state_scales[2])


def _add_sampled(
    parts: Parts,
    layout: Layout,
    limit: DerivativeLimit,
    segment: Any,
    joint: Any,
    fraction: Array,
    *,
    bernstein: bool,
) -> None:
    bounds = limit.bounds(layout.task)[segment // layout.per_gap, :, np.asarray(layout.moving)[joint]]
    keep = np.isfinite(bounds).any(axis=1)
    segment, joint, fraction, bounds = segment[keep], joint[keep], fraction[keep], bounds[keep]
    if not len(segment):
        return
    scale = bound_scales(bounds.T, layout.state_scales[limit.order][joint])
    variables = _states_around(layout, segment, joint, limit.order)
    count = np.full(len(joint), layout.duration_scale)
    parameters = np.column_stack([layout.state_scales[limit.order :, joint].T, count, fraction, scale])
    formula = bernstein_formula() if bernstein else sample_formula(layout.degree, limit.order)
    parts.add(
        Elements(formula, variables[:, :3] if bernstein else variables, parameters),
        (bounds[:, 0] / scale)[:, None],
        (bounds[:, 1] / scale)[:, None],
        place_label(layout, limit.name, segment, joint, fraction),
    )


def _add_top_limit(parts: Parts, layout: Layout, limit: DerivativeLimit) -> None:
    """Limit the constant derivative p of every segment: linear in the states and the duration."""
    segment, joint = layout.places
    bounds = limit.bounds(layout.task)[segment // layout.per_gap, :, np.asarray(layout.moving)[joint]]
    unit = layout.duration_scale / layout.state_scales[layout.degree - 1, joint]
    top = layout.degree - 1
    columns = np.column_stack(
        [layout.state(segment + 1, joint, top), layout.state(segment, joint, top), segment]
    )
    for side, sign in ((1, 1.0), (0, -1.0)):
        keep = np.isfinite(bounds[:, side])
        if keep.any():
            factor = (sign * bounds[:, side] * unit)[keep]
            values = np.column_stack([np.full(len(factor), sign), np.full(len(factor), -sign), -factor])
            label = place_label(layout, limit.name, segment[keep], joint[keep], 0.5)
            parts.add_linear(columns[keep], values, -np.inf, 0.0, label)


def _add_durations(parts: Parts, layout: Layout) -> None:
    """Bound the total duration and the durations of gaps."""
    for row in duration_rows(layout.task):
        unit = layout.duration_scale / row.scale
        parts.add_linear(row.segments[None, :], unit, row.lower, row.upper, row.label)


def _add_end_jerk(parts: Parts, layout: Layout) -> None:
    """Impose a given end jerk on a cubic, whose jerk is no state but constant in the first and last segment."""
    given = layout.task.boundary.jerk
    if given is None or layout.degree != 3:
        return
    joints = np.arange(len(layout.moving))
    unit = layout.duration_scale / layout.state_scales[2]
    for side, segment in ((0, 0), (1, layout.segments - 1)):
        columns = np.column_stack(
            [
                layout.state(segment + 1, joints, 2),
                layout.state(segment, joints, 2),
                np.full(len(joints), segment),
            ]
        )
        jerk = np.asarray(given)[side, layout.moving]
        values = np.column_stack([np.ones(len(joints)), -np.ones(len(joints)), -jerk * unit])
        label = place_label(layout, "boundary jerk", np.full(len(joints), segment), joints, float(side))
        parts.add_linear(columns, values, 0.0, 0.0, label)


def _add_squared(parts: Parts, layout: Layout, order: int, weight: float) -> None:
    segment, joint = layout.places
    if not len(joint):  # where no joint moves, nothing is squared
        return
    first = min(order, layout.degree - 1)
    variables = _states_around(layout, segment, joint, first)
    parameters = np.column_stack(
        [layout.state_scales[first:, joint].T, np.full(len(joint), layout.duration_scale)]
    )
    elements = Elements(squared_formula(layout.degree, order), variables, parameters)
    parts.costs.append((elements, np.full(elements.count, weight)))
