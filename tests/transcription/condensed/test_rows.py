"""Every row of the condensed form and what populations are told of it, against values worked out apart."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.interpolate import PPoly

from helpers.row_oracle import (
    CUSTOM_BOUNDS,
    DEGREES,
    FRAMES,
    GAPS,
    INSTANTS,
    LIMITS,
    ORDERS,
    Motion,
    custom_function,
    instant_limits,
    larger_finite,
    make_arm,
    make_task,
    spline,
    torque,
)
from ocp_traj.audit import audit
from ocp_traj.limits.limit import bound_scales
from ocp_traj.task import Boundary, CustomConstraint, Limits, Motor, Objective, TrajectoryTask
from ocp_traj.transcription import transcribe
from ocp_traj.transcription.condensed.condensed import CondensedNlp
from ocp_traj.transcription.condensed.limit_rows import LimitRows

SAMPLES = 6
CANDIDATES = 3
ENDS = ("velocity", "acceleration", "jerk")


def motion_of(task: TrajectoryTask, durations: np.ndarray, offsets: np.ndarray) -> Motion:
    """Return SciPy's spline through waypoints and virtual knots; a free derivative is natural."""
    degree, per_gap = DEGREES[task.family], task.virtual_knots + 1
    knots = np.empty((GAPS * per_gap + 1, task.n))
    for knot in range(len(knots)):
        gap, share = min(knot // per_gap, GAPS - 1), knot / per_gap
        share -= gap
        knots[knot] = task.waypoints[gap] * (1 - share) + task.waypoints[gap + 1] * share
        if knot % per_gap:
            knots[knot] += (
                offsets[gap * (per_gap - 1) + knot % per_gap - 1] * np.ptp(task.waypoints, axis=0) / 2
            )
    ends: list[list[Any]] = [[], []]
    for side in (0, 1):
        for order in range(1, (degree - 1) // 2 + 1):
            given = getattr(task.boundary, ENDS[order - 1])
            instead = getattr(task.boundary, ENDS[degree - order - 1]) if degree - order <= 3 else None
            if given is None and instead is not None:
                order, given = degree - order, instead
            ends[side].append((degree - order, np.zeros(task.n)) if given is None else (order, given[side]))
    return spline(degree, durations, knots, *ends)


def decoded(nlp: CondensedNlp, x: np.ndarray) -> Motion:
    """Return the motion the problem makes of x, as SciPy's polynomials; for families that SciPy has not."""
    trajectory = nlp.decode(x)
    pieces = PPoly(np.moveaxis(np.asarray(trajectory.coefficients), 2, 0)[::-1], trajectory.breakpoints)
    return Motion(pieces, np.empty((len(trajectory.breakpoints), 3, nlp.task.n)))


def candidates(nlp: CondensedNlp, count: int = CANDIDATES) -> np.ndarray:
    return np.random.default_rng(12).uniform(nlp.lower, nlp.upper, (count, nlp.dimension))


def motion_for(nlp: CondensedNlp, x: np.ndarray, scale: float = 1.0) -> Motion:
    task = nlp.task
    if task.family not in DEGREES:
        return decoded(nlp, x)
    durations = x[: nlp.segments] if str(nlp.encoding) == "durations" else np.exp(x[: nlp.segments])
    return motion_of(task, durations * scale, x[nlp.segments :].reshape(-1, task.n))


def grid(per_gap: int) -> list[float]:
    count = max(2, 2 * round(SAMPLES / (2 * per_gap)))
    return [1.0 - k / count for k in range(count + 1)]


def expected_rows(task: TrajectoryTask, robot: Any, motion: Motion, exact: bool) -> list[tuple[Any, ...]]:
    """Return (limit, joint, gap, inside, value, lower, upper) of every row in order, in units of the limit."""
    per_gap = task.virtual_knots + 1
    segments = GAPS * per_gap
    rows: list[tuple[Any, ...]] = []

    def add(
        name: str, joint: int, segment: int, fraction: float, value: float, bounds: Any, scale: float
    ) -> None:
        place = (name, joint, segment // per_gap, (segment % per_gap + fraction) / per_gap)
        rows.append((*place, value / scale, bounds[0] / scale, bounds[1] / scale))

    for name, order in ORDERS.items():
        closed = exact and order > 0
        points = [0.0, 1.0] if closed else grid(per_gap)
        table = [
            motion.extremes(order, s) if closed else motion.at(order, s, points) for s in range(segments)
        ]
        for joint in range(task.n):
            if not np.isfinite(LIMITS[name][:, :, joint]).any():
                continue
            for index, fraction in enumerate(points):
                for segment in range(segments):
                    bounds = LIMITS[name][segment // per_gap, :, joint]
                    scale = larger_finite(*bounds) if np.isfinite(bounds).any() else 1.0
                    add(name, joint, segment, fraction, table[segment][index, joint], bounds, scale)
    states = [
        np.stack([motion.at(order, s, grid(per_gap)) for order in range(4)], axis=1) for s in range(segments)
    ]
    for name in INSTANTS:
        function, bounds, joints, orders = instant_limits(robot, name)
        table = [np.array([function(*state[:orders]) for state in of_segment]) for of_segment in states]
        for k, joint in enumerate(joints):
            for index, fraction in enumerate(grid(per_gap)):
                for segment in range(segments):
                    own = bounds[segment // per_gap, :, k]
                    scale = larger_finite(*own) if np.isfinite(own).any() else 1.0
                    if name == "custom":  # one scale for all values of a function
                        scale = larger_finite(*CUSTOM_BOUNDS.ravel())
                    add(name, joint, segment, fraction, table[segment][index, k], own, scale)
    h = motion.durations.reshape(GAPS, per_gap).sum(axis=1)
    rows.append(("duration", -1, 0, 0.0, h.sum() / 5.0, 3.0 / 5.0, 1.0))
    rows.append(("duration", -1, 0, 0.0, h[0] / 2.0, 0.25, 1.0))
    rows.append(("duration", -1, 1, 0.0, h[1] / 1.5, -np.inf, 1.0))
    rows.append(("duration", -1, 2, 0.0, h[2] / 0.7, 1.0, np.inf))
    return rows


@pytest.mark.parametrize(
    ("family", "knots", "boundary", "extrema"),
    [
        ("cubic", 0, Boundary(), "auto"),
        ("cubic", 1, Boundary([[0.1, -0.2, 0.3], [0.2, 0.1, -0.1]]), "exact"),
        ("cubic", 2, Boundary(), "sampled"),
        ("quintic", 0, Boundary(0.0, [[0.5, 0.4, -0.3], [0.1, -0.6, 0.2]]), "auto"),
        ("quintic", 1, Boundary(0.0, None), "auto"),
        ("quintic", 1, Boundary(0.0, None, [[3.0, 2.0, -1.0], [1.0, -2.0, 4.0]]), "auto"),
        ("septic", 0, Boundary(0.0, [[0.5, 0.4, -0.3], [0.1, -0.6, 0.2]], None), "auto"),
        ("3-5-3", 0, Boundary(0.0, [[0.5, 0.4, -0.3], [0.1, -0.6, 0.2]]), "auto"),
    ],
)
def test_every_row_has_the_value_and_the_bounds_worked_out_apart(
    arm: Any, family: str, knots: int, boundary: Boundary, extrema: str
) -> None:
    task = make_task(arm, family, knots, boundary=boundary)
    nlp = CondensedNlp(task, samples=SAMPLES, extrema=extrema)
    X = candidates(nlp)
    symbols = ca.Function("g", [nlp.x], [nlp.g])
    evaluation = nlp.evaluate(X)
    for k, x in enumerate(X):
        motion = motion_for(nlp, x)
        rows = expected_rows(task, arm, motion, extrema != "sampled" and family != "septic")
        if k == 0:
            told = [
                (block.limit, joint, gap, fraction)
                for block in nlp.rows
                for joint, gap, fraction in zip(block.joint, block.gap, block.fraction)
            ]
            assert [row[:3] for row in told] == [row[:3] for row in rows]
            np.testing.assert_allclose([row[3] for row in told], [row[3] for row in rows], atol=1e-12)
        values, lower, upper = np.array([row[4:] for row in rows]).T
        np.testing.assert_allclose(nlp.g_lower, lower, rtol=1e-12)
        np.testing.assert_allclose(nlp.g_upper, upper, rtol=1e-12)
        np.testing.assert_allclose(np.array(symbols(x)).ravel(), values, rtol=1e-8, atol=1e-9)
        violation = np.maximum(np.maximum(values - upper, lower - values), 0.0)
        np.testing.assert_allclose(evaluation.violation[k], violation, rtol=1e-8, atol=1e-9)
        assert evaluation.cost[k] == pytest.approx(motion.durations.sum())
    assert (evaluation.violation > 1e-3).any(axis=0).sum() > 30  # the comparison is not of zeros


@pytest.mark.parametrize("encoding", ["durations", "log-durations"])
def test_the_box_is_the_case_s_shared_among_segments(arm: Any, encoding: str) -> None:
    nlp = CondensedNlp(make_task(arm, "cubic", 2), encoding=encoding)
    turned = np.log if encoding == "log-durations" else np.asarray
    np.testing.assert_allclose(nlp.lower, [*[turned(0.25 / 3)] * 9, *[-1.0] * 18])
    np.testing.assert_allclose(nlp.upper, [*[turned(1.5 / 3)] * 9, *[1.0] * 18])
    assert nlp.dimension == 27
    x = candidates(nlp, 1)[0]
    np.testing.assert_allclose(nlp.encode(nlp.decode(x)), x, atol=1e-9)


TORQUE_LIMITS = (
    np.array([[[-30.0, -70.0, -14.0], [25.0, 80.0, 17.0]]] * 3) * np.array([1.0, 1.2, 0.9])[:, None, None]
)
FRICTIONS = {"none": (0.0, 0.0), "viscous": (3.0, 0.0), "coulomb": (0.0, 2.0), "both": (2.0, 1.0)}


def largest_excess(robot: Any, motion: Motion, names: Any, per_gap: int) -> float:
    """Return by how much a motion is over a limit, in units of the limit, where largest."""
    worst = -np.inf
    for segment in range(GAPS * per_gap):
        gap = segment // per_gap
        for name, bounds in names.items():
            if name in ORDERS:
                values = motion.extremes(ORDERS[name], segment)
                found = np.maximum(values[0] / bounds[gap, 1], values[1] / bounds[gap, 0])
                worst = max(worst, float(found.max()) - 1.0)
            else:
                for fraction in grid(per_gap):
                    tau = torque(robot, *motion.state(segment, fraction))
                    worst = max(
                        worst, float(np.maximum(tau / bounds[gap, 1], tau / bounds[gap, 0]).max()) - 1.0
                    )
    return worst


@pytest.mark.parametrize("limit", ["velocity", "acceleration", "jerk", *FRICTIONS])
@pytest.mark.parametrize(("family", "knots"), [("cubic", 0), ("quintic", 1)])
def test_the_best_speed_keeps_every_limit_and_touches_one(
    arm: Any, tmp_path: Any, family: str, knots: int, limit: str
) -> None:
    if limit in FRICTIONS:
        robot, names = make_arm(tmp_path, FRICTIONS[limit]), {"torque": TORQUE_LIMITS}
    else:
        robot, names = arm, {limit: LIMITS[limit].copy()}
    free = {"velocity": np.inf, "torque": np.inf, "position": np.inf}
    task = make_task(
        robot,
        family,
        knots,
        limits=Limits(**{**free, **names}),
        constraints=(),
        objective=Objective(time=2.0),
    )
    nlp = CondensedNlp(task, encoding="scaled", samples=SAMPLES)
    X = candidates(nlp)
    evaluation = nlp.evaluate(X)
    assert evaluation.violation.max(initial=0.0) < 1e-12
    for k, x in enumerate(X):
        total = float(np.exp(x[: nlp.segments]).sum())
        scale = nlp.decode(x).duration / total
        assert evaluation.cost[k] == pytest.approx(2.0 * total * scale, rel=1e-12)
        slow, fast = (motion_for(nlp, x, scale * factor) for factor in (1 + 1e-9, 1 - 1e-6))
        assert largest_excess(robot, slow, names, knots + 1) <= 1e-10
        assert largest_excess(robot, fast, names, knots + 1) > 0


def test_frames_set_the_best_speed_too(arm: Any) -> None:
    limits = Limits(velocity=np.inf, torque=np.inf, cartesian_speed=FRAMES)
    task = make_task(arm, "cubic", limits=limits, constraints=(), objective=Objective(time=1.0))
    nlp = CondensedNlp(task, encoding="scaled", samples=SAMPLES)
    for x in candidates(nlp):
        scale = nlp.decode(x).duration / float(np.exp(x).sum())
        motion = motion_for(nlp, x)
        function, bounds, _, _ = instant_limits(arm, "cartesian_speed")
        found = [function(*motion.state(s, f)) / bounds[0, 1] for s in range(GAPS) for f in grid(1)]
        assert scale == pytest.approx(np.sqrt(np.max(found)), rel=1e-9)


def test_what_stands_still_over_a_torque_limit_is_told_in_units_of_the_limit(arm: Any) -> None:
    """Gravity alone: of the arm at the sampled positions, which do not depend on the speed."""
    bounds = np.array([[-1e3, -2.0, -1e3], [1e3, 5.0, 1e3]])
    for own in (bounds, -bounds[::-1]):
        task = make_task(
            arm, "cubic", limits=Limits(position=LIMITS["position"], velocity=2.0, torque=own), constraints=()
        )
        nlp = CondensedNlp(task, encoding="scaled", samples=SAMPLES)
        X = candidates(nlp)
        names = [block.limit for block in nlp.rows for _ in range(len(block))]
        row = names.index("limits at rest")
        assert names[row + 1 :] == ["duration"] * 4
        assert set(names[:row]) == {"position"}
        for k, x in enumerate(X):
            motion = motion_for(nlp, x)
            still = [
                torque(arm, motion.at(0, s, f), np.zeros(3), np.zeros(3))[1]
                for s in range(GAPS)
                for f in grid(1)
            ]
            excess = max(np.max(still) - own[1, 1], own[0, 1] - np.min(still)) / 5.0
            assert nlp.evaluate(X).violation[k, row] == pytest.approx(excess, rel=1e-9)
            assert excess > 0


def test_bounds_of_a_custom_limit_are_divided_by_its_scale(arm: Any) -> None:
    from ocp_traj.limits.custom import CustomLimit, custom_scale

    function = custom_function()
    given = CustomConstraint("own", function, [-4.0, -np.inf], [8.0, 2.0], scale=0.5)
    plain = CustomConstraint("own", function, [-4.0, -np.inf], [3.0, 2.0])
    none = CustomConstraint("own", function, 0.0, np.inf)
    assert [custom_scale(each) for each in (given, plain, none)] == [0.5, 4.0, 1.0]
    task = make_task(arm, "cubic", constraints=(given, plain, none))
    limit = CustomLimit()
    assert limit.joints(task) == [-1] * 6
    bounds = [[-8.0, -np.inf, -1.0, -np.inf, 0.0, 0.0], [16.0, 4.0, 0.75, 0.5, np.inf, np.inf]]
    np.testing.assert_array_equal(limit.bounds(task), [bounds] * GAPS)
    assert not limit.applies(make_task(arm, "cubic", constraints=()))
    np.testing.assert_array_equal(limit.scales(task), np.ones((GAPS, 6)))  # and by nothing else


@pytest.mark.parametrize("scale", [None, 2.0, 100.0])
def test_a_custom_limit_is_over_by_its_own_scale_in_both_forms_and_the_audit(scale: float | None) -> None:
    q, v, a, tau = (ca.SX.sym(name, 1) for name in ("q", "v", "a", "tau"))
    top = CustomConstraint("own", ca.Function("own", [q, v, a, tau], [q]), -0.5, 0.5, scale)
    task = TrajectoryTask([[0.0], [1.5], [0.0]], Limits(velocity=1.0), constraints=(top,))
    over = 1.0 / (scale or 0.5)  # the waypoint itself
    condensed, lifted = transcribe(task, "condensed"), transcribe(task, "lifted")
    found = [float(nlp.evaluate(np.asarray(nlp.guess)[None]).violation.max()) for nlp in (condensed, lifted)]
    assert found == pytest.approx([over, over], rel=1e-6)
    verdict = audit(task, condensed.decode(np.asarray(condensed.guess)))
    assert verdict.worst is not None and verdict.worst.ratio == pytest.approx(1.0 + over, rel=1e-6)


COSTS = {
    "energy": lambda robot, q, v, a: np.abs(torque(robot, q, v, a) * v).sum(),
    "energy_without_regeneration": lambda robot, q, v, a: np.maximum(torque(robot, q, v, a) * v, 0.0).sum(),
    "torque": lambda robot, q, v, a: np.square(torque(robot, q, v, a) / [1.0, 9.0, 12.0]).sum(),
    "acceleration": lambda robot, q, v, a: np.square(a).sum(),
    "motor_loss": lambda robot, q, v, a: (np.square(torque(robot, q, v, a)) * [2e-3, 8e-3, 18e-3]).sum(),
}
MOTOR = Motor(torque_constant=[1.0, 0.5, 1 / 3], resistance=0.2, gear_ratio=10.0)


@pytest.mark.parametrize("encoding", ["durations", "scaled"])
@pytest.mark.parametrize("name", COSTS)
def test_costs_of_populations_are_integrals_of_what_pinocchio_says(
    arm: Any, name: str, encoding: str
) -> None:
    limits = Limits(torque=[[-np.inf, -9.0, -8.0], [np.inf, 7.0, 12.0]], velocity=2.0, position=np.inf)
    task = make_task(
        arm,
        "cubic",
        1,
        objective=Objective(time=0.5, duration=(0.0, 9.0), motor=MOTOR, **{name: 0.3}),
        limits=limits,
        constraints=(),
    )
    nlp = CondensedNlp(task, encoding=encoding, samples=8)
    X = candidates(nlp)
    for x, cost in zip(X, nlp.evaluate(X).cost):
        scale = 1.0 if encoding == "durations" else nlp.decode(x).duration / np.exp(x[: nlp.segments]).sum()
        motion = motion_for(nlp, x, scale)
        total = 0.5 * motion.durations.sum()
        for segment, h in enumerate(motion.durations):
            values = [COSTS[name](arm, *motion.state(segment, k / 4)) for k in range(5)]
            # Simpson's rule, exact for the square of a cubic's acceleration
            total += 0.3 * h / 12 * np.dot([1.0, 4.0, 2.0, 4.0, 1.0], values)
        assert cost == pytest.approx(total, rel=1e-9)


def test_whatever_is_over_a_limit_of_zero_is_infinitely_over() -> None:
    values = np.array([[[0.0, 0.5, -0.5, 1e-3]]])
    symmetric, one_sided = (
        LimitRows.of("velocity", [0], bounds, bound_scales(bounds), (0.0,), 1)
        for bounds in (np.array([[[lower], [0.0]]]) for lower in (0.0, -2.0))
    )
    assert symmetric.ratio(0, values).tolist() == [0.0, np.inf, np.inf, np.inf]
    assert one_sided.ratio(0, values).tolist() == [0.0, np.inf, 0.25, np.inf]


def test_segments_are_grouped_by_their_degree() -> None:
    from ocp_traj.transcription.condensed.exact_rows import _groups

    for degrees in (
        (3,),
        (5, 5),
        (3, 5, 3),
        (3, 5, 5, 3),
        (3, 5, 5),
        (5, 5, 3),
        (3, 5, 3, 5, 3),
        (3, 3, 5, 3, 3),
    ):
        found = np.zeros(len(degrees), dtype=int)
        for degree, segments in _groups(degrees):
            assert (found[segments] == 0).all()
            found[segments] = degree
        assert tuple(found) == degrees


def test_violations_of_rows_are_what_is_over_either_bound(arm: Any) -> None:
    nlp = CondensedNlp(make_task(arm, "cubic", 0, limits=Limits(velocity=1.0, torque=np.inf), constraints=()))
    g = np.asarray(nlp.g_upper) + np.where(np.isfinite(nlp.g_upper), 0.25, 0.0)
    g[np.isinf(g)] = 1.5
    np.testing.assert_allclose(nlp.violations(g)[:-1], 0.25)
    low = np.where(np.isfinite(nlp.g_lower), np.asarray(nlp.g_lower) - 0.5, 0.0)
    np.testing.assert_allclose(nlp.violations(low), np.where(np.isfinite(nlp.g_lower), 0.5, 0.0))
