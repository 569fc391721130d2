"""Every row of the lifted form, its bounds and its label, against values worked out apart (`row_oracle`).

What mutation testing found untested: values and bounds of both sides, asymmetric, in the gap they belong to.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from helpers.row_oracle import (
    DEGREES,
    GAPS,
    INSTANTS,
    LIMITS,
    ORDERS,
    WAYPOINTS,
    Motion,
    custom_function,
    custom_values,
    instant_limits,
    larger_finite,
    make_task,
    spline,
    torque,
    unconnected,
)
from ocp_traj.task import (
    Boundary,
    CustomConstraint,
    CustomObjective,
    Limits,
    Motor,
    Objective,
    TrajectoryTask,
)
from ocp_traj.transcription import initial_guess
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
                    for fraction in INNER[degree]:
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
    rows.append(("duration", -1, 0, 0.0, h[0] / 2.0, 0.25, 1.0))
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


@pytest.mark.parametrize("meets", [True, False])
@pytest.mark.parametrize(("family", "knots"), [("cubic", 0), ("cubic", 2), ("quintic", 1), ("septic", 0)])
def test_every_row_has_the_value_and_the_bounds_worked_out_apart(
    arm: Any, family: str, knots: int, meets: bool
) -> None:
    degree, rng = DEGREES[family], np.random.default_rng(3)
    task = make_task(arm, family, knots)
    nlp = LiftedNlp(task, initial_guess(task), SAMPLES, EXTRA)
    durations, motion = states_near(rng, degree, nlp.layout.segments)
    if not meets:
        states = motion.knots * rng.uniform(0.8, 1.2, motion.knots.shape)
        motion = unconnected(degree, durations, states)
    rows = derivative_rows(nlp, motion, EXTRA) + linear_rows(nlp, motion) + continuity_rows(nlp, motion)
    rows += instant_rows(nlp, motion, arm, EXTRA)
    compare(told_rows(nlp, variables(nlp, motion)), rows)
    if meets:
        assert all(abs(row[4]) < 1e-8 for row in continuity_rows(nlp, motion))


BOUNDARIES: list[tuple[str, int, Boundary, dict[int, int]]] = [
    ("cubic", 0, Boundary([[0.1, -0.2, 0.3], [0.2, 0.1, -0.1]]), {}),
    ("cubic", 2, Boundary(0.0, [[0.5, 0.4, -0.3], [0.1, -0.6, 0.2]], None), {}),
    ("cubic", 2, Boundary(0.0, 0.0, [[3.0, 2.0, -1.0], [1.0, -2.0, 4.0]]), {}),
    ("quintic", 0, Boundary([[0.1, -0.2, 0.3]] * 2), {}),
    ("quintic", 1, Boundary(0.0, None), {2: 3}),
    ("quintic", 2, Boundary(0.0, None, [[3.0, 2.0, -1.0], [1.0, -2.0, 4.0]]), {}),
    ("septic", 0, Boundary(0.0, [[0.5, 0.4, -0.3], [0.1, -0.6, 0.2]]), {}),
    ("septic", 0, Boundary(0.0, [[0.5, 0.4, -0.3], [0.1, -0.6, 0.2]], None), {3: 4}),
    ("septic", 0, Boundary(0.0, None, None), {2: 5, 3: 4}),
]
"""Family, virtual knots, what is given, and the derivative that is 0 in the stead of one that is free."""

BOX = np.array([[0.0, 0.1, 0.0], [0.02, 0.0, 0.3], [0.0, 0.2, 0.01], [0.1, 0.0, 0.0]])


@pytest.mark.parametrize(("family", "knots", "boundary", "natural"), BOUNDARIES)
def test_knot_states_have_the_bounds_of_both_gaps_waypoints_and_ends(
    arm: Any, family: str, knots: int, boundary: Boundary, natural: dict[int, int]
) -> None:
    degree, per_gap = DEGREES[family], knots + 1
    task = make_task(arm, family, knots, boundary=boundary, tolerance=BOX)
    nlp = LiftedNlp(task, initial_guess(task), SAMPLES, ExtraPoints())
    segments = GAPS * per_gap
    lower = np.full((segments + 1, degree, 3), -np.inf)
    upper = -lower
    for knot in range(segments + 1):
        for name, order in ORDERS.items():
            for gap in {max(knot - 1, 0) // per_gap, min(knot, segments - 1) // per_gap}:
                if order < degree:
                    lower[knot, order] = np.maximum(lower[knot, order], LIMITS[name][gap, 0])
                    upper[knot, order] = np.minimum(upper[knot, order], LIMITS[name][gap, 1])
    for index, (waypoint, room) in enumerate(zip(WAYPOINTS, BOX)):
        low, high = lower[index * per_gap, 0], upper[index * per_gap, 0]
        low[:], high[:] = np.maximum(low, waypoint - room), np.minimum(high, waypoint + room)
    for side, knot in ((0, 0), (1, segments)):
        for order, name in ((1, "velocity"), (2, "acceleration"), (3, "jerk")):
            given = getattr(task.boundary, name)
            if given is not None and order < degree:
                lower[knot, order] = upper[knot, order] = given[side]
        for order in natural.values():
            lower[knot, order] = upper[knot, order] = 0.0
    for told, expected in ((nlp.lower, lower), (nlp.upper, upper)):
        units = np.asarray(nlp.layout.state_scales).T.ravel()
        states = np.asarray(told)[segments : nlp.layout.size].reshape(segments + 1, -1) * units
        wanted = expected.transpose(0, 2, 1).reshape(segments + 1, -1)
        np.testing.assert_allclose(states, wanted, rtol=1e-12, atol=1e-15)
    jerk_rows = sum(len(block) for block in nlp.rows if block.limit == "boundary jerk")
    assert jerk_rows == (6 if degree == 3 and task.boundary.jerk is not None else 0)
    motion = states_near(np.random.default_rng(8), degree, segments)[1]
    ends = [row for row in told_rows(nlp, variables(nlp, motion)) if row[0] == "boundary jerk"]
    compare(ends, [row for row in linear_rows(nlp, motion) if row[0] == "boundary jerk"])


@pytest.mark.parametrize(
    ("gap", "side", "waypoint", "joint"),
    [(0, 1, 1, 0), (1, 1, 1, 0), (1, 0, 2, 0), (2, 0, 2, 0), (2, 1, 2, 1)],
)
def test_a_waypoint_on_a_position_limit_is_passed_without_speed(
    arm: Any, gap: int, side: int, waypoint: int, joint: int
) -> None:
    position = np.tile([[-np.inf] * 3, [np.inf] * 3], (GAPS, 1, 1))
    position[gap, side, joint] = WAYPOINTS[waypoint, joint]
    for box, still in ((0.0, True), (0.01, False)):
        task = make_task(arm, "quintic", 1, limits=Limits(position=position, velocity=5.0), tolerance=box)
        nlp = LiftedNlp(task, initial_guess(task), SAMPLES, ExtraPoints())
        velocities = [nlp.layout.state(knot, place, 1) for knot in range(1, 6) for place in range(3)]
        fixed = [index for index in velocities if nlp.lower[index] == nlp.upper[index] == 0.0]
        assert fixed == ([nlp.layout.state(2 * waypoint, joint, 1)] if still else [])


@pytest.mark.parametrize("family", ["cubic", "quintic", "septic"])
@pytest.mark.parametrize("knots", [0, 1, 2])
def test_segments_have_a_shortest_duration(arm: Any, family: str, knots: int) -> None:
    part = {0: 1e-3, 1: 1e-3, 2: 0.02}[knots]
    if knots and family != "cubic":
        part = 0.1
    for acceleration in (None, 0.0):
        if acceleration == 0.0 and (family, knots) == ("cubic", 0):
            continue
        task = make_task(arm, family, knots, boundary=Boundary(acceleration=acceleration))
        guess = initial_guess(task)
        nlp = LiftedNlp(task, guess, SAMPLES, ExtraPoints())
        wanted = np.repeat(part * np.diff(guess.waypoint_times) / (knots + 1), knots + 1)
        if family == "cubic" and acceleration == 0.0:
            wanted[[0, -1]] = 1e-3 * np.diff(guess.waypoint_times)[[0, -1]] / (knots + 1)
        segments = GAPS * (knots + 1)
        np.testing.assert_allclose(nlp.lower[:segments] * nlp.layout.duration_scale, wanted, rtol=1e-12)
        assert np.isinf(nlp.upper[:segments]).all()
        assert nlp.layout.duration_scale == pytest.approx(guess.duration / segments)


def still_task(arm: Any, knots: int = 0, **changes: Any) -> TrajectoryTask:
    waypoints = WAYPOINTS.copy()
    waypoints[:, 1] = 0.2
    plain = {"limits": Limits(velocity=2.0), "constraints": (), "objective": Objective(time=1.0)}
    return make_task(arm, "cubic", knots, **{"waypoints": waypoints, **plain, **changes})


def test_only_joints_that_may_move_have_variables(arm: Any) -> None:
    from ocp_traj.transcription.lifted.layout import moving_joints

    torque_limit, zero = Limits(torque=50.0), [np.inf, 0.0, np.inf]
    speed_limit = Limits(torque=np.inf, cartesian_speed=(("hand", 1.0),))
    moving, one_end = Boundary([[0.0] * 3, [0.0, 0.1, 0.0]]), np.zeros((4, 3))
    one_end[2, 1] = 0.01
    cases: list[tuple[TrajectoryTask, list[int]]] = [
        (still_task(arm), [0, 2]),
        (still_task(arm, 1, limits=Limits(torque=np.inf)), [0, 2]),
        (still_task(arm, 0, limits=torque_limit), [0, 2]),
        (still_task(arm, 1, limits=torque_limit), [0, 1, 2]),
        (still_task(arm, 1, limits=speed_limit), [0, 1, 2]),
        (still_task(arm, boundary=moving), [0, 1, 2]),
        (still_task(arm, 2, boundary=Boundary(0.0, [[0.0] * 3, [0.0, 0.1, 0.0]])), [0, 1, 2]),
        (still_task(arm, tolerance=one_end), [0, 1, 2]),
        *[
            (still_task(arm, 1, limits=Limits(torque=50.0, **{name: zero})), [0, 2])
            for name in ("velocity", "acceleration", "jerk")
        ],
        (still_task(arm, 1, limits=Limits(torque=50.0, velocity=[[-1, -1, -1], [1, 0, 1]])), [0, 1, 2]),
    ]
    for task, expected in cases:
        assert moving_joints(task).tolist() == expected


def test_joints_without_variables_stay_in_torques_and_keep_their_place_in_labels(arm: Any) -> None:
    task = still_task(arm, limits=Limits(**{name: LIMITS[name] for name in ("velocity", "torque")}))
    nlp = LiftedNlp(task, initial_guess(task), SAMPLES, ExtraPoints())
    durations, motion = states_near(np.random.default_rng(5), 3, GAPS)
    knots = np.array(motion.knots)
    knots[:, :, 1], knots[:, 0, 1] = 0.0, 0.2
    motion = unconnected(3, durations, knots)
    rows = [row for row in instant_rows(nlp, motion, arm, ExtraPoints()) if row[0] == "torque"]
    told = told_rows(nlp, variables(nlp, motion))
    compare([row for row in told if row[0] == "torque"], rows)
    assert {row[1] for row in told if row[0] == "continuity"} == {0, 2}
    positions = nlp.layout.positions(variables(nlp, motion))
    np.testing.assert_allclose(positions, knots[:, 0], rtol=1e-12)
    np.testing.assert_allclose(nlp.layout.durations(variables(nlp, motion)), durations, rtol=1e-12)


def test_a_motion_becomes_the_variables_it_decodes_to(arm: Any) -> None:
    task = still_task(arm, 1, boundary=Boundary([[0.2, 0.0, -0.1], [0.0, 0.0, 0.3]]))
    nlp = LiftedNlp(task, initial_guess(task), SAMPLES, ExtraPoints())
    durations = np.random.default_rng(6).uniform(0.5, 1.0, 2 * GAPS)
    times = np.concatenate([[0.0], np.cumsum(durations)])
    knots = np.random.default_rng(7).normal(size=(2 * GAPS + 1, 3))
    knots[:, 1] = 0.2
    velocity = np.asarray(task.boundary.velocity)
    motion = spline(3, durations, knots, [(1, velocity[0])], [(1, velocity[1])])
    decoded = nlp.decode(variables(nlp, motion))
    np.testing.assert_allclose(decoded.breakpoints, times, rtol=1e-12)
    np.testing.assert_allclose(decoded.waypoint_times, times[::2], rtol=1e-12)
    for order in range(3):
        np.testing.assert_allclose(
            decoded(times, order)[:-1], motion.knots[:-1, order], rtol=1e-9, atol=1e-12
        )
    np.testing.assert_allclose(nlp.layout.encode(decoded), variables(nlp, motion), rtol=1e-9, atol=1e-12)


def smooth_effort() -> Any:
    q, v, a, tau = (ca.SX.sym(name, 3) for name in ("q", "v", "a", "tau"))
    return ca.Function("effort", [q, v, a, tau], [ca.sumsqr(tau) * 0.1 + q[0] * a[1]])


OBJECTIVES: dict[str, Any] = {
    "energy": lambda robot, q, v, a: np.abs(torque(robot, q, v, a) * v).sum(),
    "energy_without_regeneration": lambda robot, q, v, a: np.maximum(torque(robot, q, v, a) * v, 0.0).sum(),
    "torque": lambda robot, q, v, a: np.square(torque(robot, q, v, a) / [1.0, 9.0, 12.0]).sum(),
    "motor_loss": lambda robot, q, v, a: (np.square(torque(robot, q, v, a)) * [2e-3, 8e-3, 18e-3]).sum(),
    "custom": lambda robot, q, v, a: 1.5 * (np.square(torque(robot, q, v, a)).sum() * 0.1 + q[0] * a[1]),
}
MOTOR = Motor(torque_constant=[1.0, 0.5, 1 / 3], resistance=0.2, gear_ratio=10.0)


def integral(motion: Motion, function: Any, count: int) -> float:
    """Return Simpson's rule with `count` intervals a segment."""
    total = 0.0
    for segment, h in enumerate(motion.durations):
        values = [function(*motion.state(segment, k / count)) for k in range(count + 1)]
        weights = [1.0, *[4.0, 2.0] * (count // 2 - 1), 4.0, 1.0]
        total += h * float(np.dot(weights, values)) / (3 * count)
    return total


@pytest.mark.parametrize(("samples", "knots"), [(4, 0), (12, 1)])
@pytest.mark.parametrize("name", OBJECTIVES)
def test_costs_are_integrals_of_what_pinocchio_says(arm: Any, name: str, samples: int, knots: int) -> None:
    weights: dict[str, Any] = {"custom": (CustomObjective("effort", smooth_effort(), 1.5),)}
    objective = Objective(time=0.5, motor=MOTOR, **(weights if name == "custom" else {name: 1.0}))
    limits = Limits(torque=[[-np.inf, -9.0, -8.0], [np.inf, 7.0, 12.0]], velocity=np.inf)
    task = make_task(arm, "cubic", knots, objective=objective, limits=limits, constraints=())
    nlp = LiftedNlp(task, initial_guess(task), samples, ExtraPoints())
    durations, motion = states_near(np.random.default_rng(4), 3, nlp.layout.segments)
    x = variables(nlp, motion)
    slacks = len(nlp.lower) - len(x)
    f = ca.Function("f", [nlp.x], [nlp.f, nlp.g])
    if (
        slacks
    ):  # every row duration value / unit - plus + minus = 0 holds at the guess, and here with the least cost
        rows = np.array([block.limit == name for block in nlp.rows for _ in range(len(block))])
        assert np.abs(np.array(f(nlp.guess)[1]).ravel()[rows]).max() < 1e-9
        assert (np.asarray(nlp.lower)[-slacks:] == 0).all()
        assert np.isinf(np.asarray(nlp.upper)[-slacks:]).all()
        assert (nlp.guess[-slacks:] > 0).all()
        assert (np.asarray(nlp.g_lower)[rows] == 0).all()
        assert (np.asarray(nlp.g_upper)[rows] == 0).all()
        jacobian = np.array(ca.densify(nlp.derivatives["jac_g"](np.append(x, np.zeros(slacks)), [])[1]))[rows]
        values = np.array(f(np.append(x, np.zeros(slacks)))[1]).ravel()[rows]
        chosen = np.zeros(slacks)
        for row, value in zip(jacobian[:, -slacks:], values):
            assert sorted(row[row != 0]) == [-1.0, 1.0]
            chosen[np.argmax(row == (-1.0 if value > 0 else 1.0))] = abs(value)
        x = np.append(x, chosen)
        assert np.abs(np.array(f(x)[1]).ravel()[rows]).max() < 1e-12
    count = max(2, 2 * round(max(samples, 8) / (2 * (knots + 1))))
    expected = 0.5 * durations.sum() + integral(motion, lambda *u: OBJECTIVES[name](arm, *u), count)
    assert float(f(x)[0]) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("family", "knots"), [("cubic", 1), ("quintic", 0), ("septic", 0)])
def test_squared_derivatives_are_integrated_exactly(arm: Any, family: str, knots: int) -> None:
    degree = DEGREES[family]
    task = make_task(arm, family, knots, objective=Objective(acceleration=0.3, jerk=0.02), limits=Limits())
    nlp = LiftedNlp(task, initial_guess(task), SAMPLES, ExtraPoints())
    _, motion = states_near(np.random.default_rng(9), degree, nlp.layout.segments)
    expected = 0.0
    for order, weight in ((2, 0.3), (3, 0.02)):
        for segment, h in enumerate(motion.durations):
            for column in motion.coefficients(order, segment).T:
                expected += weight * np.polyval(np.polyint(np.polymul(column, column)), h)
    assert float(ca.Function("f", [nlp.x], [nlp.f])(variables(nlp, motion))) == pytest.approx(
        expected, rel=1e-9
    )


def test_units_are_travel_and_limits_or_what_the_guess_needs(arm: Any) -> None:
    waypoints = np.array([[0.0, 0.2, 1e-5], [0.5, 0.2, 0.0], [-0.4, 0.2, 0.0], [0.3, 0.2, 0.0]])
    velocity = [[-1.5, -0.5, -1e6], [1.0, 0.7, 2.0]]
    limits = Limits(velocity=velocity, acceleration=[np.inf, 0.3, 3.0], jerk=[1.0, np.inf, 1e9], torque=50.0)
    task = make_task(arm, "quintic", 1, waypoints=waypoints, limits=limits, constraints=())
    guess = initial_guess(task, np.array([0.5, 0.8, 0.7]))
    layout = LiftedNlp(task, guess, SAMPLES, ExtraPoints()).layout
    gap = guess.duration / 3
    travel = np.array(
        [0.9, 0.09, 9e-4]
    )  # a tenth, where a joint may move but need not; a thousandth at least
    needs = np.array([np.abs(guess(guess.breakpoints, order)).max(axis=0) for order in range(1, 5)])
    needs = np.maximum(needs, travel / gap ** np.arange(1.0, 5.0)[:, None])
    units = np.concatenate([travel[None], needs])
    units[1, :2], units[2, 1], units[3, 0] = [1.5, 0.7], 0.3, 1.0
    units[2, 2] = 3.0 if 100 * needs[1, 2] > 3.0 else needs[1, 2]
    assert 100 * needs[0, 2] < 1e6  # and 100 * needs[2, 2] < 1e9: limits that far away are no units
    np.testing.assert_allclose(layout.state_scales, units, rtol=1e-12)


@pytest.mark.parametrize(("lower", "upper"), [(0.0, np.inf), (-np.inf, 0.0), (0.0, 0.0)])
def test_a_limit_of_zero_is_no_unit(arm: Any, lower: float, upper: float) -> None:
    own = CustomConstraint("own", custom_function(), lower, upper)
    task = make_task(arm, "cubic", limits=Limits(torque=np.inf), constraints=(own,), objective=Objective())
    nlp = LiftedNlp(task, initial_guess(task), SAMPLES, ExtraPoints())
    _, motion = states_near(np.random.default_rng(5), 3, GAPS)
    rows: list[Row] = []
    for segment, fraction in [
        *[(s, k / SAMPLES) for s in range(GAPS) for k in range(SAMPLES)],
        (GAPS - 1, 1.0),
    ]:
        values = custom_values(arm, *motion.state(segment, fraction))
        rows += [("custom", -1, segment, fraction, value, lower, upper) for value in values]
    compare([row for row in told_rows(nlp, variables(nlp, motion)) if row[0] == "custom"], rows)
