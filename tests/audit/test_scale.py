"""The smallest uniform slowing: it is feasible, a little less is not, and it is None exactly when it has to be."""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from helpers.audit_motions import INERTIA, clamped_cubic, pendulum, random_spline
from ocp_traj.audit import Verdict, audit, scale
from ocp_traj.robot import Robot, load_robot
from ocp_traj.robot.additions import Friction
from ocp_traj.task import Boundary, CustomConstraint, Limits, Objective, TrajectoryTask
from ocp_traj.trajectory import Trajectory


def largest_ratio(verdict: Verdict) -> float:
    return max(peak.ratio for peak in verdict.limits.values())


def check_smallest(task: TrajectoryTask, trajectory: Trajectory) -> float:
    """Assert that the scale found is feasible and the smallest in its neighbourhood; return it."""
    verdict = audit(task, trajectory)
    scale = verdict.smallest_feasible_scale
    assert scale is not None
    slowed = audit(task, trajectory.scaled(scale))
    assert slowed.feasible
    assert largest_ratio(slowed) <= 1 + 1e-8
    assert slowed.smallest_feasible_scale == pytest.approx(1.0, abs=1e-8)
    faster = audit(task, trajectory.scaled(scale * (1 - 1e-5)))
    assert largest_ratio(faster) > 1 + 1e-6
    return scale


@pytest.mark.parametrize("seed", range(6))
def test_kinematic_limits_scale_with_their_power_of_time(seed: int) -> None:
    rng = np.random.default_rng(seed)
    trajectory = random_spline(rng, 5, 3, 4)
    waypoints = trajectory(trajectory.waypoint_times)
    size = np.abs(trajectory(np.linspace(0, trajectory.duration, 99), 1)).max()
    limits = Limits(
        **{name: size * 10.0 ** rng.uniform(-1, 2) for name in ("velocity", "acceleration", "jerk")}
    )
    task = TrajectoryTask(waypoints, limits, family="quintic")
    ratios = {name: peak.ratio for name, peak in audit(task, trajectory).limits.items()}
    expected = max(ratios["velocity"], ratios["acceleration"] ** 0.5, ratios["jerk"] ** (1 / 3))
    assert check_smallest(task, trajectory) == pytest.approx(expected, rel=1e-12)


@pytest.fixture(scope="module")
def robots() -> dict[str, Robot]:
    ur5 = load_robot("ur5")
    friction = Friction(np.array([5.0, 9.0, 4.0, 1.0, 1.0, 1.0]), np.array([1.0, 2.0, 0.0, 1.0, 0.5, 1.0]))
    return {"plain": ur5, "rubbing": ur5.with_changes(friction=friction)}


@pytest.mark.parametrize("name", ["plain", "rubbing"])
@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("rate", [False, True])
def test_torque_limits_are_met_to_the_last_bit(
    robots: dict[str, Robot], name: str, seed: int, rate: bool
) -> None:
    rng = np.random.default_rng(seed)
    waypoints = rng.uniform(-1.5, 1.5, (4, 6))
    trajectory = clamped_cubic(waypoints, rng.uniform(0.1, 0.6, 3))
    limits = Limits(
        position=np.inf,
        velocity=np.inf,
        torque=[150, 150, 150, 28, 28, 28],
        torque_rate=[2000.0, 2000.0, 2000.0, 200.0, 200.0, 200.0] if rate else None,
    )
    task = TrajectoryTask(waypoints, limits, robot=robots[name])
    check_smallest(task, trajectory)


@pytest.mark.parametrize("seconds", [1e-5, 1e-2, 1e2, 1e5])
def test_the_scale_does_not_depend_on_where_it_starts(robots: dict[str, Robot], seconds: float) -> None:
    rng = np.random.default_rng(8)
    waypoints = rng.uniform(-1.5, 1.5, (4, 6))
    trajectory = clamped_cubic(waypoints, rng.uniform(0.3, 0.6, 3))
    task = TrajectoryTask(waypoints, Limits(position=np.inf, velocity=np.inf), robot=robots["rubbing"])
    near = check_smallest(task, trajectory)
    far = audit(task, trajectory.scaled(seconds)).smallest_feasible_scale
    assert far is not None
    assert far * seconds == pytest.approx(near, rel=1e-8)


def test_torque_and_a_users_constraint_are_kept_together(robots: dict[str, Robot]) -> None:
    rng = np.random.default_rng(9)
    waypoints = rng.uniform(-1.5, 1.5, (3, 6))
    trajectory = clamped_cubic(waypoints, np.array([0.3, 0.4]))
    symbols = [ca.SX.sym(name, 6) for name in ("q", "v", "a", "tau")]
    power = CustomConstraint("power", ca.Function("p", symbols, [ca.dot(symbols[1], symbols[3])]), upper=10.0)
    limits = Limits(position=np.inf)
    task = TrajectoryTask(waypoints, limits, robot=robots["plain"], constraints=(power,))
    free = audit(task.changed(constraints=()), trajectory).smallest_feasible_scale
    assert free is not None
    assert check_smallest(task, trajectory) > free


def test_the_torque_part_is_the_hand_computed_one(tmp_path: Path) -> None:
    # no gravity: I a / s^2 + b v / s; at the start v = 0 and a = 6, so s^2 = 6 I / limit for small friction
    trajectory = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    task = TrajectoryTask(
        [[0.0], [1.0]], Limits(velocity=np.inf, torque=1.2), robot=pendulum(tmp_path, gravity=0.0)
    )
    assert audit(task, trajectory).smallest_feasible_scale == pytest.approx(
        (INERTIA * 6.0 / 1.2) ** 0.5, rel=1e-9
    )
    # with gravity holding the arm level takes 9.81 N m
    heavy = TrajectoryTask([[0.0], [1.0]], Limits(velocity=np.inf, torque=9.0), robot=pendulum(tmp_path))
    assert audit(heavy, trajectory).smallest_feasible_scale is None


def test_a_motion_that_gravity_carries_may_only_be_slowed_so_far(tmp_path: Path) -> None:
    # from level, where holding takes 9.81 N m, with 9.5 N m: it has to fall fast enough from the first instant on
    robot = pendulum(tmp_path)
    trajectory = clamped_cubic(np.array([[0.0], [-1.2]]), np.array([0.9]))
    limits = Limits(velocity=np.inf, torque=[[-100.0], [9.5]])
    task = TrajectoryTask([[0.0], [-1.2]], limits, robot=robot)
    verdict = audit(task, trajectory)
    scale = verdict.smallest_feasible_scale
    assert scale is not None
    assert audit(task, trajectory.scaled(scale)).feasible
    assert not audit(task, trajectory.scaled(scale * (1 - 1e-5))).feasible
    assert not audit(task, trajectory.scaled(50.0)).feasible


def test_bounds_on_durations_hold_for_the_scale_too() -> None:
    trajectory = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    waypoints, limits = [[0.0], [1.0]], Limits(velocity=1.0)

    def scale(**bounds: object) -> float | None:
        task = TrajectoryTask(waypoints, limits, objective=Objective(**bounds))  # type: ignore[arg-type]
        return audit(task, trajectory).smallest_feasible_scale

    assert scale() == pytest.approx(1.5)
    assert scale(duration=(2.0, 3.0)) == pytest.approx(2.0)
    assert scale(duration=(0.5, 1.4)) is None
    assert scale(gap_durations=[[1.8, 5.0]]) == pytest.approx(1.8)
    assert scale(gap_durations=[[0.1, 1.2]]) is None


def test_ends_that_move_cannot_be_scaled() -> None:
    trajectory = Trajectory([0.0, 1.0], [[[0.0, 1.0]]], [0.0, 1.0])
    boundary = Boundary(velocity=1.0)
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=2.0), boundary=boundary)
    assert audit(task, trajectory).feasible
    assert audit(task, trajectory).smallest_feasible_scale == 1.0
    tight = TrajectoryTask([[0.0], [1.0]], Limits(velocity=0.5), boundary=boundary)
    assert audit(tight, trajectory).smallest_feasible_scale is None


def test_a_missed_waypoint_cannot_be_scaled_away() -> None:
    trajectory = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    assert (
        audit(TrajectoryTask([[0.0], [1.1]], Limits(velocity=9.0)), trajectory).smallest_feasible_scale
        is None
    )


def test_a_motion_without_limits_or_travel_has_no_smallest_duration() -> None:
    still = clamped_cubic(np.array([[0.0], [0.0]]), np.array([1.0]))
    assert audit(TrajectoryTask([[0.0], [0.0]], Limits(velocity=1.0)), still).smallest_feasible_scale == 0.0


def test_a_users_constraint_sets_the_scale() -> None:
    trajectory = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    symbols = [ca.SX.sym(name) for name in ("q", "v", "a", "tau")]
    speed = ca.Function("speed", symbols, [symbols[1] ** 2])
    constraint = CustomConstraint("speed", speed, upper=0.25)
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=9.0), constraints=(constraint,))
    verdict = audit(task, trajectory)
    assert verdict.limits["constraint:speed"].ratio == pytest.approx(1 + (2.25 - 0.25) / 0.25)
    assert verdict.smallest_feasible_scale == pytest.approx(3.0, rel=1e-8)
    never = CustomConstraint("reach", ca.Function("reach", symbols, [symbols[0]]), upper=0.5)
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=9.0), constraints=(never,))
    assert audit(task, trajectory).smallest_feasible_scale is None


def brutelargest_allowed(polynomials: np.ndarray, fastest: float) -> float:
    """Return the largest x of a fine grid at which no polynomial is above 0."""
    x = np.linspace(0.0, fastest, 20_001)
    above = np.zeros(x.size, dtype=bool)
    for row in polynomials:
        above |= np.polynomial.polynomial.polyval(x, row) > 0
    allowed = x[~above]
    return float(allowed.max()) if allowed.size else 0.0


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("rows", [3, 130])
def test_the_largest_allowed_speed_is_that_of_a_fine_grid(seed: int, rows: int) -> None:
    rng = np.random.default_rng(seed)
    polynomials = rng.normal(size=(rows, 3))
    polynomials[:, 0] = -rng.uniform(0.0, 3.0, rows)
    cubics = np.column_stack([-rng.uniform(0.1, 3.0, rows), rng.normal(size=(rows, 3))])
    fastest = float(rng.uniform(0.5, 4.0))
    found = scale.largest_allowed([polynomials, cubics], fastest, 0.0)
    both = np.concatenate([np.pad(polynomials, ((0, 0), (0, 1))), cubics])
    expected = brutelargest_allowed(both, fastest)
    assert (found or 0.0) == pytest.approx(expected, abs=2e-4 * fastest)
    if found is not None:
        assert scale.largest_allowed([both], fastest, found * 1.001) is None
        assert scale.largest_allowed([both], fastest, found) == pytest.approx(found, rel=1e-12)


def wave(frequency: float, upper: float) -> CustomConstraint:
    symbols = [ca.SX.sym(name) for name in ("q", "v", "a", "tau")]
    return CustomConstraint("wave", ca.Function("wave", symbols, [ca.sin(frequency * symbols[1])]), upper=upper)


def test_a_limit_that_varies_fast_is_passed_over_where_it_is_not_resolved() -> None:
    """Without limits on speed the search began at a motion a million times as fast, and did not return."""
    trajectory = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    task = TrajectoryTask([[0.0], [1.0]], constraints=(wave(300.0, 0.5),))
    verdict = audit(task, trajectory)
    assert not verdict.feasible
    found = verdict.smallest_feasible_scale
    # sin(300 v) first reaches 1/2 at pi / 1800 rad/s
    assert found == pytest.approx(1.5 * 1800.0 / np.pi, rel=1e-6)


def test_a_feasible_motion_is_never_told_to_slow_down(monkeypatch: pytest.MonkeyPatch) -> None:
    trajectory = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=2.0), constraints=(wave(30.0, 1.5),))
    monkeypatch.setattr(scale, "_SEGMENTS_ASKED", 0)
    verdict = audit(task, trajectory)
    assert verdict.feasible
    assert verdict.smallest_feasible_scale is not None
    assert verdict.smallest_feasible_scale <= 1.0
