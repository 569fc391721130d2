"""Ends, waypoints, torques, speeds and a user's own limits: what mutation testing found untested in them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from helpers.audit_motions import clamped_cubic, pendulum
from ocp_traj.audit import audit, conditions
from ocp_traj.audit.conditions import boundary_miss, waypoint_miss
from ocp_traj.audit.motion import Motion
from ocp_traj.audit.numerics import chebyshev
from ocp_traj.audit.torque import relative_bound, torque_curve
from ocp_traj.audit.verdict import Extremum
from ocp_traj.audit.waypoints import with_waypoint_times
from ocp_traj.exceptions import InputError
from ocp_traj.robot import load_robot
from ocp_traj.task import CustomConstraint, Limits, Objective, TrajectoryTask
from ocp_traj.trajectory import Trajectory

UNIT = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
"""3 t^2 - 2 t^3."""


def nameless(trajectory: Trajectory) -> Trajectory:
    return replace(trajectory, waypoint_times=trajectory.waypoint_times[[0, -1]])


def test_gaps_count_from_one_in_json() -> None:
    assert Extremum("velocity", 0, 0.0, 0.5, gap=2).to_json()["gap"] == 3


@pytest.mark.parametrize(("limit", "measure"), [(0.5, 0.5), (20.0, 20.0), (0.0, 1.5), (np.inf, 1.5)])
def test_a_missed_end_is_measured_by_its_limit_or_the_fastest_motion(limit: float, measure: float) -> None:
    # starts with 1e-3 instead of rest; the largest velocity is about 1.5
    motion = Trajectory([0.0, 1.0], [[[0.0, 1e-3, 3.0, -2.0]]], [0.0, 1.0])
    task = TrajectoryTask([[0.0], [1.001]], Limits(velocity=limit))
    largest, findings = boundary_miss(task, Motion.of(motion))
    assert largest == pytest.approx(1e-3 / measure, rel=1e-3)
    assert len(findings) == 2


def test_a_miss_of_just_the_tolerance_is_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=2.0))
    monkeypatch.setattr(conditions, "BOUNDARY_TOLERANCE", 0.0)
    assert boundary_miss(task, Motion.of(UNIT)) == (0.0, [])


@pytest.mark.parametrize(("before", "after"), [(0.0, 0.1), (0.0, -0.1), (0.1, 0.0), (-0.1, 0.0)])
def test_a_waypoint_is_missed_if_either_piece_misses_it(before: float, after: float) -> None:
    pieces = [[[0.0, 1.0 + before]], [[1.0 + after, 1.0 - after]]]
    motion = Trajectory([0.0, 1.0, 2.0], pieces, [0.0, 1.0, 2.0])
    miss, findings = waypoint_miss(TrajectoryTask([[0.0], [1.0], [2.0]]), Motion.of(motion))
    assert miss == pytest.approx(0.1)
    assert findings[0].startswith("waypoint 2: joint 1 misses it by 0.1 ")
    assert len(findings) == 1


def test_no_slowing_mends_a_jump_whatever_else_is_kept() -> None:
    motion = Trajectory([0.0, 0.5, 1.0], [[[0.0, 0.0, 2.0]], [[0.5, 2.0, -2.0]]], [0.0, 1.0])
    verdict = audit(TrajectoryTask([[0.0], [1.0]], Limits(velocity=3.0, jerk=1.0), virtual_knots=0), motion)
    assert np.isfinite(verdict.limits["velocity"].ratio)
    assert np.isinf(verdict.limits["jerk"].ratio)
    assert len(verdict.findings) == 1
    assert verdict.smallest_feasible_scale is None


def test_the_travel_is_that_of_the_joint_that_moves_most() -> None:
    motion = clamped_cubic(np.array([[0.0, 0.0], [1.0, 3.0], [0.5, 3.0]]), np.ones(2))
    assert Motion.of(motion).travel == pytest.approx(max(np.ptp(motion(np.linspace(0, 2, 20001)), axis=0)))


def test_equal_waypoints_are_passed_at_one_time_unless_their_gap_has_a_duration() -> None:
    waypoints = [[0.0], [0.5], [0.5], [1.0]]
    found = with_waypoint_times(TrajectoryTask(waypoints), UNIT)
    assert found.waypoint_times == pytest.approx([0.0, 0.5, 0.5, 1.0], abs=1e-9)
    assert found.waypoint_times[1] == found.waypoint_times[2]
    bounded = Objective(gap_durations=[[0.0, 9.0], [0.1, 9.0], [0.0, 9.0]])
    with pytest.raises(InputError, match="cannot be told from its shape"):
        with_waypoint_times(TrajectoryTask(waypoints, objective=bounded), UNIT)


def test_a_waypoint_passed_while_the_motion_rests_at_its_start_or_end_is_found() -> None:
    still, moving = [[0.0, 0.0, 0.0, 0.0]], [[0.0, 0.0, 3.0, -2.0]]
    late = Trajectory([0.0, 1.0, 2.0], [still, moving], [0.0, 2.0])
    early = Trajectory([0.0, 1.0, 2.0], [moving, [[1.0, 0.0, 0.0, 0.0]]], [0.0, 2.0])
    for motion, waypoint in ((late, 0.0), (early, 1.0)):
        task = TrajectoryTask([[0.0], [waypoint], [1.0]], Limits(velocity=2.0))
        found = with_waypoint_times(task, motion).waypoint_times
        assert motion(found[1]) == pytest.approx(waypoint, abs=1e-12)
        assert audit(task, motion).feasible


def test_a_waypoint_in_the_last_moment_is_preferred_to_one_that_was_nearly_passed_before() -> None:
    motion = clamped_cubic(np.array([[0.0], [0.8], [0.6], [1.0]]), np.ones(3))
    task = TrajectoryTask([[0.0], motion(2.97), [1.0]])
    found = with_waypoint_times(task, nameless(motion)).waypoint_times
    assert found == pytest.approx([0.0, 2.97, 3.0], abs=1e-7)


@pytest.mark.parametrize("time", [0.01, 0.055, 0.07, 0.93, 0.945, 0.99])
def test_a_waypoint_near_an_end_at_rest_is_found_as_exactly_as_any(time: float) -> None:
    """It was found at the nearest of the samples only, where the motion misses it."""
    waypoints = np.array([[0.0, 0.0], [1.0, 0.4]])
    motion = clamped_cubic(waypoints, np.array([1.0]))
    task = TrajectoryTask([waypoints[0], motion(time), waypoints[1]])
    found = with_waypoint_times(task, nameless(motion))
    assert found.waypoint_times == pytest.approx([0.0, time, 1.0], abs=1e-9)


@pytest.mark.parametrize("beyond", [-0.5, 1.5])
def test_a_waypoint_that_only_an_end_comes_near_is_an_error(beyond: float) -> None:
    """It ended in NumPy's error about an empty sequence."""
    with pytest.raises(InputError, match="cannot be told from its shape"):
        audit(TrajectoryTask([[0.0], [beyond], [1.0]]), UNIT)


def test_times_of_a_motion_out_of_all_bounds_are_an_error() -> None:
    motion = Trajectory([0.0, 100.0], [[[0.0, 1e308, -1e308, 0.0]]], [0.0, 100.0])
    with pytest.raises(InputError, match="cannot be told from its shape"), np.errstate(all="ignore"):
        with_waypoint_times(TrajectoryTask([[0.0], [0.5], [1.0]]), motion)


def own_limit(expression: Callable[[Any], Any], **bounds: Any) -> CustomConstraint:
    q, v, a, tau = (ca.SX.sym(name, 1) for name in ("q", "v", "a", "tau"))
    return CustomConstraint("own", ca.Function("own", [q, v, a, tau], [expression(v)]), **bounds)


@pytest.mark.parametrize(
    ("lower", "upper", "value", "bound"),
    [(-1.0, 1.6, 1.5, 1.6), (-0.1, 9.0, 0.0, -0.1), (1.0, 9.0, 0.0, 1.0)],
)
def test_the_bound_told_of_a_users_limit_is_the_nearer_one(
    lower: float, upper: float, value: float, bound: float
) -> None:
    task = TrajectoryTask([[0.0], [1.0]], constraints=(own_limit(lambda v: v, lower=lower, upper=upper),))
    peak = audit(task, UNIT).limits["constraint:own"]
    assert (peak.value, peak.bound) == (pytest.approx(value, abs=1e-9), bound)


def test_large_values_of_a_users_limit_are_resolved_as_far_as_rounding_lets() -> None:
    limit = own_limit(lambda v: 1e9 * (1.0 + ca.sin(3.0 * v)), lower=-1.0, scale=1.0)
    verdict = audit(TrajectoryTask([[0.0], [1.0]], Limits(velocity=2.0), constraints=(limit,)), UNIT)
    assert verdict.findings == ()


def caught_tolerances(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Return a list that fills with the tolerances curves are interpolated to."""
    caught: list[Any] = []
    fit = chebyshev.fit

    def catching(*arguments: Any, **settings: Any) -> Any:
        caught.append(arguments[4])
        return fit(*arguments, **settings)

    monkeypatch.setattr(chebyshev, "fit", catching)
    return caught


@pytest.mark.parametrize("rate", [0.02, 3.0])
@pytest.mark.parametrize("seconds", [0.1, 20.0])
def test_torques_are_as_exact_as_their_rates_need(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rate: float, seconds: float
) -> None:
    """An error e of a polynomial of degree n makes one of at most n^2 e in its derivative (Markov)."""
    task = TrajectoryTask([[0.0], [1.0]], Limits(torque=50.0, torque_rate=rate), robot=pendulum(tmp_path))
    tolerances = caught_tolerances(monkeypatch)
    torque_curve(task, Motion.of(UNIT.scaled(seconds)))
    (tolerance,) = tolerances
    slope = 2.0 / seconds * chebyshev.DEGREE**2
    assert tolerance(np.full(3, 1e-2)) == pytest.approx(
        np.full(3, min(1e-7 * rate / slope, 1e-9 * 3e-2)), rel=1e-9, abs=0.0
    )
    assert tolerance(np.full(3, 1e12)) == pytest.approx(np.full(3, 1e-13 * 3e12))


@pytest.mark.parametrize("limit", [0.5, 4.0])
def test_positions_of_frames_are_as_exact_as_their_speeds_need(
    monkeypatch: pytest.MonkeyPatch, limit: float
) -> None:
    motion = clamped_cubic(np.zeros((2, 6)) + np.array([[0.0], [0.3]]), np.array([0.2]))
    limits = Limits(velocity=np.inf, torque=np.inf, cartesian_speed=(("tool0", limit),))
    tolerances = caught_tolerances(monkeypatch)
    audit(TrajectoryTask(motion(motion.breakpoints), limits, robot=load_robot("ur5")), motion)
    positions, squares = tolerances
    assert positions(np.ones(3)) * 2.0 / 0.2 * chebyshev.DEGREE**2 == pytest.approx(
        np.full(3, 2e-9 * limit), rel=1e-9, abs=0.0
    )
    assert squares(np.array([0.1])) == pytest.approx(1e-10, rel=1e-9, abs=0.0)
    assert squares(np.array([100.0])) == pytest.approx(max(1e-9 * limit**2, 1e-10), rel=1e-9, abs=0.0)


def test_the_stated_bound_is_that_of_the_joint_and_segment_where_it_is_largest() -> None:
    robot = load_robot("ur5")
    motion = clamped_cubic(np.array([[0.0] * 6, [1.0, -1.0, 0.5, 0.2, -0.7, 0.3]]), np.array([0.4]))
    limits = Limits(velocity=np.inf, torque=[100.0, 80.0, np.inf, 9.0, 8.0, 7.0])
    task = TrajectoryTask(motion(motion.breakpoints), limits, robot=robot)
    curve = torque_curve(task, Motion.of(motion))
    largest = np.abs(curve.coefficients()).sum(axis=2).max()
    expected = (curve.bounds / np.array([100.0, 80.0, largest, 9.0, 8.0, 7.0])).max()
    assert relative_bound(task, curve) == pytest.approx(expected, rel=1e-9, abs=0.0)
    assert 0 < expected < 1e-8


def test_torques_of_nothing_are_bounded_by_nothing(tmp_path: Path) -> None:
    still = clamped_cubic(np.array([[0.5], [0.5]]), np.array([1.0]))
    for torque in (1.0, 1e9):
        limits = Limits(torque=torque, torque_rate=1.0)
        task = TrajectoryTask([[0.5], [0.5]], limits, robot=pendulum(tmp_path, gravity=0.0))
        assert audit(task, still).torque_bound == 0.0
