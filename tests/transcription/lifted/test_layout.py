"""Variables of the lifted form: which there are, their bounds and units, and the motion they stand for."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from helpers.lifted_rows import (
    SAMPLES,
    compare,
    instant_rows,
    linear_rows,
    states_near,
    told_rows,
    variables,
)
from helpers.row_oracle import (
    DEGREES,
    GAPS,
    LIMITS,
    ORDERS,
    WAYPOINTS,
    make_task,
    spline,
    unconnected,
)
from ocp_traj.task import (
    Boundary,
    Limits,
    Objective,
    TrajectoryTask,
)
from ocp_traj.transcription import initial_guess
from ocp_traj.transcription.lifted.lifted import ExtraPoints, LiftedNlp

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
