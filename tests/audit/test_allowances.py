"""What rounding may add up to: allowances are absolute and granted once for a whole motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from helpers.audit_motions import clamped_cubic
from ocp_traj.audit import Verdict, audit
from ocp_traj.audit.kinematics import changes_of
from ocp_traj.audit.motion import Motion
from ocp_traj.case import load_case
from ocp_traj.task import Boundary, Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.trajectory_files import read_json

FAULTS = Path(__file__).parents[1] / "data" / "faults"


def test_a_turn_within_a_hundredth_of_a_picosecond_is_seen() -> None:
    verdict = audit(load_case(FAULTS / "jump.toml"), read_json(FAULTS / "turn.spline.json"))
    assert verdict.findings == (
        "acceleration: joint 1, gap 1, at 2 s: inf against 1 rad/s^2 (m/s^2), the velocity of joint 1 jumps by 0.5",
    )


@pytest.mark.parametrize("seconds", [1e-15, 1e-14, 1e-12, 1e-9, 1e-6])
def test_a_turn_by_a_ramp_is_seen_however_short_it_is(seconds: float) -> None:
    """The velocity is continuous: it falls from 0.5 to -0.5 inside a piece."""
    times = np.array([0.0, 1.0, 2.0, 2.0 + seconds, 3.0 + seconds, 4.0 + seconds])
    h = times[3] - times[2]
    pieces = [[0.0, 0.0, 0.25], [0.25, 0.5, 0.0], [0.75, 0.5, -0.5 / h], [0.75, -0.5, 0.0], [0.25, -0.5, 0.25]]
    motion = Trajectory(times, np.array(pieces)[:, None, :], times[[0, -1]])
    verdict = audit(load_case(FAULTS / "jump.toml"), motion)
    assert not verdict.feasible
    assert verdict.limits["acceleration"].ratio == pytest.approx(1.0 / h, rel=1e-3)
    assert verdict.limits["acceleration"].time == pytest.approx(2.0)


def test_a_start_that_moves_is_seen_behind_a_piece_of_a_femtosecond() -> None:
    task = TrajectoryTask([[0.0], [0.25]], Limits(velocity=1.0, acceleration=10.0))
    verdict = audit(task, read_json(FAULTS / "moving-start.spline.json"))
    assert verdict.findings == ("boundary velocity at the start: joint 1 has 0.001, expected 0",)
    assert verdict.boundary_error == pytest.approx(1e-3)


COUNTS = [10**4, 10**5, pytest.param(10**6, marks=pytest.mark.slow)]


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("step", [5e-7, 2e-12])
def test_many_small_steps_of_the_velocity_are_one_large_one(count: int, step: float) -> None:
    if step * count <= 1e-8:
        count = 10**4 + int(1e-8 / step)
    speeds = step * np.arange(1, count + 1)
    times = np.linspace(0.0, 0.5e-3, count + 1)
    places = np.concatenate([[0.0], np.cumsum(speeds * np.diff(times))])
    motion = Trajectory(times, np.stack([places[:-1], speeds], axis=1)[:, None, :], times[[0, -1]])
    boundary = Boundary(velocity=[[speeds[0]], [speeds[-1]]], acceleration=None)
    task = TrajectoryTask(places[[0, -1], None], Limits(velocity=1.0, acceleration=1.0), boundary=boundary)
    verdict = audit(task, motion)
    assert [finding.split(":")[0] for finding in verdict.findings] == ["acceleration"]
    assert ("all jumps together" in verdict.findings[0]) is (step < 1e-8)
    assert verdict.smallest_feasible_scale is None


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("step", [0.9e-8, 1.1e-13])
def test_many_small_steps_of_the_position_are_one_large_one(count: int, step: float) -> None:
    places = step * np.arange(max(count, int(1.2e-9 / step)))
    times = np.linspace(0.0, 1.0, places.size + 1)
    motion = Trajectory(times, places[:, None, None], times[[0, -1]])
    verdict = audit(TrajectoryTask(places[[0, -1], None], Limits(velocity=1.0)), motion)
    assert [finding.split(":")[0] for finding in verdict.findings] == ["velocity"]


def steps(order: int, sizes: list[float], *, joints: int = 1) -> Trajectory:
    """Return ten seconds of rest with jumps of one derivative, the first joint's only, to and fro."""
    count = len(sizes) + 1
    coefficients = np.zeros((count, joints, 3))
    times = np.arange(count + 1.0)
    state = np.zeros(3)
    for piece in range(count):
        coefficients[piece, 0] = state
        state = np.array([state.sum(), state[1] + 2 * state[2], state[2]])
        if piece < len(sizes):
            state[order] += sizes[piece] * (-1) ** piece / [1, 1, 2][order]
    return Trajectory(times, coefficients, times[[0, -1]])


@pytest.mark.parametrize(("total", "feasible"), [(0.98, True), (1.02, False)])
@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("count", [1, 2, 9])
def test_all_jumps_of_a_joint_share_one_allowance(
    order: int, count: int, total: float, feasible: bool
) -> None:
    allowed = [1e-9, 1e-8 * 3.0, 1e-6 * 5.0][order]
    motion = steps(order, [total * allowed / count] * count)
    limits = Limits(velocity=3.0, acceleration=5.0, jerk=7.0)
    ends = motion(motion.breakpoints[[0, -1]], 1)
    task = TrajectoryTask(
        motion(motion.waypoint_times), limits, boundary=Boundary(velocity=ends, acceleration=None)
    )
    assert audit(task, motion).feasible is feasible


def test_every_joint_has_its_own_allowance() -> None:
    one = steps(0, [0.8e-9], joints=2)
    both = replace(one, coefficients=one.coefficients + one.coefficients[:, ::-1])
    task = TrajectoryTask(np.zeros((2, 2)), Limits(velocity=3.0), tolerance=1e-8)
    assert audit(task, both).feasible


def ramps(sizes: list[float], seconds: float) -> tuple[TrajectoryTask, Trajectory]:
    """Return a motion at a constant speed with short pieces where the acceleration has these sizes, to and fro."""
    times, pieces, speed, place = [0.0], [], 0.5, 0.0
    for index, size in enumerate([0.0, *(value for each in sizes for value in (each, 0.0))]):
        h = 1.0 if index % 2 == 0 else seconds
        acceleration = size * (-1) ** (index // 2)
        times.append(times[-1] + h)
        h = times[-1] - times[-2]
        pieces.append([place, speed, acceleration / 2])
        place, speed = place + speed * h + acceleration * h**2 / 2, speed + acceleration * h
    motion = Trajectory(np.array(times), np.array(pieces)[:, None, :], np.array(times)[[0, -1]])
    boundary = Boundary(velocity=motion(motion.breakpoints[[0, -1]], 1), acceleration=None)
    limits = Limits(velocity=1.0, acceleration=1.0)
    return TrajectoryTask(motion(motion.waypoint_times), limits, boundary=boundary), motion


@pytest.mark.parametrize(
    ("sizes", "feasible"),
    [([9.0], True), ([12.0], False), ([5.0, 5.0], True), ([6.5, 6.5], False), ([2.1] * 10, False)],
)
def test_noise_of_a_short_piece_counts_by_what_it_changes(sizes: list[float], feasible: bool) -> None:
    """Above a limit of 1 rad/s^2 for a nanosecond each: 1e-9 rad/s for every rad/s^2 of excess."""
    task, motion = ramps(sizes, 1e-9)
    verdict = audit(task, motion)
    assert verdict.feasible is feasible
    assert verdict.limits["acceleration"].ratio == pytest.approx(1.0 if feasible else max(sizes))
    changes = changes_of(task, Motion.of(motion))
    assert changes.totals[1, 0] == pytest.approx(1e-9 * sum(size - 1 for size in sizes), rel=1e-3)


def test_what_rounding_cannot_make_is_no_noise() -> None:
    """0.1 per cent above the limit for 10 us: 1e-8 rad/s, but no rounding of positions makes it."""
    task, motion = ramps([1.0005], 1e-5)
    verdict = audit(task, motion)
    assert not verdict.feasible
    assert verdict.limits["acceleration"].ratio == pytest.approx(1.0005)


def test_noise_and_jumps_share_one_allowance() -> None:
    task, motion = ramps([7.0], 1e-9)  # 6e-9 of the limit
    assert audit(task, motion).feasible
    for jump, feasible in ((3e-9, True), (5e-9, False)):
        coefficients = motion.coefficients.copy()
        coefficients[-1, 0, 1] += jump
        assert audit(task, replace(motion, coefficients=coefficients)).feasible is feasible


def rest_between(speed: float) -> Trajectory:
    """Return 0 to 1, half a second of rest with this speed left over, 1 to 2."""
    times = np.array([0.0, 1.5, 2.0, 3.5])
    swing = [0.0, 0.0, 3.0 / 1.5**2, -2.0 / 1.5**3]
    pieces = np.array([swing, [1.0, speed, 0.0, 0.0], swing])[:, None, :]
    pieces[2, 0, 0] = 1.0
    return Trajectory(times, pieces, times)


@pytest.mark.parametrize(
    ("speed", "feasible"), [(0.0, True), (2.4e-12, True), (9e-10, True), (1.1e-9, False), (1e-3, False)]
)
def test_a_joint_at_rest_keeps_a_limit_of_zero_within_what_it_may_jump(speed: float, feasible: bool) -> None:
    """It moves by half a second of the speed, and back by a jump."""
    task = load_case(FAULTS / "dup-middle-dwell-still.toml")
    verdict = audit(task, rest_between(speed))
    assert verdict.feasible is feasible, verdict.findings
    assert np.isfinite(verdict.limits["velocity"].ratio) == feasible


def test_one_side_of_zero_forgives_nothing_on_the_other() -> None:
    motion = clamped_cubic(np.array([[0.0], [1e-10]]), np.array([1.0]))  # 1.5e-10 rad/s, 1e-10 rad in all
    limits = Limits(velocity=[[0.0], [1e-10]])
    assert not audit(TrajectoryTask([[0.0], [1e-10]], limits), motion).feasible
    back = Trajectory(motion.breakpoints, -motion.coefficients, motion.waypoint_times)
    assert audit(TrajectoryTask([[0.0], [-1e-10]], limits), back).feasible


def test_a_position_may_leave_a_range_without_width_by_what_it_may_jump() -> None:
    for place, feasible in ((-9e-17, True), (0.9e-9, True), (1.1e-9, False)):
        still = Trajectory([0.0, 1.0], [[[place, 0.0]]], [0.0, 1.0])
        task = TrajectoryTask([[0.0], [0.0]], Limits(position=[[0.0], [0.0]], velocity=1.0))
        verdict = audit(task, still)
        assert verdict.feasible is feasible
        assert np.isfinite(verdict.limits["position"].ratio) == feasible
    # a range of 1 m has its own tolerance, a millionth of it, and shows an excess
    wide = TrajectoryTask([[0.0], [0.0]], Limits(position=[[0.0], [1.0]], velocity=1.0))
    below = Trajectory([0.0, 1.0], [[[-0.5e-9, 0.0]]], [0.0, 1.0])
    assert audit(wide, below).limits["position"].ratio == 1 + 0.5e-9


def test_a_slow_joint_feels_coulomb_friction_unless_it_goes_nowhere(tmp_path: Path) -> None:
    from helpers.audit_motions import pendulum

    robot = pendulum(tmp_path, gravity=0.0, coulomb=2.0)
    for speed, torque in ((1.1e-9, 2.0), (0.9e-9, 0.0)):
        creep = Trajectory([0.0, 1.0], [[[0.0, speed]]], [0.0, 1.0])
        boundary = Boundary(velocity=speed, acceleration=None)
        limits = Limits(velocity=1.0, torque=5.0)
        task = TrajectoryTask([[0.0], [speed]], limits, robot=robot, boundary=boundary)
        assert audit(task, creep).limits["torque"].value == pytest.approx(torque, abs=1e-9)


def test_slack_is_not_used_beyond_what_jumps_allow() -> None:
    """Twice as fast, a jump of 0.8e-8 of the limit would be 1.6e-8."""
    motion = steps(1, [0.8e-8])
    task = TrajectoryTask(motion([0.0, 2.0]), Limits(velocity=1.0, acceleration=1.0))
    verdict = audit(task, motion)
    assert verdict.feasible
    assert verdict.smallest_feasible_scale == pytest.approx(0.8)
    assert verdict.smallest_feasible_scale is not None
    assert audit(task, motion.scaled(0.81)).feasible
    assert not audit(task, motion.scaled(0.79)).feasible


def jerk_notes(verdict: Verdict) -> list[str]:
    return [note for note in verdict.notes if "jerk" in note]


def test_a_jerk_that_ends_leave_unlimited_is_noted() -> None:
    cubic = clamped_cubic(np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([1.0]))
    waypoints = cubic(cubic.waypoint_times)
    verdict = audit(TrajectoryTask(waypoints, Limits(jerk=[20.0, 20.0]), boundary=Boundary(acceleration=None)), cubic)
    assert verdict.feasible
    assert jerk_notes(verdict) == [
        "the motion starts with an acceleration other than 0 (joint 1): the jerk at that instant is not limited",
        "the motion ends with an acceleration other than 0 (joint 1): the jerk at that instant is not limited",
    ]
    assert verdict.to_json()["notes"] == list(verdict.notes)
    assert "note: the motion starts with an acceleration" in str(verdict)
    assert jerk_notes(audit(TrajectoryTask(waypoints, Limits(velocity=2.0)), cubic)) == []
    other = TrajectoryTask(waypoints, Limits(jerk=[np.inf, 20.0]), boundary=Boundary(acceleration=None))
    assert jerk_notes(audit(other, cubic)) == []
    still = clamped_cubic(np.zeros((2, 2)), np.array([1.0]))
    assert audit(TrajectoryTask(np.zeros((2, 2)), Limits(jerk=20.0)), still).notes == ()
