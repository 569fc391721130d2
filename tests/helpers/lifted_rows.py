"""The rows of the lifted form as they are told, and as they should be (`helpers.row_oracle`)."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from helpers.row_oracle import (
    GAPS,
    INSTANTS,
    LIMITS,
    ORDERS,
    Motion,
    instant_limits,
    larger_finite,
    spline,
)
from ocp_traj.transcription.lifted.lifted import ExtraPoints, LiftedNlp

SAMPLES = 4
INNER = {3: [], 5: [0.25, 0.5, 0.75], 7: [k / 8 for k in range(1, 8)]}
EXTRA = ExtraPoints(
    ((0, 0, 1, 0.3), (0, 2, 0, 0.9), (1, 1, 0, 0.77), (1, 0, 2, 0.4), (2, 2, 1, 0.15)),
    ((0, 0.1234), (2, 0.55), (1, 1.0)),
)
"""As if limits had been found broken there: (order, segment, joint, fraction) and (segment, fraction)."""

Row = tuple[str, int, int, float, float, float, float]
"""limit, joint, gap, where in the gap, value, lower and upper bound."""


def states_near(rng: np.random.Generator, degree: int, segments: int) -> tuple[np.ndarray, Motion]:
    """Return durations and a spline through random knots."""
    durations = rng.uniform(0.4, 1.5, segments)
    half = (degree - 1) // 2
    ends = [[(order, rng.normal(size=3)) for order in range(1, half + 1)] for _ in range(2)]
    return durations, spline(degree, durations, rng.normal(size=(segments + 1, 3)), *ends)


def variables(nlp: LiftedNlp, motion: Motion) -> np.ndarray:
    """Return x for a motion: durations, then knots with their moving joints with their derivatives, in units."""
    layout = nlp.layout
    units = np.asarray(layout.state_scales)
    states = motion.knots[:, :, layout.moving] / units
    return np.concatenate([motion.durations / layout.duration_scale, states.transpose(0, 2, 1).ravel()])


def told_rows(nlp: LiftedNlp, x: np.ndarray) -> list[Row]:
    """Return the rows as the problem has them."""
    values = np.array(ca.Function("g", [nlp.x], [nlp.g])(x)).ravel()
    places = [
        (block.limit, int(joint), int(gap), float(fraction))
        for block in nlp.rows
        for joint, gap, fraction in zip(block.joint, block.gap, block.fraction)
    ]
    assert len(places) == len(values) == len(nlp.g_lower) == len(nlp.g_upper)
    return [
        (*place, *numbers) for place, *numbers in zip(places, values, nlp.g_lower, nlp.g_upper, strict=True)
    ]


def compare(told: list[Row], expected: list[Row]) -> None:
    """Compare rows whatever their order: by label, then by value."""

    def key(row: Row) -> Any:
        return (*row[:3], round(row[3], 9), round(row[4], 7))

    told, expected = sorted(told, key=key), sorted(expected, key=key)
    assert [key(row)[:4] for row in told] == [key(row)[:4] for row in expected]
    a, b = (np.array([row[4:] for row in rows]) for rows in (told, expected))
    np.testing.assert_allclose(a, b, rtol=1e-8, atol=1e-9)


def derivative_rows(nlp: LiftedNlp, motion: Motion, extra: ExtraPoints) -> list[Row]:
    layout, degree, per_gap = nlp.layout, nlp.layout.degree, nlp.task.virtual_knots + 1
    rows: list[Row] = []

    def add(name: str, segment: int, joint: int, fraction: float, value: float) -> None:
        lower, upper = LIMITS[name][segment // per_gap, :, joint]
        if np.isfinite([lower, upper]).any():
            scale = larger_finite(lower, upper)
            inside = (segment % per_gap + fraction) / per_gap
            place = (name, joint, segment // per_gap, inside)
            rows.append((*place, value / scale, lower / scale, upper / scale))

    for name, order in ORDERS.items():
        for segment in range(layout.segments):
            for joint in layout.moving:
                if 0 < order < degree - 1:
                    inner = INNER[degree]
                    if degree == 3 and per_gap == 1 and np.isinf(LIMITS["acceleration"][:, :, joint]).any():
                        inner = [0.5]
                    for fraction in inner:
                        add(name, segment, joint, fraction, motion.at(order, segment, fraction)[joint])
                if degree == 3 and order == 1 and per_gap > 1:
                    v, a = (motion.at(k, segment, 0.0)[joint] for k in (1, 2))
                    add(name, segment, joint, 0.5, v + a * motion.durations[segment] / 2)
        for place, segment, moving, fraction in extra.derivatives:
            if place == order < degree:
                joint = layout.moving[moving]
                add(name, segment, joint, fraction, motion.at(order, segment, fraction)[joint])
    return rows


def linear_rows(nlp: LiftedNlp, motion: Motion) -> list[Row]:
    """Return the rows of the highest derivative, of given end jerks of cubics, and of durations."""
    layout, task, degree, per_gap = nlp.layout, nlp.task, nlp.layout.degree, nlp.task.virtual_knots + 1
    rows: list[Row] = []
    for index, joint in enumerate(layout.moving):
        unit = layout.state_scales[degree - 1, index]
        for segment, h in enumerate(motion.durations):
            place = (segment // per_gap, (segment % per_gap + 0.5) / per_gap)
            top = motion.at(degree, segment, 0.0)[joint]
            for sign, bound in zip((-1.0, 1.0), LIMITS["jerk"][segment // per_gap, :, joint]):
                if degree == 3 and np.isfinite(bound):
                    rows.append(("jerk", joint, *place, sign * (top - bound) * h / unit, -np.inf, 0.0))
        if degree == 3 and task.boundary.jerk is not None:
            for side, segment in ((0, 0), (1, layout.segments - 1)):
                jerk, h = motion.at(3, segment, 0.0)[joint], motion.durations[segment]
                value = (jerk - np.asarray(task.boundary.jerk)[side, joint]) * h / unit
                inside = (segment % per_gap + side) / per_gap
                rows.append(("boundary jerk", joint, segment // per_gap, inside, value, 0.0, 0.0))
    h = motion.durations.reshape(GAPS, per_gap).sum(axis=1)
    rows.append(("duration", -1, 0, 0.0, h.sum() / 5.0, 3.0 / 5.0, 1.0))
    rows.append(("duration", -1, 0, 0.0, h[0] / 0.5, 1.0, np.inf))
    rows.append(("duration", -1, 0, 0.0, h[0] / 2.0, -np.inf, 1.0))
    rows.append(("duration", -1, 1, 0.0, h[1] / 1.5, -np.inf, 1.0))
    rows.append(("duration", -1, 2, 0.0, h[2] / 0.7, 1.0, np.inf))
    return rows


def continuity_rows(nlp: LiftedNlp, motion: Motion) -> list[Row]:
    layout, per_gap = nlp.layout, nlp.task.virtual_knots + 1
    rows: list[Row] = []
    for segment in range(layout.segments):
        for index, joint in enumerate(layout.moving):
            for order in range(layout.degree - 1):
                defect = motion.at(order, segment, 1.0)[joint] - motion.knots[segment + 1, order, joint]
                place = (segment // per_gap, (segment % per_gap + 1.0) / per_gap)
                value = defect / layout.state_scales[order, index]
                rows.append(("continuity", joint, *place, value, 0.0, 0.0))
    return rows


def instant_rows(nlp: LiftedNlp, motion: Motion, robot: Any, extra: ExtraPoints) -> list[Row]:
    segments, per_gap = nlp.layout.segments, nlp.task.virtual_knots + 1
    count = max(2, 2 * round(SAMPLES / (2 * per_gap)))
    grid = [(segment, k / count) for segment in range(segments) for k in range(count)]
    points = [*grid, (segments - 1, 1.0), *extra.instants]
    rows: list[Row] = []
    for name in INSTANTS:
        function, bounds, joints, orders = instant_limits(robot, name)
        scale = [larger_finite(*bounds[:, :, k].ravel()) for k in range(len(joints))]
        if name == "custom":  # one scale for all values of a function
            scale = [larger_finite(*bounds.ravel())] * len(joints)
        both_sides = [(segment, 1.0) for segment in range(segments - 1)] if orders == 4 else []
        for segment, fraction in [*points, *both_sides]:
            if fraction == 1.0 and orders == 3:
                values = function(*motion.knots[segment + 1, :3])
            else:
                values = function(*motion.state(segment, fraction, orders))
            gap = segment // per_gap
            lower, upper = bounds[gap]
            if orders == 3 and fraction == 0.0 and segment > 0:
                before = bounds[(segment - 1) // per_gap]
                lower, upper = np.maximum(lower, before[0]), np.minimum(upper, before[1])
            inside = (segment % per_gap + fraction) / per_gap
            for k, joint in enumerate(joints):
                numbers = np.array([values[k], lower[k], upper[k]]) / scale[k]
                rows.append((name, joint, gap, inside, *numbers))
    return rows
