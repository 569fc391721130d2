"""Bounds of the lifted form's variables: shortest durations, limits at the knots, waypoints and end conditions."""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.limits import DERIVATIVE_LIMITS, DerivativeLimit
from ocp_traj.transcription.curve import end_conditions
from ocp_traj.transcription.lifted.layout import Layout


def state_bounds(layout: Layout) -> tuple[Array, Array]:
    """Return lower and upper bounds of durations and knot states."""
    lower, upper = np.full(layout.size, -np.inf), np.full(layout.size, np.inf)
    lower[: layout.segments] = layout.shortest
    for limit in DERIVATIVE_LIMITS:
        if limit.order < layout.degree and limit.applies(layout.task):
            _bound_states(layout, limit, lower, upper)
    _fix_states(layout, lower, upper)
    return lower, upper


def _bound_states(layout: Layout, limit: DerivativeLimit, lower: Array, upper: Array) -> None:
    """Bound knot states by the limits of both neighbouring gaps."""
    bounds = limit.bounds(layout.task)
    knots = np.arange(layout.segments + 1)
    left, right = layout.knot_gaps(knots)
    scale = layout.state_scales[limit.order]
    low = np.maximum(bounds[left, 0], bounds[right, 0])[:, layout.moving] / scale
    high = np.minimum(bounds[left, 1], bounds[right, 1])[:, layout.moving] / scale
    index = layout.state(knots[:, None], np.arange(len(layout.moving))[None, :], limit.order)
    lower[index], upper[index] = low, high


def _fix_states(layout: Layout, lower: Array, upper: Array) -> None:
    """Fix waypoints (or their boxes) and the given or natural states at both ends."""
    task = layout.task
    joints = np.arange(len(layout.moving))
    tolerance = np.asarray(task.tolerance)[:, layout.moving] / layout.state_scales[0]
    waypoints = task.waypoints[:, layout.moving] / layout.state_scales[0]
    index = layout.state(np.arange(task.gaps + 1)[:, None] * layout.per_gap, joints[None, :], 0)
    free = tolerance > 0
    lower[index] = np.where(free, np.maximum(lower[index], waypoints - tolerance), waypoints)
    upper[index] = np.where(free, np.minimum(upper[index], waypoints + tolerance), waypoints)
    _turn_at_limits(layout, lower, upper)
    ends = end_conditions(task)
    for knot, given in ((0, ends.start), (layout.segments, ends.end)):
        natural = {
            layout.degree - order for order in range(1, (layout.degree + 1) // 2) if order not in given
        }
        for order, value in {**dict.fromkeys(natural, np.zeros((1, task.n))), **given}.items():
            if order < layout.degree:
                index = layout.state(knot, joints, order)
                lower[index] = upper[index] = value[0, layout.moving] / layout.state_scales[order]


def _turn_at_limits(layout: Layout, lower: Array, upper: Array) -> None:
    """Fix the velocity at inner waypoints that lie on a position limit: passing them with speed would cross it."""
    task = layout.task
    position = task.limits.get("position")
    for waypoint in range(1, task.gaps):
        at = task.waypoints[waypoint, layout.moving]
        low = np.maximum(position[waypoint - 1, 0], position[waypoint, 0])[layout.moving]
        high = np.minimum(position[waypoint - 1, 1], position[waypoint, 1])[layout.moving]
        exact = np.asarray(task.tolerance)[waypoint, layout.moving] == 0
        touching = np.flatnonzero(exact & ((at <= low) | (at >= high)))
        index = layout.state(waypoint * layout.per_gap, touching, 1)
        lower[index] = upper[index] = 0.0
