"""What a controller gets keeps the limits, with strictly increasing times."""

from __future__ import annotations

import re

import numpy as np
import pytest
import yaml
from scipy.interpolate import CubicSpline

from ocp_traj.audit import audit
from ocp_traj.controller_files import (
    interpolated,
    sample_for_controller,
    sampling_times,
    to_ros2,
    to_urscript,
)
from ocp_traj.exceptions import InputError
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory


def bang_bang(duration: float = 1.0, n: int = 2) -> Trajectory:
    """From 0 to 1 with constant acceleration, then constant deceleration: 4 / T^2 all along, 2 / T at most."""
    half, a = duration / 2, 4 / duration**2
    piece = [[[0.0, 0.0, a / 2]] * n, [[0.5, a * half, -a / 2]] * n]
    return Trajectory(
        np.array([0.0, half, duration]), np.array(piece), np.array([0.0, duration]), "cubic", "x"
    )


def septic() -> Trajectory:
    """The minimum-snap motion from 0 to 1 in 1 s."""
    coefficients = np.array([[[0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0]]])
    return Trajectory(np.array([0.0, 1.0]), coefficients, np.array([0.0, 1.0]), "septic", "x")


def task(n: int, velocity: float, acceleration: float, family: str = "quintic") -> TrajectoryTask:
    limits = Limits(velocity=velocity, acceleration=acceleration)
    return TrajectoryTask(np.array([[0.0] * n, [1.0] * n]), limits, family=family, virtual_knots=7)


def test_every_breakpoint_is_a_sample_and_times_increase() -> None:
    motion = bang_bang(1.2345)
    times = sampling_times(motion, 100.0)
    assert np.isin(motion.breakpoints, times).all()
    assert (np.diff(times) > 1e-7).all()
    assert times[0] == 0.0 and times[-1] == motion.duration


def test_grid_times_beside_a_breakpoint_are_dropped() -> None:
    times = sampling_times(bang_bang(1.0 + 1e-9), 100.0)
    assert np.diff(times).min() > 1e-6


def test_between_samples_the_controller_follows_the_motion_itself() -> None:
    knots = np.array([0.0, 0.31, 0.8, 1.0])
    spline = CubicSpline(knots, np.random.default_rng(0).normal(size=(4, 2)), bc_type="clamped")
    motion = Trajectory(knots, spline.c[::-1].transpose(1, 2, 0), knots, "cubic")
    drawn = interpolated(sample_for_controller(motion, 20.0), motion)
    t = np.linspace(0, 1, 997)
    for derivative, tolerance in ((0, 1e-8), (1, 1e-6), (2, 1e-4)):
        np.testing.assert_allclose(drawn(t, derivative), motion(t, derivative), atol=tolerance)


def test_a_motion_on_its_limits_stays_on_them() -> None:
    smooth = septic()
    peak_v, peak_a = (
        np.abs(smooth(np.linspace(0, 1, 100001), 1)).max(),
        np.abs(smooth(np.linspace(0, 1, 100001), 2)).max(),
    )
    asked = task(1, peak_v, peak_a, "septic")
    samples = sample_for_controller(smooth, 10.0, asked)
    verdict = audit(asked, interpolated(samples, smooth.scaled(samples.scale)))
    assert not [extremum for extremum in verdict.limits.values() if extremum.broken]
    assert 1.0 <= samples.scale < 1.2


def test_a_motion_over_its_limits_is_slowed_into_them() -> None:
    motion = septic()
    asked = task(1, 1.0, 100.0, "septic")
    samples = sample_for_controller(motion, 100.0, asked)
    assert samples.scale == pytest.approx(
        35 / 16, rel=1e-5
    )  # the septic's velocity peaks at 35/16 in the middle


def test_the_ros_goal_is_yaml_with_increasing_times() -> None:
    samples = sample_for_controller(bang_bang(), 50.0)
    goal = yaml.safe_load(to_ros2(samples, ["a joint", "it's"]))
    assert list(goal) == ["trajectory"]
    assert goal["trajectory"]["joint_names"] == ["a joint", "it's"]
    points = goal["trajectory"]["points"]
    times = [
        point["time_from_start"]["sec"] * 10**9 + point["time_from_start"]["nanosec"] for point in points
    ]
    assert (np.diff(times) > 0).all()
    assert (times[0], times[-1]) == (0, 10**9)
    for name, expected in (("positions", samples.q), ("velocities", samples.v), ("accelerations", samples.a)):
        values = [point[name] for point in points]
        assert all(isinstance(value, float) for row in values for value in row)
        np.testing.assert_array_equal(values, expected)


def test_tiny_numbers_stay_numbers_in_yaml() -> None:
    samples = sample_for_controller(bang_bang(), 5.0)
    tiny = type(samples)(samples.nanoseconds, samples.q * 0 + 1e-20, samples.v, samples.a, 1.0)
    points = yaml.safe_load(to_ros2(tiny, ["a", "b"]))["trajectory"]["points"]
    assert points[0]["positions"] == [1e-20, 1e-20]


@pytest.mark.parametrize("names", [["a"], ["a", "a"]])
def test_wrong_joint_names_are_refused(names: list[str]) -> None:
    with pytest.raises(InputError, match="expected 2 different ones"):
        to_ros2(sample_for_controller(bang_bang(), 5.0), names)


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf"), 1e9])
def test_a_wrong_rate_is_refused(rate: float) -> None:
    with pytest.raises(InputError, match=r"rate|samples"):
        sample_for_controller(bang_bang(), rate)


def test_urscript_streams_every_period_and_ends_at_the_goal() -> None:
    program, scale = to_urscript(bang_bang(1.001, n=6), 125.0)
    rows = re.findall(r"servoj\(\[([^\]]*)\], 0, 0, 0\.008000", program)
    q = np.array([[float(value) for value in row.split(",")] for row in rows])
    assert len(q) == 126 and scale == pytest.approx(126 / 125 / 1.001)
    np.testing.assert_allclose(q[-1], 1.0, atol=1e-12)
    speed = np.abs(np.diff(q, axis=0)).max() * 125
    assert speed <= 2 / 1.001
    lines = program.splitlines()
    assert lines[0] == "def ocp_traj_motion():" and lines[-1] == "ocp_traj_motion()"
    assert lines[1].startswith("  movej([0.000000000000") and lines[-3:-1] == ["  stopj(10.0)", "end"]


def test_urscript_is_for_six_joints() -> None:
    with pytest.raises(InputError, match="has 2 joints, expected 6"):
        to_urscript(bang_bang(), 125.0)


def test_urscript_refuses_rates_no_controller_has() -> None:
    with pytest.raises(InputError, match="expected 1 to 500"):
        to_urscript(bang_bang(n=6), 1000.0)
