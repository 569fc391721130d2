"""The lifted form: durations of all segments, and every knot's state, tied by the chain of integrators."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.sparse as sparse

from ocp_traj.arrays import Array
from ocp_traj.constraints import DERIVATIVE_LIMITS, DerivativeLimit
from ocp_traj.nlp import Nlp, RowBlock
from ocp_traj.objectives import SQUARED_DERIVATIVES, SampledTerm
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.assembly import assemble
from ocp_traj.transcription.chain import bernstein_formula, defect_formula, sample_formula, squared_formula
from ocp_traj.transcription.curve import build_trajectory
from ocp_traj.transcription.elements import Elements
from ocp_traj.transcription.layout import Layout, make_layout
from ocp_traj.transcription.samples import Instant, instant_function, instant_of, state_formula, state_variables

MINIMUM_FRACTION = 1e-3
"""Shortest duration of a segment, in mean segment durations of the guess."""

INNER_FRACTIONS = {3: (), 5: (0.25, 0.5, 0.75), 7: (0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875)}
"""Where inside a segment velocity and lower derivatives are limited at first, by degree; see `ExtraPoints`."""


@dataclass(frozen=True)
class ExtraPoints:
    """Points between the first samples where limits were found broken; a solver adds them and solves again.

    Attributes
    ----------
    derivatives : tuple of (order, segment, joint, fraction)
    instants : tuple of (segment, fraction)
        For torque, torque rate, Cartesian speed and custom limits.
    """

    derivatives: tuple[tuple[int, int, int, float], ...] = ()
    instants: tuple[tuple[int, float], ...] = ()

    def joined(self, other: ExtraPoints) -> ExtraPoints:
        """Return the union."""
        return ExtraPoints(
            tuple(dict.fromkeys(self.derivatives + other.derivatives)),
            tuple(dict.fromkeys(self.instants + other.instants)),
        )

    def __bool__(self) -> bool:
        """Whether there is any point."""
        return bool(self.derivatives or self.instants)


@dataclass
class _Parts:
    """What the builder collects: elements with bounds and labels, linear rows, cost terms."""

    elements: list[Elements] = field(default_factory=list)
    lower: list[Array] = field(default_factory=list)
    upper: list[Array] = field(default_factory=list)
    labels: list[RowBlock] = field(default_factory=list)
    linear: list[tuple[list[int], list[float], float, float, RowBlock]] = field(default_factory=list)
    costs: list[tuple[Elements, Array]] = field(default_factory=list)

    def add(self, elements: Elements, lower: Any, upper: Any, label: RowBlock) -> None:
        """Add nonlinear rows with bounds broadcasting to (N, rows)."""
        shape = (elements.count, elements.formula.rows)
        self.elements.append(elements)
        self.lower.append(np.broadcast_to(lower, shape).ravel())
        self.upper.append(np.broadcast_to(upper, shape).ravel())
        self.labels.append(label)


class LiftedNlp(Nlp):
    """The lifted form of a task; see `ocp_traj.transcription.layout.Layout` for the variables."""

    form = "lifted"
    encoding = "knot-states"

    def __init__(self, task: TrajectoryTask, guess: Trajectory, samples: int, extra: ExtraPoints) -> None:
        self.layout = make_layout(task, guess)
        self.samples = samples
        self.extra = extra
        builder = _Builder(task, self.layout, samples, extra, guess)
        lower, upper, start = builder.variables()
        parts = builder.parts
        linear, linear_lower, linear_upper = _linear_rows(parts, len(start))
        symbolic = assemble(len(start), parts.elements, linear, parts.costs, builder.gradient(len(start)))
        self.x, self.f, self.g = symbolic.x, symbolic.f, symbolic.g
        self.derivatives = symbolic.derivatives
        super().__init__(
            task,
            lower=lower,
            upper=upper,
            guess=start,
            g_lower=np.concatenate([*parts.lower, linear_lower]),
            g_upper=np.concatenate([*parts.upper, linear_upper]),
            rows=[*parts.labels, *[entry[4] for entry in parts.linear]],
        )

    def decode(self, x: Array) -> Trajectory:
        """Return the spline through the knots of x: exact at waypoints and boundaries whatever the defects."""
        durations = np.maximum(self.layout.durations(np.asarray(x)), np.finfo(float).tiny)
        return build_trajectory(self.task, durations, self.layout.positions(np.asarray(x)))


def _linear_rows(parts: _Parts, size: int) -> tuple[sparse.csr_matrix, Array, Array]:
    rows = [index for index, entry in enumerate(parts.linear) for _ in entry[0]]
    columns = [column for entry in parts.linear for column in entry[0]]
    values = [value for entry in parts.linear for value in entry[1]]
    matrix = sparse.csr_matrix((values, (rows, columns)), shape=(len(parts.linear), size))
    lower = np.array([entry[2] for entry in parts.linear])
    upper = np.array([entry[3] for entry in parts.linear])
    return matrix, lower, upper


class _Builder:
    """Collects bounds, rows and costs of one task."""

    def __init__(
        self, task: TrajectoryTask, layout: Layout, samples: int, extra: ExtraPoints, guess: Trajectory
    ) -> None:
        self.task, self.layout, self.extra, self.guess = task, layout, extra, guess
        self.per_segment = max(2, 2 * round(samples / (2 * layout.per_gap)))
        self.parts = _Parts()
        self.slacks: list[tuple[Array, Array]] = []
        self.instant: Instant = instant_of(task)
        self._add_defects()
        for limit in DERIVATIVE_LIMITS:
            if limit.applies(task):
                self._add_derivative_limit(limit)
        self._add_durations()
        self._add_end_jerk()
        for term in SQUARED_DERIVATIVES:
            if term.weight(task) > 0:
                self._add_squared(term.order, term.weight(task))
        if self.instant:
            self._add_instants()

    # Variables -----------------------------------------------------------------------------------------------

    def variables(self) -> tuple[Array, Array, Array]:
        """Return lower and upper bounds and the guess."""
        layout = self.layout
        start = layout.encode(self.guess)
        lower, upper = np.full(layout.size, -np.inf), np.full(layout.size, np.inf)
        lower[: layout.segments] = MINIMUM_FRACTION
        for limit in DERIVATIVE_LIMITS:
            if limit.order < layout.degree and limit.applies(self.task):
                self._bound_states(limit, lower, upper)
        self._fix_states(lower, upper)
        for slack_start, slack_scale in self.slacks:
            lower = np.append(lower, np.zeros(len(slack_start)))
            upper = np.append(upper, np.full(len(slack_start), np.inf))
            start = np.append(start, slack_start / slack_scale)
        return lower, upper, np.clip(start, lower, upper)

    def gradient(self, size: int) -> Array:
        """Return the linear part of the cost: the total time."""
        gradient = np.zeros(size)
        gradient[: self.layout.segments] = self.task.objective.time * self.layout.duration_scale
        return gradient

    def _bound_states(self, limit: DerivativeLimit, lower: Array, upper: Array) -> None:
        """Bound knot states by the limits of both neighbouring gaps; a range that excludes a waypoint is its own."""
        layout = self.layout
        bounds = limit.bounds(self.task)
        knots = np.arange(layout.segments + 1)
        gaps = np.array([layout.knot_gaps(int(knot)) for knot in knots])
        scale = layout.state_scales[limit.order]
        low = np.maximum(bounds[gaps[:, 0], 0], bounds[gaps[:, 1], 0])[:, layout.moving] / scale
        high = np.minimum(bounds[gaps[:, 0], 1], bounds[gaps[:, 1], 1])[:, layout.moving] / scale
        index = layout.state(knots[:, None], np.arange(len(layout.moving))[None, :], limit.order)
        lower[index], upper[index] = low, high

    def _fix_states(self, lower: Array, upper: Array) -> None:
        """Fix waypoints (or their boxes) and the given or natural states at both ends."""
        layout, task = self.layout, self.task
        joints = np.arange(len(layout.moving))
        tolerance = np.asarray(task.tolerance)[:, layout.moving] / layout.state_scales[0]
        waypoints = task.waypoints[:, layout.moving] / layout.state_scales[0]
        index = layout.state(np.arange(task.gaps + 1)[:, None] * layout.per_gap, joints[None, :], 0)
        free = tolerance > 0
        lower[index] = np.where(free, np.maximum(lower[index], waypoints - tolerance), waypoints)
        upper[index] = np.where(free, np.minimum(upper[index], waypoints + tolerance), waypoints)
        self._turn_at_limits(lower, upper)
        for side, knot in ((0, 0), (1, layout.segments)):
            for order, name in ((1, "velocity"), (2, "acceleration"), (3, "jerk")):
                given = getattr(task.boundary, name)
                if given is not None and order < layout.degree:
                    value = given[side, layout.moving] / layout.state_scales[order]
                elif given is None and order <= (layout.degree - 1) // 2:
                    order, value = layout.degree - order, np.zeros(len(joints))
                else:
                    continue
                index = layout.state(knot, joints, order)
                lower[index] = upper[index] = value

    def _turn_at_limits(self, lower: Array, upper: Array) -> None:
        """Fix the velocity at inner waypoints that lie on a position limit: passing them with speed would cross it."""
        layout, task = self.layout, self.task
        position = task.limits.get("position")
        for waypoint in range(1, task.gaps):
            at = task.waypoints[waypoint, layout.moving]
            low = np.maximum(position[waypoint - 1, 0], position[waypoint, 0])[layout.moving]
            high = np.minimum(position[waypoint - 1, 1], position[waypoint, 1])[layout.moving]
            exact = np.asarray(task.tolerance)[waypoint, layout.moving] == 0
            touching = np.flatnonzero(exact & ((at <= low) | (at >= high)))
            index = layout.state(waypoint * layout.per_gap, touching, 1)
            lower[index] = upper[index] = 0.0

    # Rows ----------------------------------------------------------------------------------------------------

    def _add_defects(self) -> None:
        layout = self.layout
        segment, joint = layout.places
        orders = np.arange(layout.degree)[None, :]
        start = layout.state(segment[:, None], joint[:, None], orders)
        end = layout.state(segment[:, None] + 1, joint[:, None], orders)
        variables = np.concatenate([segment[:, None], start, end], axis=1)
        parameters = np.column_stack([layout.state_scales[:, joint].T, np.full(len(joint), layout.duration_scale)])
        elements = Elements(defect_formula(layout.degree), variables, parameters)
        count = elements.formula.rows
        label = self._label("continuity", np.repeat(segment, count), np.repeat(joint, count), 1.0)
        self.parts.add(elements, 0.0, 0.0, label)

    def _label(self, limit: str, segment: Any, joint: Any, fraction: Any) -> RowBlock:
        """Return labels of rows; `joint` counts moving joints, `fraction` is of the segment."""
        layout = self.layout
        segment = np.asarray(segment)
        inside = (segment % layout.per_gap + fraction) / layout.per_gap
        return RowBlock(limit, np.asarray(layout.moving)[joint], segment // layout.per_gap, inside)

    def _add_derivative_limit(self, limit: DerivativeLimit) -> None:
        layout = self.layout
        if limit.order == layout.degree:
            self._add_top_limit(limit)
            return
        places: list[tuple[int, int, float]] = []
        segment, joint = layout.places
        if limit.order < layout.degree - 1 and limit.order > 0:
            for fraction in INNER_FRACTIONS[layout.degree]:
                places += [(int(s), int(i), fraction) for s, i in zip(segment, joint)]
        places += [(s, i, at) for order, s, i, at in self.extra.derivatives if order == limit.order]
        if layout.degree == 3 and limit.order == 1 and self.task.virtual_knots:
            self._add_sampled(limit, [(int(s), int(i), 0.5) for s, i in zip(segment, joint)], bernstein=True)
        if places:
            self._add_sampled(limit, places, bernstein=False)

    def _add_sampled(
        self, limit: DerivativeLimit, places: list[tuple[int, int, float]], *, bernstein: bool
    ) -> None:
        layout = self.layout
        segment = np.array([place[0] for place in places])
        joint = np.array([place[1] for place in places])
        fraction = np.array([place[2] for place in places])
        bounds = limit.bounds(self.task)[segment // layout.per_gap, :, np.asarray(layout.moving)[joint]]
        keep = np.isfinite(bounds).any(axis=1)
        segment, joint, fraction, bounds = segment[keep], joint[keep], fraction[keep], bounds[keep]
        if not len(segment):
            return
        scale = _row_scale(bounds, layout.state_scales[limit.order][joint])
        orders = np.arange(limit.order, layout.degree)[None, :]
        variables = np.column_stack(
            [
                segment,
                layout.state(segment[:, None], joint[:, None], orders),
                layout.state(segment + 1, joint, layout.degree - 1),
            ]
        )
        if bernstein:
            variables = variables[:, :3]
        parameters = np.column_stack(
            [
                layout.state_scales[limit.order :, joint].T,
                np.full(len(joint), layout.duration_scale),
                fraction,
                scale,
            ]
        )
        formula = bernstein_formula() if bernstein else sample_formula(layout.degree, limit.order)
        self.parts.add(
            Elements(formula, variables, parameters),
            (bounds[:, 0] / scale)[:, None],
            (bounds[:, 1] / scale)[:, None],
            self._label(limit.name, segment, joint, fraction),
        )

    def _add_top_limit(self, limit: DerivativeLimit) -> None:
        """Limit the constant derivative p of every segment: linear in the states and the duration."""
        layout = self.layout
        bounds = limit.bounds(self.task)
        for segment in range(layout.segments):
            for index, joint in enumerate(layout.moving):
                low, high = bounds[segment // layout.per_gap, :, joint]
                scale = layout.state_scales[layout.degree - 1, index]
                columns = [
                    int(layout.state(segment + 1, index, layout.degree - 1)),
                    int(layout.state(segment, index, layout.degree - 1)),
                    segment,
                ]
                label = self._label(limit.name, np.array([segment]), np.array([index]), 0.5)
                if np.isfinite(high):
                    factor = high * layout.duration_scale / scale
                    self.parts.linear.append((columns, [1.0, -1.0, -factor], -np.inf, 0.0, label))
                if np.isfinite(low):
                    factor = low * layout.duration_scale / scale
                    self.parts.linear.append((columns, [-1.0, 1.0, factor], -np.inf, 0.0, label))

    def _add_durations(self) -> None:
        """Bound the total duration and the durations of gaps."""
        layout, objective = self.layout, self.task.objective
        intervals = [(np.arange(layout.segments), np.asarray(objective.duration), 0)]
        for gap, interval in enumerate(np.asarray(objective.gap_durations)):
            intervals.append((gap * layout.per_gap + np.arange(layout.per_gap), interval, gap))
        for columns, (low, high), gap in intervals:
            if low > 0 or np.isfinite(high):
                scale = high if np.isfinite(high) else low
                values = [layout.duration_scale / scale] * len(columns)
                label = RowBlock("duration", np.array([-1]), np.array([gap]), np.array([0.0]))
                lower = low / scale if low > 0 else -np.inf
                self.parts.linear.append((columns.tolist(), values, lower, high / scale, label))

    def _add_end_jerk(self) -> None:
        """Impose a given end jerk on a cubic, whose jerk is no state but constant in the first and last segment."""
        layout, given = self.layout, self.task.boundary.jerk
        if given is None or layout.degree != 3:
            return
        for side, segment in ((0, 0), (1, layout.segments - 1)):
            for index, joint in enumerate(layout.moving):
                scale = layout.state_scales[2, index]
                columns = [int(layout.state(segment + 1, index, 2)), int(layout.state(segment, index, 2)), segment]
                values = [1.0, -1.0, -float(np.asarray(given)[side, joint]) * layout.duration_scale / scale]
                label = self._label("boundary jerk", np.array([segment]), np.array([index]), float(side))
                self.parts.linear.append((columns, values, 0.0, 0.0, label))

    # Costs ---------------------------------------------------------------------------------------------------

    def _add_squared(self, order: int, weight: float) -> None:
        layout = self.layout
        segment, joint = layout.places
        first = min(order, layout.degree - 1)
        orders = np.arange(first, layout.degree)[None, :]
        variables = np.column_stack(
            [
                segment,
                layout.state(segment[:, None], joint[:, None], orders),
                layout.state(segment + 1, joint, layout.degree - 1),
            ]
        )
        parameters = np.column_stack(
            [layout.state_scales[first:, joint].T, np.full(len(joint), layout.duration_scale)]
        )
        elements = Elements(squared_formula(layout.degree, order), variables, parameters)
        self.parts.costs.append((elements, np.full(elements.count, weight)))

    # Torques and other functions of an instant ----------------------------------------------------------------

    def _grid(self) -> list[tuple[int, float]]:
        """Return the (segment, fraction) of the regular samples; a knot belongs to the segment it starts."""
        grid = [
            (segment, step / self.per_segment)
            for segment in range(self.layout.segments)
            for step in range(self.per_segment)
        ]
        return [*grid, (self.layout.segments - 1, 1.0)]

    def _add_instants(self) -> None:
        points = [*self._grid(), *self.extra.instants]
        for constraint in self.instant.constraints:
            at = points
            if constraint.needs_jerk:  # the jerk may jump at knots: take both sides
                at = [*points, *[(segment, 1.0) for segment in range(self.layout.segments - 1)]]
            function = instant_function(self.task, constraint)
            bounds = constraint.bounds(self.task)
            scale = _row_scale(np.moveaxis(bounds, 1, 2).reshape(-1, 2), 1.0).reshape(bounds[:, 0].shape).max(axis=0)
            elements = self._state_elements(function, scale, at, jerk=constraint.needs_jerk)
            gaps = np.array([segment // self.layout.per_gap for segment, _ in at])
            joints = np.asarray(constraint.joints(self.task))
            label = self._instant_label(constraint.name, at, joints)
            self.parts.add(elements, bounds[gaps, 0] / scale, bounds[gaps, 1] / scale, label)
        for term in self.instant.terms:
            if term.shape == "sum":
                self._add_smooth_term(term)
            else:
                self._add_kinked_term(term)

    def _state_elements(self, function: Any, scale: Array, at: list[tuple[int, float]], *, jerk: bool) -> Elements:
        formula = state_formula(self.layout, function, scale, integrate=False, needs_jerk=jerk)
        parameters = np.array([[fraction, 1.0] for _, fraction in at])
        return Elements(formula, state_variables(self.layout, [segment for segment, _ in at]), parameters)

    def _instant_label(self, name: str, at: list[tuple[int, float]], joints: Any) -> RowBlock:
        segment = np.repeat([place[0] for place in at], len(joints))
        fraction = np.repeat([place[1] for place in at], len(joints))
        inside = (segment % self.layout.per_gap + fraction) / self.layout.per_gap
        return RowBlock(name, np.tile(joints, len(at)), segment // self.layout.per_gap, inside)

    def _add_smooth_term(self, term: SampledTerm) -> None:
        """Add Simpson's rule over every segment."""
        function = instant_function(self.task, term)
        formula = state_formula(
            self.layout, function, np.ones(function.numel_out(0)), integrate=True, needs_jerk=False
        )
        at, weights = self._simpson()
        parameters = np.column_stack([[fraction for _, fraction in at], weights])
        elements = Elements(formula, state_variables(self.layout, [segment for segment, _ in at]), parameters)
        self.parts.costs.append((elements, np.full(len(at), term.weight(self.task))))

    def _simpson(self) -> tuple[list[tuple[int, float]], Array]:
        """Return points and weights of Simpson's rule on every segment of unit duration."""
        count = self.per_segment
        weights = np.full(count + 1, 2.0)
        weights[1::2] = 4.0
        weights[[0, -1]] = 1.0
        at = [(segment, step / count) for segment in range(self.layout.segments) for step in range(count + 1)]
        return at, np.tile(weights / (3 * count), self.layout.segments)

    def _add_kinked_term(self, term: SampledTerm) -> None:
        """Integrate |value| or max(value, 0) with one slack a sample and value, s >= value (and s >= -value)."""
        import casadi as ca

        layout = self.layout
        function = instant_function(self.task, term)
        size = function.numel_out(0)
        grid = self._grid()
        guess = self._values_on_guess(function, grid)
        scale = float(np.abs(guess).max()) or 1.0
        elements = self._state_elements(function, np.full(size, scale), grid, jerk=False)
        first = layout.size + sum(len(values) for values, _ in self.slacks)
        slack = first + np.arange(len(grid) * size).reshape(len(grid), size)
        start = np.abs(guess) if term.shape == "absolute" else np.maximum(guess, 0.0)
        self.slacks.append((start.ravel() + 1e-2 * scale, np.array(scale)))
        self._add_slack_rows(elements, slack, term)
        local, weight = ca.SX.sym("local", 1 + size), ca.SX.sym("weight")
        from ocp_traj.transcription.elements import Formula

        formula = Formula("slack", local, weight, weight * local[0] * ca.sum1(local[1:]))
        at, weights = self._simpson()
        knot = np.array([segment * self.per_segment + round(fraction * self.per_segment) for segment, fraction in at])
        variables = np.column_stack([[segment for segment, _ in at], slack[knot]])
        unit = term.weight(self.task) * layout.duration_scale * scale
        self.parts.costs.append((Elements(formula, variables, weights[:, None]), np.full(len(at), unit)))

    def _add_slack_rows(self, values: Elements, slack: Any, term: SampledTerm) -> None:
        """Add slack - value >= 0 and, for absolute values, slack + value >= 0 at every sample."""
        import casadi as ca

        from ocp_traj.transcription.elements import Formula

        inner = values.formula
        size = inner.rows
        signs = (1.0, -1.0) if term.shape == "absolute" else (1.0,)
        extra = ca.SX.sym("slack", size)
        rows = ca.vertcat(*[extra - sign * inner.value for sign in signs])
        jacobian = ca.vertcat(*[ca.horzcat(-sign * inner.jacobian, ca.SX.eye(size)) for sign in signs])
        multipliers = ca.SX.sym("lambda", rows.numel())
        assert inner.hessian is not None
        combined = sum(-sign * multipliers[k * size : (k + 1) * size] for k, sign in enumerate(signs))
        curvature = ca.substitute(inner.hessian[1], inner.hessian[0], ca.densify(combined))
        full = ca.diagcat(curvature, ca.SX(size, size))
        formula = Formula(
            f"{term.name}_slack", ca.vertcat(inner.local, extra), inner.parameters, rows, jacobian, (multipliers, full)
        )
        variables = np.concatenate([values.variables, slack], axis=1)
        label = self._instant_label(term.name, self._grid(), np.full(size * len(signs), -1))
        self.parts.add(Elements(formula, variables, values.parameters), 0.0, np.inf, label)

    def _values_on_guess(self, function: Any, at: list[tuple[int, float]]) -> Array:
        """Evaluate a function of (q, v, a, j) along the guess at samples, (N, k)."""
        segment = np.array([place[0] for place in at])
        fraction = np.array([place[1] for place in at])
        breakpoints = np.asarray(self.guess.breakpoints)
        t = breakpoints[segment] + fraction * np.diff(breakpoints)[segment]
        columns = [self.guess(t, order).T for order in range(4)]
        values: Array = np.array(function.map(len(t))(*columns)).T
        return values


def _row_scale(bounds: Array, fallback: Any) -> Array:
    """Return the larger finite bound of every row (rows, 2), or `fallback` where there is none above zero."""
    magnitude = np.where(np.isfinite(bounds), np.abs(bounds), 0.0).max(axis=1)
    scale: Array = np.where(magnitude > 0, magnitude, fallback)
    return scale
