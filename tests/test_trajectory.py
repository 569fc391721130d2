"""The piecewise polynomial: evaluation, time scaling, refusals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import PPoly

from ocp_traj.exceptions import InputError
from ocp_traj.trajectory import Trajectory


def random_trajectory(seed: int = 0) -> Trajectory:
    rng = np.random.default_rng(seed)
    breakpoints = np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 1.0, 4))])
    return Trajectory(breakpoints, rng.normal(size=(4, 3, 6)), breakpoints[[0, 2, 4]], "quintic", "some")


@pytest.mark.parametrize("derivative", range(8))
def test_every_derivative_agrees_with_scipy(derivative: int) -> None:
    trajectory = random_trajectory()
    reference = PPoly(np.transpose(trajectory.coefficients, (2, 0, 1))[::-1], trajectory.breakpoints)
    times = np.linspace(0.0, trajectory.duration, 101)
    expected = reference.derivative(derivative)(times) if derivative else reference(times)
    assert trajectory(times, derivative) == pytest.approx(expected, abs=1e-9)
    assert trajectory(0.3, derivative).shape == (3,)


def test_times_outside_are_clipped() -> None:
    trajectory = random_trajectory()
    assert np.array_equal(trajectory(-5.0), trajectory(0.0))
    assert np.array_equal(trajectory(1e9), trajectory(trajectory.duration))


def test_scaling_runs_the_same_path_slower() -> None:
    trajectory = random_trajectory()
    slow = trajectory.scaled(3.0)
    times = np.linspace(0.0, trajectory.duration, 50)[1:-1]
    for order in range(4):
        assert slow(3 * times, order) == pytest.approx(trajectory(times, order) / 3.0**order, rel=1e-9)
    assert slow.duration == pytest.approx(3 * trajectory.duration)
    assert slow.segment_durations == pytest.approx(3 * trajectory.segment_durations)
    assert (slow.family, slow.case) == ("quintic", "some")


@pytest.mark.parametrize("scale", [0.0, -1.0, np.nan, np.inf])
def test_a_scale_must_be_positive(scale: float) -> None:
    with pytest.raises(InputError, match="expected a positive number"):
        random_trajectory().scaled(scale)


def test_arrays_are_copied_and_read_only() -> None:
    breakpoints = np.array([0.0, 1.0])
    trajectory = Trajectory(breakpoints, np.zeros((1, 1, 4)), breakpoints)
    breakpoints[1] = 7.0
    assert trajectory.duration == 1.0
    with pytest.raises(ValueError, match="read-only"):
        trajectory.coefficients[0, 0, 0] = 1.0


@pytest.mark.parametrize(
    ("breakpoints", "coefficients", "waypoint_times", "message"),
    [
        ([0.0, 1.0], np.zeros((2, 1, 4)), [0.0, 1.0], "got shapes"),
        ([0.0, 1.0], np.zeros((1, 4)), [0.0, 1.0], "got shapes"),
        ([0.0, np.nan], np.zeros((1, 1, 4)), [0.0, 1.0], "finite"),
        ([0.0, 1.0], np.full((1, 1, 4), np.inf), [0.0, 1.0], "finite"),
        ([0.0, 0.0], np.zeros((1, 1, 4)), [0.0, 1.0], "increase strictly"),
        ([0.0, 1.0], np.zeros((1, 1, 4)), [0.0], "at least two finite numbers"),
        ([0.0, 1.0], np.zeros((1, 1, 4)), [0.0, 0.6, 0.5, 1.0], "that do not decrease"),
        ([0.0, 1.0], np.zeros((1, 1, 4)), [0.0, np.nan], "at least two finite numbers"),
        ([0.0, 1.0], np.zeros((1, 1, 4)), [0.0, 0.5], "run from 0 to 0.5 s, expected its span, 0 to 1 s"),
    ],
)
def test_what_is_no_trajectory_is_refused(
    breakpoints: list[float], coefficients: np.ndarray, waypoint_times: list[float], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        Trajectory(breakpoints, coefficients, waypoint_times)


def test_a_negative_derivative_is_refused() -> None:
    with pytest.raises(InputError, match="derivative is -1"):
        random_trajectory()(0.0, -1)


def test_a_waypoint_belongs_to_the_gap_it_begins_and_the_ends_to_the_outer_gaps() -> None:
    trajectory = random_trajectory()
    start, middle, end = trajectory.waypoint_times
    times = [start - 1.0, start, middle - 1e-9, middle, end, end + 1.0]
    assert trajectory.gap_at(times).tolist() == [0, 0, 0, 1, 1, 1]
