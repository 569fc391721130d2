"""Where a solver looks for broken limits between its samples, against dense sampling by SciPy."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from helpers.row_oracle import (
    LIMITS,
    WAYPOINTS,
    Motion,
    larger_finite,
    make_task,
    spline,
    torque,
    torque_rate,
)
from ocp_traj.solvers.gradient import refinement
from ocp_traj.solvers.gradient.refinement import broken_points, new_points, segment_gaps
from ocp_traj.task import Boundary, CustomConstraint, Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.lifted.lifted import ExtraPoints

FRACTIONS = np.linspace(0.0, 1.0, 401)
KNOTS = 1


def motion_through(degree: int, seed: int) -> tuple[Motion, Trajectory]:
    """Return a spline through the waypoints with a virtual knot in every gap."""
    rng = np.random.default_rng(seed)
    durations = rng.uniform(0.3, 0.8, 2 * len(WAYPOINTS) - 2)
    knots = np.repeat(WAYPOINTS, 2, axis=0)[:-1] + rng.normal(size=(2 * len(WAYPOINTS) - 1, 3)) * 0.1
    knots[::2] = WAYPOINTS
    ends = [(order, np.zeros(3)) for order in range(1, (degree - 1) // 2 + 1)]
    motion = spline(degree, durations, knots, ends, ends)
    coefficients = np.moveaxis(motion.pieces.c[::-1], 0, 2)
    return motion, Trajectory(motion.pieces.x, coefficients, motion.pieces.x[::2])


def over(values: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Return how far values are over (2,) bounds, in units of the larger one."""
    return np.asarray(np.maximum(values - bounds[1], bounds[0] - values) / larger_finite(*bounds))


def peaks_of(values: np.ndarray) -> list[float]:
    """Return the fractions of a segment where samples of an excess have broken local maxima."""
    padded = np.concatenate([[-np.inf], values, [-np.inf]])
    local = (values > 1e-6) & (values >= padded[:-2]) & (values >= padded[2:])
    return [float(fraction) for fraction in FRACTIONS[local]]


def assert_same_points(told: list[tuple[Any, ...]], expected: list[tuple[Any, ...]]) -> None:
    """Every broken peak is told once, near where it is."""
    told, expected = sorted(told), sorted(expected)
    assert [point[:-1] for point in told] == [point[:-1] for point in expected]
    for a, b in zip(told, expected):
        assert a[-1] == pytest.approx(b[-1], abs=2e-3)


@pytest.mark.parametrize(("degree", "family"), [(5, "quintic"), (7, "septic"), (3, "cubic")])
def test_every_broken_peak_of_a_derivative_is_found(arm: Any, degree: int, family: str) -> None:
    motion, trajectory = motion_through(degree, 2)
    limits = {name: LIMITS[name] for name in ("position", "velocity", "acceleration", "jerk")}
    limits["position"] = np.tile([[-0.42, -0.45, -0.12], [0.71, 0.52, 0.21]], (3, 1, 1))
    task = make_task(arm, family, KNOTS, limits=Limits(**limits, torque=np.inf), constraints=())
    moving = np.array([0, 2])
    expected = []
    for order, (_, bounds) in enumerate(limits.items()):
        if order >= degree - 1:
            continue
        for segment in range(6):
            for place, joint in enumerate(moving):
                own = bounds[segment // 2, :, joint]
                if np.isfinite(own).any():
                    excess = over(motion.at(order, segment, FRACTIONS)[:, joint], own)
                    expected += [(order, segment, place, fraction) for fraction in peaks_of(excess)]
    found = broken_points(task, trajectory, moving)
    assert found.instants == ()
    assert len(expected) >= 3
    assert_same_points(list(found.derivatives), expected)


@pytest.mark.parametrize("name", ["torque", "torque_rate"])
def test_every_broken_peak_of_an_instant_is_found(arm: Any, name: str) -> None:
    motion, trajectory = motion_through(5, 3)
    free = {"position": np.inf, "velocity": np.inf, "torque": np.inf}
    bounds = LIMITS[name] * (0.5 if name == "torque" else 0.3)
    task = make_task(arm, "quintic", KNOTS, limits=Limits(**{**free, name: bounds}), constraints=())
    orders = 3 if name == "torque" else 4
    function = torque if name == "torque" else torque_rate
    expected: set[tuple[int, float]] = set()
    for segment in range(6):
        states = [motion.state(segment, f, orders) for f in FRACTIONS]
        values = np.array([function(arm, *state) for state in states])
        for joint in range(3):
            own = bounds[segment // 2, :, joint]
            if np.isfinite(own).any():
                expected |= {(segment, f) for f in peaks_of(over(values[:, joint], own))}
    found = broken_points(task, trajectory, np.arange(3))
    assert found.derivatives == ()
    assert len(expected) >= 3
    assert_same_points(list(found.instants), sorted(expected))


def parabola_task(limit: float, side: int = 1, **changes: Any) -> tuple[TrajectoryTask, Trajectory]:
    """Return a motion whose velocity 6 t (1 - t) has its peak 1.5 at 0.5 s, and a limit on that side."""
    sign = 1.0 if side else -1.0
    velocity = np.array([[-100.0], [100.0]])
    velocity[side] = sign * limit
    task = TrajectoryTask([[0.0], [sign]], Limits(velocity=velocity), family="quintic", **changes)
    coefficients = [[[0.0, 0.0, 3.0 * sign, -2.0 * sign, 0.0, 0.0]]]
    return task, Trajectory([0.0, 1.0], coefficients, [0.0, 1.0])


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize(("part", "found"), [(2e-7, True), (0.5e-7, False)])
def test_what_is_over_by_less_than_the_tolerance_is_left_alone(part: float, found: bool, side: int) -> None:
    task, motion = parabola_task(1.0, side)
    task = task.changed(limits=Limits(velocity=1.5 / (1 + part)))
    points = broken_points(task, motion, np.array([0])).derivatives
    assert [point[:3] for point in points] == ([(1, 0, 0)] if found else [])
    for point in points:
        assert point[3] == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize(("part", "found"), [(2e-7, True), (0.5e-7, False)])
@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_the_tolerance_is_a_part_of_the_limit(size: float, part: float, found: bool) -> None:
    coefficients = size * np.array([[[0.0, 0.0, 3.0, -2.0, 0.0, 0.0]]])
    velocity = np.array([[-0.5], [1.5 / (1 + part)]]) * size
    task = TrajectoryTask([[0.0], [size]], Limits(velocity=velocity), family="quintic")
    points = broken_points(task, Trajectory([0.0, 1.0], coefficients, [0.0, 1.0]), np.array([0])).derivatives
    assert len(points) == found


@pytest.mark.parametrize(("start", "rate"), [(0.0, 1.0), (1.0, -1.0)])
@pytest.mark.parametrize(("limit", "found"), [(1.001, False), (0.999, True)])
def test_nothing_outside_a_segment_counts(start: float, rate: float, limit: float, found: bool) -> None:
    """The velocity is largest at an end of the motion and would go on growing beyond."""
    coefficients = [[[0.0, start, rate / 2, 0.0, 0.0, 0.0]]]
    motion = Trajectory([0.0, 1.0], coefficients, [0.0, 1.0])
    ends = Boundary([[start], [start + rate]])
    task = TrajectoryTask([[0.0], [0.5]], Limits(velocity=limit), family="quintic", boundary=ends)
    points = broken_points(task, motion, np.array([0])).derivatives
    assert points == (((1, 0, 0, start + rate),) if found else ())


def test_a_peak_between_two_samples_that_keep_the_limit_is_found() -> None:
    """The peak lies about half-way between two of the samples, both of which are below the limit."""
    count = refinement.DENSE
    peak = (count // 2 + 0.45) / count
    # velocity 1 - 4 (t - peak)^2
    coefficients = [[[0.0, 1 - 4 * peak**2, 4 * peak, -4 / 3]]]
    motion = Trajectory([0.0, 1.0], coefficients, [0.0, 1.0])
    end = float(motion(1.0)[0])
    for limit, broken in ((1 - 0.6 / count**2, True), (1 + 1e-6, False)):
        assert 1 - 4 * (0.45 / count) ** 2 < limit
        task = TrajectoryTask(
            [[0.0], [end]],
            Limits(velocity=limit, acceleration=100.0),
            family="quintic",
            boundary=Boundary([[1 - 4 * peak**2], [float(motion(1.0, 1)[0])]]),
        )
        padded = Trajectory([0.0, 1.0], [[[*coefficients[0][0], 0.0, 0.0]]], [0.0, 1.0])
        points = broken_points(task, padded, np.array([0])).derivatives
        assert [(point[:3], round(point[3], 6)) for point in points] == (
            [((1, 0, 0), round(peak, 6))] if broken else []
        )


def test_a_limit_of_zero_is_broken_in_absolute_terms() -> None:
    task, motion = parabola_task(1.0)
    task = task.changed(limits=Limits(velocity=[[0.0], [0.0]]))
    ((order, segment, joint, fraction),) = broken_points(task, motion, np.array([0])).derivatives
    assert (order, segment, joint) == (1, 0, 0)
    assert fraction == pytest.approx(0.5, abs=1e-6)


def test_a_custom_limit_is_looked_at_between_samples_too(arm: Any) -> None:
    q, v, a, tau = (ca.SX.sym(name, 3) for name in ("q", "v", "a", "tau"))
    limit = CustomConstraint("own", ca.Function("own", [q, v, a, tau], [v[1]]), -0.2, 0.3)
    motion, trajectory = motion_through(5, 4)
    free = Limits(position=np.inf, velocity=np.inf, torque=np.inf)
    task = make_task(arm, "quintic", KNOTS, limits=free, constraints=(limit,))
    bounds = np.array([-0.2, 0.3])
    expected = [
        (segment, fraction)
        for segment in range(6)
        for fraction in peaks_of(over(motion.at(1, segment, FRACTIONS)[:, 1], bounds))
    ]
    assert_same_points(list(broken_points(task, trajectory, np.arange(3)).instants), expected)


def test_segments_lie_in_the_gaps_of_their_waypoints() -> None:
    _, trajectory = motion_through(3, 5)
    assert segment_gaps(trajectory).tolist() == [0, 0, 1, 1, 2, 2]


def test_points_known_already_are_not_added_again() -> None:
    known = ExtraPoints(((1, 0, 0, 0.5),), ((2, 0.25),))
    near = ExtraPoints(((1, 0, 0, 0.5 + 0.9e-5),), ((2, 0.25),))
    added = new_points(known, near)
    assert (1, 0, 0, 0.5 + 0.9e-5) not in added.derivatives
    assert new_points(ExtraPoints(), ExtraPoints(((1, 0, 0, 0.5), (1, 0, 1, 0.5)))).derivatives == (
        (1, 0, 0, 0.5),
        (1, 0, 1, 0.5),
    )


def test_positions_get_points_all_over_the_segment_and_again_half_way_between() -> None:
    eighths = [k / 8 for k in range(1, 8)]
    first = new_points(ExtraPoints(), ExtraPoints(((0, 3, 1, 0.3),))).derivatives
    assert first == ((0, 3, 1, 0.3), *[(0, 3, 1, fraction) for fraction in eighths])
    second = new_points(ExtraPoints(first), ExtraPoints(((0, 3, 1, 0.31),))).derivatives
    halving = [(0, 3, 1, k / 16) for k in range(1, 16, 2)]
    assert second[:9] == ((0, 3, 1, 0.31), *halving)
    closing = [0.305, 0.315, 0.30875, 0.31125]  # halves and eighths of the distance to the nearest, 0.3
    assert [fraction for *_, fraction in second[9:]] == pytest.approx(closing)


def test_other_limits_get_them_when_their_peaks_wander() -> None:
    known = ExtraPoints(((2, 3, 1, 0.3), (2, 4, 1, 0.3)))
    found = new_points(known, ExtraPoints(((2, 3, 1, 0.4), (2, 3, 0, 0.7)))).derivatives
    assert found[:9] == ((2, 3, 1, 0.4), *[(2, 3, 1, k / 16) for k in range(1, 16, 2)])
    assert [fraction for *_, fraction in found[9:13]] == pytest.approx([0.35, 0.45, 0.3875, 0.4125])
    assert found[13:] == ((2, 3, 0, 0.7),)


def test_instants_get_points_on_both_sides_nearer_where_there_are_neighbours() -> None:
    alone = new_points(ExtraPoints(), ExtraPoints((), ((1, 0.5), (2, 0.0)))).instants
    assert alone == ((1, 0.5), (1, 0.45), (1, 0.55), (2, 0.0), (2, 0.05))
    beside = new_points(
        ExtraPoints((), ((1, 0.48), (0, 0.499))), ExtraPoints((), ((1, 0.5), (1, 1.0)))
    ).instants
    assert beside == ((1, 0.5), (1, 0.49), (1, 0.51), (1, 1.0), (1, 0.74))
