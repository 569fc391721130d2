"""What must hold for every serial chain of 1 to 8 joints with torque limits, whatever its links and joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from helpers.random_tasks import random_motion, random_robot, reversed_motion, torque_limits
from ocp_traj.audit import audit
from ocp_traj.robot import Robot
from ocp_traj.solving import solve
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory

SEEDS = st.integers(0, 10**6)


def examples(count: int) -> settings:
    return settings(
        max_examples=count,
        deadline=None,
        derandomize=True,
        suppress_health_check=[HealthCheck.too_slow],
        database=None,
    )


def task_of(robot: Robot, motion: Trajectory, **limits: object) -> TrajectoryTask:
    """The task whose waypoints the motion passes."""
    waypoints = motion(motion.waypoint_times)
    return TrajectoryTask(waypoints, Limits(**limits), robot=robot, family="quintic")  # type: ignore[arg-type]


def states(motion: Trajectory, count: int = 4001) -> tuple[np.ndarray, ...]:
    t = np.linspace(0.0, motion.duration, count)
    return tuple(motion(t, order) for order in range(3))


def check_time_scaling(seed: int, factor: float) -> None:
    """Torques above gravity fall with the square of the slowing; the audit sees the same with its own means."""
    robot = random_robot(seed)
    motion = random_motion(seed, robot.n)
    q, v, a = states(motion, 201)
    gravity = robot.torque(q, 0 * v, 0 * a)
    above = robot.torque(q, v, a) - gravity
    slowed = robot.torque(*states(motion.scaled(factor), 201))
    size = np.abs(gravity).max() + np.abs(above).max() * max(1.0, factor**-2)
    np.testing.assert_allclose(slowed, gravity + above / factor**2, atol=1e-11 * size)
    symbolic = np.array(robot.symbolic.inverse_dynamics(q.T, v.T / factor, a.T / factor**2)).T
    np.testing.assert_allclose(symbolic, slowed, atol=1e-10 * size)
    limits = torque_limits(robot, motion, 0.3)
    verdict = audit(task_of(robot, motion, torque=limits), motion.scaled(factor))
    dense = gravity + above / factor**2
    found = {peak.joint: peak.ratio for peak in verdict.peaks if peak.limit == "torque"}
    for joint in range(robot.n):
        assert found[joint] >= np.abs(dense[:, joint]).max() / limits[joint] - 1e-8


def check_reversed_time(seed: int, torque_share: float) -> None:
    """Backwards every torque is the same, so the verdict is."""
    robot = random_robot(seed)
    motion = random_motion(seed, robot.n)
    back = reversed_motion(motion)
    limits = {"torque": torque_limits(robot, motion, torque_share), "velocity": 3.0, "acceleration": 20.0}
    forward = audit(task_of(robot, motion, **limits), motion)
    backward = audit(task_of(robot, back, **limits), back)
    assert backward.feasible is forward.feasible
    assert backward.duration == pytest.approx(forward.duration, rel=1e-12)
    for name, peak in forward.limits.items():
        assert backward.limits[name].ratio == pytest.approx(peak.ratio, rel=1e-8)
    assert forward.smallest_feasible_scale is not None
    assert backward.smallest_feasible_scale == pytest.approx(forward.smallest_feasible_scale, rel=1e-7)


def check_mirrored_joints(seed: int) -> None:
    """Joints that count the other way round, with their limits, change nothing but the signs."""
    rng = np.random.default_rng(seed)
    signs = rng.choice([-1.0, 1.0], 8)
    robot, mirrored = random_robot(seed), random_robot(seed, signs=signs)
    signs = signs[: robot.n]
    motion = random_motion(seed, robot.n)
    other = replace(motion, coefficients=motion.coefficients * signs[:, None])
    symmetric = torque_limits(robot, motion, 0.5)
    torque = np.stack(
        [-symmetric * rng.uniform(1.0, 2.0, robot.n), symmetric * rng.uniform(1.0, 2.0, robot.n)]
    )
    velocity = np.stack([-rng.uniform(1.0, 3.0, robot.n), rng.uniform(1.0, 3.0, robot.n)])

    def turned(limit: np.ndarray) -> np.ndarray:
        return np.where(signs > 0, limit, -limit[::-1])

    one = audit(task_of(robot, motion, torque=torque, velocity=velocity), motion)
    two = audit(task_of(mirrored, other, torque=turned(torque), velocity=turned(velocity)), other)
    assert two.feasible is one.feasible
    for name, peak in one.limits.items():
        assert two.limits[name].ratio == pytest.approx(peak.ratio, rel=1e-8)
        assert abs(two.limits[name].value) == pytest.approx(abs(peak.value), rel=1e-8)
    assert one.smallest_feasible_scale is not None
    assert two.smallest_feasible_scale == pytest.approx(one.smallest_feasible_scale, rel=1e-7)


def dense_smallest_scale(robot: Robot, motion: Trajectory, torque: np.ndarray, velocity: float) -> float:
    """The smallest slowing by sampling alone: 4001 times, both sides of every turn of a joint (where its dry
    friction jumps), a grid of slownesses, then bisection."""
    t = np.linspace(0.0, motion.duration, 4001)
    rows, joints = np.nonzero(np.diff(np.sign(motion(t, 1)), axis=0))
    turns = [
        brentq(lambda time, j=joint: motion(time, 1)[j], t[row], t[row + 1], xtol=1e-15)
        for row, joint in zip(rows, joints, strict=True)
    ]
    sides = np.add.outer([-1e-10, 1e-10], turns).ravel()
    t = np.concatenate([t, np.clip(sides, 0.0, motion.duration)])
    q, v, a = (motion(t, order) for order in range(3))
    friction = robot.friction
    gravity = robot.torque(q, 0 * v, 0 * a)
    viscous = friction.viscous * v
    coulomb = friction.coulomb * np.sign(v)
    inertial = robot.torque(q, v, a) - gravity - viscous - coulomb

    def kept(scale: float) -> bool:
        tau = gravity + coulomb + viscous / scale + inertial / scale**2
        return bool((np.abs(tau) <= torque).all() and (np.abs(v) <= velocity * scale).all())

    low, high = 0.0, 0.0
    for high in np.geomspace(1e-2, 1e2, 400):
        if kept(high):
            break
        low = float(high)
    assert low > 0.0
    assert kept(high)
    while high - low > 1e-9 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if kept(middle) else (middle, high)
    return float(high)


def check_smallest_scale(seed: int, share: float, friction: float) -> None:
    """The audit's smallest slowing is what sampling finds, and never less, since sampling misses peaks."""
    robot = random_robot(seed, friction=friction)
    motion = random_motion(seed, robot.n)
    torque = torque_limits(robot, motion, share)
    verdict = audit(task_of(robot, motion, torque=torque, velocity=20.0), motion)
    scale = verdict.smallest_feasible_scale
    dense = dense_smallest_scale(robot, motion, torque, 20.0)
    assert scale is not None
    assert dense * (1 - 1e-8) <= scale <= dense * (1 + 1e-4)
    assert audit(task_of(robot, motion, torque=torque, velocity=20.0), motion.scaled(scale)).feasible


def check_too_weak_to_stand(seed: int) -> None:
    """A joint that cannot hold the arm at the start, where it rests, cannot be helped by slowing."""
    robot = random_robot(seed)
    motion = random_motion(seed, robot.n)
    q, v, a = states(motion, 2)
    holding = np.abs(robot.torque(q, 0 * v, 0 * a))[0]
    torque = torque_limits(robot, motion, 1.0)
    weak = int(np.argmax(holding))
    torque[weak] = 0.99 * holding[weak]
    verdict = audit(task_of(robot, motion, torque=torque), motion)
    assert not verdict.feasible
    assert verdict.smallest_feasible_scale is None


def check_added_torque_limit(seed: int, share: float) -> None:
    """Without its torque limits a motion never takes longer, started from the motion with them."""
    robot = random_robot(seed)
    motion = random_motion(seed, robot.n)
    torque = 1.5 * torque_limits(robot, motion, share)
    waypoints = motion(motion.waypoint_times)
    limits = Limits(velocity=4.0, acceleration=40.0, torque=torque)
    with_torque = solve(TrajectoryTask(waypoints, limits, robot=robot, virtual_knots=1))
    assert with_torque.feasible, with_torque
    free = Limits(velocity=4.0, acceleration=40.0, torque=np.inf)
    without = solve(
        TrajectoryTask(waypoints, free, robot=robot, virtual_knots=1), warm_start=with_torque.trajectory
    )
    assert without.feasible, without
    assert without.duration is not None
    assert with_torque.duration is not None
    assert without.duration <= with_torque.duration * (1 + 1e-9)


@given(SEEDS, st.floats(0.1, 10.0))
@examples(20)
def test_torque_above_gravity_falls_with_the_square_of_the_slowing(seed, factor):
    check_time_scaling(seed, factor)


@given(SEEDS, st.floats(0.1, 1.0))
@examples(25)
def test_without_friction_a_motion_backwards_has_the_same_verdict(seed, share):
    check_reversed_time(seed, share)


@given(SEEDS)
@examples(25)
def test_joints_that_count_the_other_way_round_change_nothing(seed):
    check_mirrored_joints(seed)


@given(SEEDS, st.floats(0.05, 1.0), st.sampled_from([0.0, 1.0, 10.0]))
@examples(20)
def test_the_smallest_slowing_is_what_dense_sampling_finds(seed, share, friction):
    check_smallest_scale(seed, share, friction)


@given(SEEDS)
@examples(15)
def test_an_arm_too_weak_to_stand_is_not_helped_by_slowing(seed):
    check_too_weak_to_stand(seed)


@given(SEEDS, st.floats(0.2, 1.0))
@examples(1)
def test_an_added_torque_limit_never_shortens_the_motion(seed, share):
    check_added_torque_limit(seed, share)


def check_all_of_this(seed, share, factor, friction):
    check_time_scaling(seed, factor)
    check_reversed_time(seed, share)
    check_mirrored_joints(seed)
    check_smallest_scale(seed, share, friction)
    check_too_weak_to_stand(seed)


@pytest.mark.parametrize(
    "count", [pytest.param(100, marks=pytest.mark.slow), pytest.param(300, marks=pytest.mark.long)]
)
def test_all_of_this_holds_for_many_chains(count):
    drawn = given(SEEDS, st.floats(0.05, 1.0), st.floats(0.1, 10.0), st.sampled_from([0.0, 1.0, 10.0]))
    examples(count)(drawn(check_all_of_this))()


@pytest.mark.parametrize(
    "count", [pytest.param(20, marks=pytest.mark.slow), pytest.param(60, marks=pytest.mark.long)]
)
def test_added_torque_limits_never_shorten_many_motions(count):
    examples(count)(given(SEEDS, st.floats(0.2, 1.0))(check_added_torque_limit))()
