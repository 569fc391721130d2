"""Torque limits and friction along fixed paths."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.references import convex_reference, toppra_reference
from ocp_traj.references.timing.path_limits import path_rows
from ocp_traj.references.timing.paths import geometric_path, sample_path
from ocp_traj.robot import Friction, Robot, load_robot
from ocp_traj.task import Limits, TrajectoryTask


def random_path_task(robot: Robot, rng: np.random.Generator, share: float = 0.7) -> TrajectoryTask:
    """A random path of five waypoints; gravity alone takes at most 60 % of the torque limits along it."""
    lower, upper = np.clip(robot.position_limits, -2.0, 2.0)
    points = lower + (upper - lower) * rng.random((5, robot.n))
    free = TrajectoryTask(points, Limits(acceleration=15.0, torque=np.inf), robot=robot)
    q = sample_path(geometric_path(free, "chord"), 400).q
    gravity = np.abs(robot.torque(q, 0 * q, 0 * q)).max(axis=0)
    torque = np.maximum(share * robot.torque_limits[1], gravity / 0.6)
    return TrajectoryTask(points, Limits(acceleration=15.0, torque=torque), robot=robot)


@pytest.fixture(scope="module")
def ur5() -> Robot:
    return load_robot("ur5")


@pytest.mark.parametrize("friction", [None, Friction(np.full(6, 3.0), np.full(6, 2.0))])
def test_torque_rows_agree_with_inverse_dynamics(ur5: Robot, friction: Friction | None) -> None:
    robot = ur5.with_changes(friction=friction)
    task = random_path_task(robot, np.random.default_rng(0))
    grid = sample_path(geometric_path(task, "chord"), 60)
    rows = path_rows(task, grid)
    rng = np.random.default_rng(1)
    u, x = rng.normal(size=len(grid.gaps)), rng.uniform(0.1, 1.0, len(grid.s))
    values = rows.values(u, x)[:, 0, 6:]
    v = grid.tangent[:, 0] * np.sqrt(x[:-1, None])
    a = grid.tangent[:, 0] * u[:, None] + grid.curvature[:, 0] * x[:-1, None]
    expected = robot.torque(grid.q[:-1], v, a)
    turning = (np.abs(v) < 1e-9) | (np.sign(v) != np.sign(grid.middle_tangent))
    difference = np.where(turning, 0.0, values - expected)
    assert np.abs(difference).max() < 1e-9 * np.abs(expected).max()


def check_agreement(name: str, count: int, seed: int) -> None:
    robot = load_robot(name)
    rng = np.random.default_rng(seed)
    for _ in range(count):
        task = random_path_task(robot, rng)
        first = toppra_reference(task, "chord", points=300)
        second = convex_reference(task, "chord", points=300)
        assert first.duration is not None, first.reason
        assert second.duration == pytest.approx(first.duration, rel=1e-3)
        assert first.largest_ratio <= 1 + 1e-4 and second.largest_ratio <= 1 + 1e-4


def test_toppra_and_convex_agree_with_torque_limits() -> None:
    check_agreement("ur5", 2, 10)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seed"), [("ur5", 11), ("panda", 12)])
def test_toppra_and_convex_agree_on_fifty_random_paths(name: str, seed: int) -> None:
    check_agreement(name, 50, seed)


def test_with_friction_the_true_torque_stays_within_its_limit(ur5: Robot) -> None:
    smooth = random_path_task(ur5, np.random.default_rng(3))
    smooth = smooth.changed(limits=Limits(acceleration=100.0, torque=smooth.limits.get("torque")))
    torque = smooth.limits.get("torque")[0, 1]
    robot = ur5.with_changes(friction=Friction(0.08 * torque, 0.05 * torque))
    task = TrajectoryTask(smooth.waypoints, Limits(acceleration=100.0, torque=torque), robot=robot)
    timed = toppra_reference(task, "chord", points=300)
    # friction helps braking, so the motion can even be faster; what counts is the torque itself
    assert timed.duration != pytest.approx(toppra_reference(smooth, "chord", points=300).duration, rel=1e-3)
    tangent = timed.v[1:-1] / timed.speed[1:-1, None]
    grid = sample_path(geometric_path(task, "chord"), 300)
    assert np.allclose(tangent, grid.tangent[1:, 0])
    a = tangent * timed.acceleration[1:, None] + grid.curvature[1:, 0] * timed.speed[1:-1, None] ** 2
    share = np.abs(robot.torque(timed.q[1:-1], timed.v[1:-1], a)) / torque
    assert 0.99 < share.max() <= 1 + 1e-3
    convex = convex_reference(task, "chord", points=300)
    assert convex.duration == pytest.approx(timed.duration, rel=2e-3)


def test_thermal_weight_trades_time_for_torque(ur5: Robot) -> None:
    task = random_path_task(ur5, np.random.default_rng(4))
    fast = convex_reference(task, "chord", points=150)
    cool = convex_reference(task, "chord", points=150, thermal_weight=5.0)
    assert cool.duration > fast.duration
    heat = []
    for result in (fast, cool):
        a = np.diff(result.v, axis=0) / np.diff(result.times)[:, None]
        middle = 0.5 * (result.q[1:] + result.q[:-1])
        share = ur5.torque(middle, 0.5 * (result.v[1:] + result.v[:-1]), a) / task.limits.get("torque")[0, 1]
        heat.append(float((share**2).sum(axis=1) @ np.diff(result.times)))
    assert heat[1] < heat[0]
    assert cool.objective == pytest.approx(cool.duration + 5.0 * heat[1], rel=0.02)


def test_a_load_that_gravity_alone_exceeds_is_a_reason(ur5: Robot) -> None:
    points = np.array([[0.0, 0, 0, 0, 0, 0], [0.5, 0, 0, 0, 0, 0]])  # arm stretched out
    task = TrajectoryTask(points, Limits(torque=[150.0, 10.0, 150, 28, 28, 28]), robot=ur5)
    result = toppra_reference(task, "chord")
    assert result.duration is None
    assert result.reason.startswith("torque, joint 2: standing still already needs")


def test_cartesian_speed_of_a_frame_is_kept(ur5: Robot) -> None:
    points = np.array([[0.0, -1.0, 1.0, 0, 0, 0], [1.5, -1.0, 1.0, 0, 0, 0]])
    limits = Limits(acceleration=50.0, cartesian_speed=(("tool0", 0.25),))
    result = toppra_reference(TrajectoryTask(points, limits, robot=ur5), "chord")
    mapped = ur5.symbolic.velocity("tool0").map(len(result.q))
    speed = np.linalg.norm(np.asarray(mapped(result.q.T, result.v.T)), axis=0)
    assert speed.max() == pytest.approx(0.25, rel=1e-6)
    assert "speed of frame tool0" in result.active
