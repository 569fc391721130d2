"""Rows and costs of the lifted form that are functions of an instant: torques, powers, speeds, a user's own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.costs import InstantCost, instant_costs
from ocp_traj.limits import InstantLimit, instant_limits
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.lifted.composed import Composed, Split
from ocp_traj.transcription.lifted.instant_derivatives import Outer, outer_of
from ocp_traj.transcription.lifted.layout import Layout
from ocp_traj.transcription.lifted.parts import Parts
from ocp_traj.transcription.nlp import RowBlock
from ocp_traj.transcription.quadrature import even_intervals, simpson_weights

COST_SAMPLES, COST_SAMPLES_OF_HIGHER_DEGREE = 8, 20
"""Samples a gap over which costs are integrated, at least: of cubics, and of quintics and septics."""


@dataclass(frozen=True)
class Nodes:
    """Points of a quadrature over the whole motion.

    Attributes
    ----------
    at : (N, 2) array of (segment, fraction)
    weights : (N,)
        Of a segment of unit duration.
    """

    at: Array
    weights: Array


def add_instants(
    parts: Parts,
    layout: Layout,
    guess: Trajectory,
    samples: int,
    extra: tuple[tuple[int, float], ...],
    compiled: bool,
) -> None:
    """Add what a task asks of every instant, at regular samples and at points found broken.

    Parameters
    ----------
    parts : Parts
    layout : Layout
    guess : Trajectory
        Gives the size of the values that have no limit.
    samples : int
        Samples a gap of limits; costs are integrated over at least `COST_SAMPLES`, or more for higher degrees.
    extra : tuple of (segment, fraction)
        More samples of the limits.
    compiled : bool
        Use machine code where there is a C compiler.
    """
    points = np.concatenate([_make_grid(layout, samples), np.array(extra, dtype=np.float64).reshape(-1, 2)])
    for constraint in instant_limits(layout.task):
        _add_constraint(parts, layout, constraint, points, compiled)
    nodes = _simpson(layout, samples)
    for term in instant_costs(layout.task):
        if term.shape == "sum":
            _add_smooth_term(parts, layout, term, nodes, compiled)
        else:
            _add_kinked_term(parts, layout, term, nodes, guess, compiled)


def _make_grid(layout: Layout, samples: int) -> Array:
    """Return (segment, fraction) of the regular samples; a knot belongs to the segment it starts."""
    segments, count = layout.segments, even_intervals(samples, layout.per_gap)
    segment = np.repeat(np.arange(segments, dtype=np.float64), count)
    fraction = np.tile(np.arange(count) / count, segments)
    regular = np.column_stack([segment, fraction])
    return np.concatenate([regular, [[segments - 1.0, 1.0]]])


def _simpson(layout: Layout, samples: int) -> Nodes:
    """Return Simpson's rule on every segment."""
    least = COST_SAMPLES if layout.degree == 3 else COST_SAMPLES_OF_HIGHER_DEGREE
    count, segments = even_intervals(max(samples, least), layout.per_gap), layout.segments
    segment = np.repeat(np.arange(segments, dtype=np.float64), count + 1)
    at = np.column_stack([segment, np.tile(np.arange(count + 1) / count, segments)])
    return Nodes(at, np.tile(simpson_weights(count), segments))


def _split(at: Array) -> list[tuple[bool, Any]]:
    """Return the rows of `at` that are knots and those that are not."""
    knots = (at[:, 1] == 0.0) | (at[:, 1] == 1.0)
    parts = [(True, np.flatnonzero(knots)), (False, np.flatnonzero(~knots))]
    return [(at_knot, rows) for at_knot, rows in parts if len(rows)]


def _label(layout: Layout, name: str, at: Array, joints: Any) -> RowBlock:
    segment, fraction = np.repeat(at[:, 0].astype(np.int64), len(joints)), np.repeat(at[:, 1], len(joints))
    return layout.label(name, segment, np.tile(joints, len(at)), fraction)


def _add_constraint(
    parts: Parts, layout: Layout, constraint: InstantLimit, points: Array, compiled: bool
) -> None:
    task, needs_jerk = layout.task, constraint.needs_jerk
    function = constraint.function(task)
    outer = outer_of(function, needs_jerk=needs_jerk, total=False, compiled=compiled)
    bounds = constraint.bounds(task)
    scale = np.where(np.isfinite(bounds).any(axis=1), constraint.scales(task), 0.0).max(axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    if needs_jerk:  # the jerk may jump at knots: take both sides
        ends = np.column_stack([np.arange(layout.segments - 1.0), np.ones(layout.segments - 1)])
        groups = [(False, np.concatenate([points, ends]))]
    else:
        groups = [(at_knot, points[rows]) for at_knot, rows in _split(points)]
    joints = np.asarray(constraint.joints(task))
    for at_knot, at in groups:
        places = Composed(layout, outer, at, scale, at_knot=at_knot, needs_jerk=needs_jerk)
        gaps = at[:, 0].astype(np.int64) // layout.per_gap
        lower, upper = bounds[gaps, 0] / scale, bounds[gaps, 1] / scale
        if at_knot:  # a knot between two gaps keeps the limits of both
            before = np.maximum(at[:, 0].astype(np.int64) - (at[:, 1] == 0.0), 0) // layout.per_gap
            lower = np.maximum(lower, bounds[before, 0] / scale)
            upper = np.minimum(upper, bounds[before, 1] / scale)
        parts.add(places, lower, upper, _label(layout, constraint.name, at, joints))


def _add_smooth_term(parts: Parts, layout: Layout, term: InstantCost, nodes: Nodes, compiled: bool) -> None:
    """Add Simpson's rule over every segment."""
    function = term.function(layout.task)
    outer = outer_of(function, needs_jerk=False, total=True, compiled=compiled)
    for at_knot, rows in _split(nodes.at):
        weights = nodes.weights[rows]
        places = Composed(layout, outer, nodes.at[rows], np.ones(1), weights=weights, at_knot=at_knot)
        parts.costs.append((places, np.full(len(rows), term.weight(layout.task))))


def _add_kinked_term(
    parts: Parts, layout: Layout, term: InstantCost, nodes: Nodes, guess: Trajectory, compiled: bool
) -> None:
    """Integrate |value| or max(value, 0): duration * value = plus - minus at every sample.

    The cost is on plus (and minus), linear because the duration is inside the row.
    """
    function = term.function(layout.task)
    outer = outer_of(function, needs_jerk=False, total=False, compiled=compiled)
    at = nodes.at
    durations = np.diff(guess.breakpoints)[at[:, 0].astype(np.int64)]
    start = _values_along(guess, outer, at) * durations[:, None]
    scale = float(np.abs(start).max()) or 1.0
    plus = parts.add_slacks(np.maximum(start, 0.0) / scale + 1e-2)
    minus = parts.add_slacks(np.maximum(-start, 0.0) / scale + 1e-2)
    for at_knot, rows in _split(at):
        scales, ones = np.full(outer.rows, scale), np.ones(len(rows))
        places = Composed(layout, outer, at[rows], scales, weights=ones, at_knot=at_knot)
        label = _label(layout, term.name, at[rows], np.full(outer.rows, -1))
        parts.add(Split(places, plus[rows], minus[rows]), 0.0, 0.0, label)
    unit = term.weight(layout.task) * scale * np.repeat(nodes.weights, outer.rows)
    parts.add_linear_cost(plus.ravel(), unit)
    if term.shape == "absolute":
        parts.add_linear_cost(minus.ravel(), unit)


def _values_along(motion: Trajectory, outer: Outer, at: Array) -> Array:
    """Evaluate a function of an instant along a motion at samples, (N, k)."""
    segment = at[:, 0].astype(np.int64)
    breakpoints = np.asarray(motion.breakpoints)
    t = breakpoints[segment] + at[:, 1] * np.diff(breakpoints)[segment]
    u = np.concatenate([motion(t, order) for order in range(3)], axis=1).T
    return np.array(outer.functions["value"].map(len(t))(u)).T
