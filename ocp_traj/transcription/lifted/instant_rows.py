"""Rows and costs of the lifted form that are functions of an instant: torques, powers, speeds, a user's own."""

from __future__ import annotations

from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.costs import InstantCost, instant_costs
from ocp_traj.instant import FunctionOfInstant
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


class InstantRows:
    """Adds what a task asks of every instant at regular samples and at points found broken.

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

    def __init__(
        self,
        parts: Parts,
        layout: Layout,
        guess: Trajectory,
        samples: int,
        extra: tuple[tuple[int, float], ...],
        compiled: bool,
    ) -> None:
        self.parts, self.layout, self.guess = parts, layout, guess
        self.samples, self.compiled = samples, compiled
        points = np.concatenate([self._make_grid(), np.array(extra, dtype=np.float64).reshape(-1, 2)])
        for constraint in instant_limits(layout.task):
            self._add_constraint(constraint, points)
        for term in instant_costs(layout.task):
            if term.shape == "sum":
                self._add_smooth_term(term)
            else:
                self._add_kinked_term(term)

    def _per_segment(self, samples: int) -> int:
        """Return the samples a segment, an even number of at least 2."""
        return even_intervals(samples, self.layout.per_gap)

    def _make_grid(self) -> Array:
        """Return (segment, fraction) of the regular samples; a knot belongs to the segment it starts."""
        segments, count = self.layout.segments, self._per_segment(self.samples)
        segment = np.repeat(np.arange(segments, dtype=np.float64), count)
        fraction = np.tile(np.arange(count) / count, segments)
        regular = np.column_stack([segment, fraction])
        return np.concatenate([regular, [[segments - 1.0, 1.0]]])

    def _outer(self, part: FunctionOfInstant, *, total: bool = False) -> Outer:
        function = part.function(self.layout.task)
        return outer_of(function, needs_jerk=part.needs_jerk, total=total, compiled=self.compiled)

    def _split(self, at: Array) -> list[tuple[bool, Any]]:
        """Return the rows of `at` that are knots and those that are not."""
        knots = (at[:, 1] == 0.0) | (at[:, 1] == 1.0)
        parts = [(True, np.flatnonzero(knots)), (False, np.flatnonzero(~knots))]
        return [(at_knot, rows) for at_knot, rows in parts if len(rows)]

    def _add_constraint(self, constraint: InstantLimit, points: Array) -> None:
        task, layout = self.layout.task, self.layout
        outer = self._outer(constraint)
        bounds = constraint.bounds(task)
        scale = np.where(np.isfinite(bounds).any(axis=1), constraint.scales(task), 0.0).max(axis=0)
        scale = np.where(scale > 0, scale, 1.0)
        if constraint.needs_jerk:  # the jerk may jump at knots: take both sides
            ends = np.column_stack([np.arange(layout.segments - 1.0), np.ones(layout.segments - 1)])
            groups = [(False, np.concatenate([points, ends]))]
        else:
            groups = [(at_knot, points[rows]) for at_knot, rows in self._split(points)]
        joints = np.asarray(constraint.joints(task))
        for at_knot, at in groups:
            places = Composed(layout, outer, at, scale, at_knot=at_knot, needs_jerk=constraint.needs_jerk)
            gaps = at[:, 0].astype(np.int64) // layout.per_gap
            lower, upper = bounds[gaps, 0] / scale, bounds[gaps, 1] / scale
            if at_knot:  # a knot between two gaps keeps the limits of both
                before = np.maximum(at[:, 0].astype(np.int64) - (at[:, 1] == 0.0), 0) // layout.per_gap
                lower = np.maximum(lower, bounds[before, 0] / scale)
                upper = np.minimum(upper, bounds[before, 1] / scale)
            self.parts.add(places, lower, upper, self._label(constraint.name, at, joints))

    def _label(self, name: str, at: Array, joints: Any) -> RowBlock:
        per_gap = self.layout.per_gap
        segment = np.repeat(at[:, 0].astype(np.int64), len(joints))
        inside = (segment % per_gap + np.repeat(at[:, 1], len(joints))) / per_gap
        return RowBlock(name, np.tile(joints, len(at)), segment // per_gap, inside)

    def _simpson(self) -> tuple[Array, Array]:
        """Return points and weights of Simpson's rule on every segment of unit duration."""
        least = COST_SAMPLES if self.layout.degree == 3 else COST_SAMPLES_OF_HIGHER_DEGREE
        count, segments = self._per_segment(max(self.samples, least)), self.layout.segments
        segment = np.repeat(np.arange(segments, dtype=np.float64), count + 1)
        at = np.column_stack([segment, np.tile(np.arange(count + 1) / count, segments)])
        return at, np.tile(simpson_weights(count), segments)

    def _add_smooth_term(self, term: InstantCost) -> None:
        """Add Simpson's rule over every segment."""
        outer = self._outer(term, total=True)
        at, weights = self._simpson()
        for at_knot, rows in self._split(at):
            places = Composed(
                self.layout, outer, at[rows], np.ones(1), weights=weights[rows], at_knot=at_knot
            )
            self.parts.costs.append((places, np.full(len(rows), term.weight(self.layout.task))))

    def _add_kinked_term(self, term: InstantCost) -> None:
        """Integrate |value| or max(value, 0): duration * value = plus - minus at every sample.

        The cost is on plus (and minus), linear because the duration is inside the row.
        """
        layout = self.layout
        outer = self._outer(term)
        at, weights = self._simpson()
        durations = np.diff(self.guess.breakpoints)[at[:, 0].astype(np.int64)]
        guess = self._values_on_guess(outer, at) * durations[:, None]
        scale = float(np.abs(guess).max()) or 1.0
        plus = self.parts.add_slacks(np.maximum(guess, 0.0) / scale + 1e-2)
        minus = self.parts.add_slacks(np.maximum(-guess, 0.0) / scale + 1e-2)
        for at_knot, rows in self._split(at):
            places = Composed(
                layout,
                outer,
                at[rows],
                np.full(outer.rows, scale),
                weights=np.ones(len(rows)),
                at_knot=at_knot,
            )
            label = self._label(term.name, at[rows], np.full(outer.rows, -1))
            self.parts.add(Split(places, plus[rows], minus[rows]), 0.0, 0.0, label)
        unit = term.weight(layout.task) * scale * np.repeat(weights, outer.rows)
        self.parts.add_linear_cost(plus.ravel(), unit)
        if term.shape == "absolute":
            self.parts.add_linear_cost(minus.ravel(), unit)

    def _values_on_guess(self, outer: Outer, at: Array) -> Array:
        """Evaluate a function of an instant along the guess at samples, (N, k)."""
        segment = at[:, 0].astype(np.int64)
        breakpoints = np.asarray(self.guess.breakpoints)
        t = breakpoints[segment] + at[:, 1] * np.diff(breakpoints)[segment]
        u = np.concatenate([self.guess(t, order) for order in range(3)], axis=1).T
        values: Array = np.array(outer.functions["value"].map(len(t))(u)).T
        return values
