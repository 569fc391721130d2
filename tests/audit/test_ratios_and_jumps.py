"""Ratios to limits, and jumps between pieces: each test kills a change that survived mutation testing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from helpers.audit_motions import INERTIA, clamped_cubic, pendulum
from ocp_traj.audit import audit
from ocp_traj.audit.kinematics import (
    changes_of,
    jump_peaks,
    position_width,
    range_ratios,
    side_ratios,
)
from ocp_traj.audit.motion import Motion
from ocp_traj.audit.verdict import Extremum
from ocp_traj.robot import load_robot
from ocp_traj.task import Boundary, Limits, Objective, TrajectoryTask
from ocp_traj.trajectory import Trajectory


def test_what_is_no_number_breaks_even_an_infinite_limit() -> None:
    values = np.array([np.nan, 3.0, -3.0, np.inf])
    unlimited = np.full(4, np.inf)
    assert side_ratios(values, -unlimited, unlimited).tolist() == [np.inf, 0.0, 0.0, np.inf]


def test_noise_counts_as_nothing_against_a_limit_of_zero_and_only_there() -> None:
    nothing = np.zeros(4)
    assert side_ratios(np.array([0.5, -0.5, 0.0, 2.0]), nothing, nothing).tolist() == [
        np.inf,
        np.inf,
        0.0,
        np.inf,
    ]
    noisy = side_ratios(np.array([0.25, -0.25, 0.26, 0.25]), nothing, np.array([0.0, 0.0, 0.0, 1.0]), 0.25)
    assert noisy.tolist() == [0.0, 0.0, np.inf, 0.25]


def test_an_excess_of_noise_is_none_and_a_range_of_one_point_can_be_kept() -> None:
    values = np.array([5.25, 5.5, -5.25, 6.0])
    ratios = range_ratios(values, np.full(4, -5.0), np.full(4, 5.0), np.full(4, 10.0), 0.25)
    assert ratios.tolist() == [1.0, 1.05, 1.0, 1.1]
    point = np.full(3, 2.0)
    assert range_ratios(np.array([2.0, 3.0, 1.0]), point, point, np.zeros(3)).tolist() == [
        1.0,
        np.inf,
        np.inf,
    ]


def test_only_frames_and_constraints_carry_a_label_into_json() -> None:
    assert "label" not in Extremum("velocity", 0, 0.0, 0.5).to_json()
    assert Extremum("cartesian_speed", -1, 0.0, 0.5, label="tool0").to_json()["label"] == "tool0"


@pytest.mark.parametrize(
    ("duration", "kept"),
    [
        (2.0 * (1 - 1e-9), True),
        (2.0 * (1 - 3e-9), False),
        (3.0 * (1 + 1e-9), True),
        (3.0 * (1 + 3e-9), False),
    ],
)
def test_bounds_on_durations_include_their_tolerance(duration: float, kept: bool) -> None:
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=2.0), objective=Objective(duration=(2.0, 3.0)))
    motion = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0])).scaled(duration)
    assert audit(task, motion).feasible is kept


def test_torque_rates_fall_with_their_own_powers_of_the_slowing(tmp_path: Path) -> None:
    # q = 3 t^2 - 2 t^3 has the jerk -12; without gravity the rate is I jerk / s^3
    trajectory = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    limits = Limits(velocity=np.inf, torque=np.inf, torque_rate=2.0)
    task = TrajectoryTask([[0.0], [1.0]], limits, robot=pendulum(tmp_path, gravity=0.0))
    scale = audit(task, trajectory).smallest_feasible_scale
    assert scale == pytest.approx((INERTIA * 12.0 / 2.0) ** (1 / 3), rel=1e-9)


@pytest.mark.parametrize("limit", [3.0, 10.0, 40.0])
def test_torque_rates_with_gravity_and_friction_agree_with_dense_sampling(
    tmp_path: Path, limit: float
) -> None:
    trajectory = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    limits = Limits(velocity=np.inf, torque=np.inf, torque_rate=limit)
    task = TrajectoryTask([[0.0], [1.0]], limits, robot=pendulum(tmp_path, viscous=0.7))
    scale = audit(task, trajectory).smallest_feasible_scale
    assert scale is not None
    t = np.linspace(0.0, 1.0, 20001)
    q, v, a, j = (trajectory(t, order)[:, 0] for order in range(4))

    def kept(s: float) -> bool:
        rate = INERTIA * j / s**3 + 0.7 * a / s**2 - 9.81 * np.sin(q) * v / s
        return bool((np.abs(rate) <= limit).all())

    assert kept(scale * (1 + 1e-7))
    assert not any(kept(s) for s in np.linspace(0.01, scale * (1 - 1e-5), 300))


@pytest.mark.parametrize(("jump", "feasible"), [(1.9e-8, True), (2.1e-8, False)])
def test_a_velocity_may_jump_by_ten_billionths_of_its_limit(jump: float, feasible: bool) -> None:
    pieces = [[[0.0, 1.0]], [[1.0, 1.0 + jump]]]
    motion = Trajectory([0.0, 1.0, 2.0], pieces, [0.0, 1.0, 2.0])
    boundary = Boundary(velocity=[[1.0], [1.0 + jump]], acceleration=None)
    limits = Limits(velocity=2.0, acceleration=1.0)
    waypoints = [[0.0], [1.0], [2.0 + jump]]
    assert audit(TrajectoryTask(waypoints, limits, boundary=boundary), motion).feasible is feasible


@pytest.mark.parametrize(("jump", "feasible"), [(0.9e-9, True), (1.1e-9, False)])
def test_a_position_may_jump_by_a_nanoradian(jump: float, feasible: bool) -> None:
    pieces = [[[0.0, 1.0]], [[1.0 + jump, 1.0]]]
    motion = Trajectory([0.0, 1.0, 2.0], pieces, [0.0, 1.0, 2.0])
    boundary = Boundary(velocity=1.0, acceleration=None)
    limits = Limits(position=1000.0, velocity=2.0)
    task = TrajectoryTask([[0.0], [1.0], [2.0]], limits, boundary=boundary, tolerance=1e-7)
    assert audit(task, motion).feasible is feasible


@pytest.mark.parametrize(
    ("lower", "upper", "width"),
    [
        (-1.0, 3.0, 4.0),
        (-np.inf, 2.0, 2.5),  # the farthest waypoint is at -0.5
        (-3.0, np.inf, 4.0),  # the farthest waypoint is at 1
        (-np.inf, np.inf, 1.0),
    ],
)
def test_a_position_range_without_width_takes_its_end_to_the_farthest_waypoint(
    lower: float, upper: float, width: float
) -> None:
    limits = Limits(position=[[lower], [upper]])
    task = TrajectoryTask([[0.0], [1.0], [-0.5]], limits)
    assert position_width(task).tolist() == [[[width]], [[width]]]


def test_a_short_reach_is_a_width_as_well() -> None:
    task = TrajectoryTask([[0.0], [0.5]], Limits(position=[[-np.inf], [0.5]]))
    assert position_width(task).tolist() == [[[0.5]]]


@pytest.mark.parametrize("end", [[[-np.inf], [2.0]], [[2.0], [np.inf]]])
def test_a_range_that_ends_where_all_waypoints_are_has_a_width_of_one(end: list[list[float]]) -> None:
    task = TrajectoryTask([[2.0], [2.0]], Limits(position=end))
    assert position_width(task).tolist() == [[[1.0]]]


def test_every_gap_has_the_width_of_its_own_range() -> None:
    ranges = np.array([[[-1.0], [2.0]], [[-np.inf], [5.0]]])
    task = TrajectoryTask([[0.0], [1.0], [-0.5]], Limits(position=ranges))
    assert position_width(task).tolist() == [[[3.0]], [[5.5]]]


def test_inside_a_range_a_position_ratio_stays_between_nothing_and_one() -> None:
    values = np.array([1.0, 0.0, -5.0, 5.0 + 1e-12, np.nan])
    ratios = range_ratios(
        values, np.full(5, -5.0), np.full(5, 5.0), np.array([10.0, 10.0, 2.0, 10.0, 10.0]), 1e-11
    )
    assert ratios.tolist() == [pytest.approx(0.6), 0.5, 1.0, 1.0, np.inf]
    assert range_ratios(np.array([0.0]), -5.0, 5.0, np.array([2.0])).tolist() == [0.0]


@pytest.mark.parametrize(
    ("value", "centred", "bound"),
    [
        (1.9, True, 2.0),
        (-0.9, True, -1.0),
        (0.5, True, 2.0),
        (0.4, True, -1.0),
        (0.6, True, 2.0),
        (2.5, True, 2.0),
        (-1.5, True, -1.0),
        (0.4, False, 2.0),
        (0.0, False, 2.0),
        (-0.1, False, -1.0),
    ],
)
def test_the_bound_told_is_the_nearer_end_of_a_range_or_the_limit_of_the_values_side(
    value: float, centred: bool, bound: float
) -> None:
    name, shape = ("position", [value, 0.0]) if centred else ("velocity", [0.0, value])
    task = TrajectoryTask([[0.0], [0.0]], Limits(**{name: [[-1.0], [2.0]]}))
    assert audit(task, Trajectory([0.0, 1.0], [[shape]], [0.0, 1.0])).limits[name].bound == bound


@pytest.mark.parametrize(("jump", "feasible"), [(0.9e-8, True), (1.3e-8, False)])
@pytest.mark.parametrize("velocity", [[[-1.0], [4.0]], [[-4.0], [1.0]]])
def test_a_jump_is_held_against_the_smaller_of_two_limits(
    velocity: list[list[float]], jump: float, feasible: bool
) -> None:
    pieces = [[[0.0, 0.5]], [[0.5, 0.5 + jump]]]
    motion = Trajectory([0.0, 1.0, 2.0], pieces, [0.0, 1.0, 2.0])
    boundary = Boundary(velocity=[[0.5], [0.5 + jump]], acceleration=None)
    task = TrajectoryTask(
        [[0.0], [0.5], [1.0 + jump]], Limits(velocity=velocity, acceleration=1.0), boundary=boundary
    )
    assert audit(task, motion).feasible is feasible


@pytest.mark.parametrize(("jump", "feasible"), [(0.9e-8, True), (1.3e-8, False)])
def test_a_jump_is_held_against_the_stricter_of_the_two_gaps(jump: float, feasible: bool) -> None:
    pieces = [[[0.0, 0.5]], [[0.5, 0.5 + jump]]]
    motion = Trajectory([0.0, 1.0, 2.0], pieces, [0.0, 1.0, 2.0])
    boundary = Boundary(velocity=[[0.5], [0.5 + jump]], acceleration=None)
    for order in (1, -1):
        velocity = np.array([[[-1.0], [1.0]], [[-4.0], [4.0]]])[::order]
        task = TrajectoryTask(
            [[0.0], [0.5], [1.0 + jump]], Limits(velocity=velocity, acceleration=1.0), boundary=boundary
        )
        assert audit(task, motion).feasible is feasible


def straight(speeds: list[list[float]]) -> Trajectory:
    """Return a motion of one second a piece with the given speeds (pieces, n), continuous in position."""
    steps = np.array(speeds)
    starts = np.concatenate([np.zeros((1, steps.shape[1])), np.cumsum(steps, axis=0)[:-1]])
    times = np.arange(len(speeds) + 1.0)
    return Trajectory(times, np.stack([starts, steps], axis=2), times)


def jumps_of(motion: Trajectory, **limits: object) -> list[tuple[str, int, float]]:
    """Return limit, joint and time of what jumps make infinite."""
    task = TrajectoryTask(motion(motion.waypoint_times), Limits(**limits))  # type: ignore[arg-type]
    return [(peak.limit, peak.joint, peak.time) for peak in jumps(task, motion)]


def jumps(task: TrajectoryTask, trajectory: Trajectory) -> list[Extremum]:
    motion = Motion.of(trajectory)
    return jump_peaks(task, motion, changes_of(task, motion))


def test_a_jump_late_in_the_motion_is_held_against_the_gaps_beside_it() -> None:
    motion = straight([[0.5], [0.5], [0.5 + 1.3e-8]])
    strict, loose = [[-1.0], [1.0]], [[-4.0], [4.0]]
    assert jumps_of(motion, velocity=np.array([loose, strict, loose]), acceleration=1.0) == [
        ("acceleration", 0, 2.0)
    ]
    assert jumps_of(motion, velocity=np.array([strict, loose, loose]), acceleration=1.0) == []


def test_a_jump_against_a_limit_of_zero_or_none_is_held_against_the_fastest_joint() -> None:
    assert jumps_of(straight([[0.5], [0.5 + 0.4e-8]]), velocity=0.0, acceleration=1.0) == []
    assert jumps_of(straight([[1e3, 0.5], [1e3, 0.5 + 1e-6]]), acceleration=1.0) == []
    assert jumps_of(straight([[1e1, 0.5], [1e1, 0.5 + 1e-6]]), acceleration=1.0) == [("acceleration", 1, 1.0)]


@pytest.mark.parametrize("acceleration", [[[-np.inf], [1.0]], [[-1.0], [np.inf]]])
def test_a_limit_on_one_side_forbids_a_jump(acceleration: list[list[float]]) -> None:
    assert jumps_of(straight([[0.5], [0.7]]), acceleration=acceleration) == [("acceleration", 0, 1.0)]


def test_a_jump_where_only_another_gap_has_a_limit_is_allowed() -> None:
    motion = straight([[0.5], [0.7], [0.7], [0.7]])
    one = np.full((4, 2, 1), [[-np.inf], [np.inf]])
    one[3] = [[-1.0], [1.0]]
    assert jumps_of(motion, acceleration=one) == []
    assert jumps_of(motion, acceleration=one[::-1]) == [("acceleration", 0, 1.0)]
    late = straight([[0.5], [0.5], [0.7], [0.7]])
    assert jumps_of(late, acceleration=one[::-1]) == []
    assert jumps_of(late, acceleration=np.roll(one, -1, axis=0)) == [("acceleration", 0, 2.0)]


def test_a_jump_of_one_joint_leaves_the_others_limits_alone() -> None:
    motion = straight([[0.5, 0.5], [0.7, 0.5]])
    assert jumps_of(motion, acceleration=[np.inf, 1.0]) == []
    assert jumps_of(motion, acceleration=[1.0, np.inf]) == [("acceleration", 0, 1.0)]


def test_a_jump_of_one_joint_breaks_the_torque_limit_of_another() -> None:
    """Torques couple the joints; the joint that is told is the one with the limit, the reason the one that jumps."""
    speeds = np.zeros((4, 6))
    speeds[1:, 0] = 0.2
    motion = straight(speeds.tolist())
    torque = np.full(6, np.inf)
    torque[2] = 100.0
    task = TrajectoryTask(
        motion(motion.waypoint_times), Limits(velocity=np.inf, torque=torque), robot=load_robot("ur5")
    )
    (peak,) = jumps(task, motion)
    assert (peak.limit, peak.joint, peak.time, peak.bound) == ("torque", 2, 1.0, 100.0)
    assert peak.note == "the velocity of joint 1 jumps by 0.2"


def test_the_jump_told_is_one_that_is_not_allowed() -> None:
    motion = straight([[0.5], [0.5 + 3e-8], [0.5 + 5e-8]])
    loose, strict = [[-4.0], [4.0]], [[-1.0], [1.0]]
    found = jumps_of(motion, velocity=np.array([loose, loose, strict]), acceleration=1.0)
    assert found == [("acceleration", 0, 2.0)]
