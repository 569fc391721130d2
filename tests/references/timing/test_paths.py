"""Sampling of geometric paths."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from ocp_traj.exceptions import InputError
from ocp_traj.references.timing.paths import geometric_path, sample_path
from ocp_traj.task import Boundary, Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory


def task_through(points: np.ndarray, **changes: object) -> TrajectoryTask:
    return TrajectoryTask(np.asarray(points, dtype=float), Limits(velocity=1.0, acceleration=1.0), **changes)


def test_derivatives_by_arc_length_agree_with_finite_differences() -> None:
    rng = np.random.default_rng(1)
    path = geometric_path(task_through(rng.normal(size=(5, 3))), "chord")
    grid = sample_path(path, 20_000)
    step = np.diff(grid.s)[:, None]
    chord = np.diff(grid.q, axis=0) / step
    assert np.abs(0.5 * (grid.tangent[:, 0] + grid.tangent[:, 1]) - chord).max() < 1e-4 * grid.length
    bend = (grid.tangent[:, 1] - grid.tangent[:, 0]) / step
    assert (
        np.abs(0.5 * (grid.curvature[:, 0] + grid.curvature[:, 1]) - bend).max() < 1e-4 * np.abs(bend).max()
    )


def test_tangent_by_scaled_arc_length_has_the_norm_of_the_length() -> None:
    grid = sample_path(
        geometric_path(task_through(np.random.default_rng(2).normal(size=(4, 2))), "uniform"), 100
    )
    assert np.allclose(np.linalg.norm(grid.tangent, axis=2), grid.length, rtol=1e-12)


@pytest.mark.parametrize("name", ["uniform", "chord"])
def test_path_is_the_not_a_knot_spline_through_the_waypoints(name: str) -> None:
    points = np.random.default_rng(3).normal(size=(6, 2))
    knots = np.arange(6.0)
    if name == "chord":
        knots = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    curve = geometric_path(task_through(points), name).curve
    assert curve is not None
    s = np.linspace(0, 1, 50)
    assert np.allclose(curve(s), CubicSpline(knots / knots[-1], points)(s), atol=1e-12)


def test_a_reversing_line_has_a_corner_where_the_motion_has_to_stop() -> None:
    grid = sample_path(geometric_path(task_through([[0.0], [1.0], [0.0]]), "uniform"), 50)
    assert grid.stops.sum() == 1
    assert np.allclose(grid.q[grid.stops], 1.0)
    assert grid.length == pytest.approx(2.0)


def test_rounding_in_a_leading_coefficient_does_not_hide_a_reversal() -> None:
    coefficients = np.array([[[0.0, 0.4, -0.5, 2e-16]]])
    motion = Trajectory(np.array([0.0, 1.0]), coefficients, np.array([0.0, 1.0]))
    grid = sample_path(geometric_path(task_through([[0.0], [-0.1]]), motion), 50)
    assert grid.q[grid.stops] == pytest.approx(0.08)


def test_equal_neighbouring_waypoints_are_one_knot_and_keep_their_gap_numbers() -> None:
    path = geometric_path(task_through([[0.0], [1.0], [1.0], [3.0]]), "chord")
    assert path.curve is not None and len(path.curve.breakpoints) == 3
    assert path.piece_gaps.tolist() == [0, 2]


def test_a_motion_from_rest_has_finite_derivatives_at_its_ends() -> None:
    coefficients = np.zeros((1, 2, 6))
    coefficients[0, 0, 3:] = [10.0, -15.0, 6.0]  # velocity and acceleration vanish at both ends
    coefficients[0, 1, 3:] = [20.0, -30.0, 12.0]
    motion = Trajectory(np.array([0.0, 1.0]), coefficients, np.array([0.0, 1.0]))
    grid = sample_path(geometric_path(task_through([[0.0, 0.0], [1.0, 2.0]]), motion), 40)
    assert np.allclose(grid.tangent, [1.0, 2.0])
    assert np.allclose(grid.curvature, 0.0, atol=1e-6)


def test_a_moving_end_leaves_along_its_velocity() -> None:
    boundary = Boundary(velocity=[[0.3, 0.4], [0.0, 0.0]])
    path = geometric_path(task_through([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], boundary=boundary), "chord")
    grid = sample_path(path, 50)
    assert path.end_speeds[0] == pytest.approx(0.5)
    assert np.allclose(grid.tangent[0, 0] / grid.length, [0.6, 0.8])


def test_an_unknown_path_is_refused_with_its_name() -> None:
    with pytest.raises(
        InputError, match=r"path 'arc' is unknown, expected 'uniform', 'chord' or a Trajectory"
    ):
        geometric_path(task_through([[0.0], [1.0]]), "arc")


def test_a_trajectory_with_other_waypoints_is_refused() -> None:
    motion = Trajectory(np.array([0.0, 1.0]), np.ones((1, 1, 2)), np.array([0.0, 1.0]))
    with pytest.raises(InputError, match="expected 1 and 3 as in the task"):
        geometric_path(task_through([[0.0], [1.0], [2.0]]), motion)
