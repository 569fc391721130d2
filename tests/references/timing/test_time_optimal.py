"""TOPP-RA and convex timing of fixed paths."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.exceptions import InputError
from ocp_traj.references import ReferenceResult, convex_reference, toppra_reference
from ocp_traj.references.timing.toppra_reference import refine
from ocp_traj.task import Boundary, Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory

METHODS = [toppra_reference, convex_reference]


@pytest.mark.parametrize("method", METHODS)
def test_double_integrator_is_bang_bang(method: object) -> None:
    task = TrajectoryTask(np.array([[0.0], [2.0]]), Limits(acceleration=3.0))
    assert method(task, "chord").duration == pytest.approx(2 * np.sqrt(2.0 / 3.0), rel=1e-4)


@pytest.mark.parametrize("method", METHODS)
def test_double_integrator_with_speed_and_asymmetric_limits(method: object) -> None:
    limits = Limits(velocity=[[-9.0], [1.0]], acceleration=[[-4.0], [2.0]])
    task = TrajectoryTask(np.array([[0.0], [2.0]]), limits)
    expected = 1 / 2 + 1 / 4 + (2.0 - 0.25 - 0.125) / 1.0
    assert method(task, "uniform").duration == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("size", [1e-9, 1e-6, 1e3])
@pytest.mark.parametrize("method", METHODS)
def test_tiny_and_huge_paths_are_timed_alike(method: object, size: float) -> None:
    task = TrajectoryTask(
        size * np.array([[0.0, 0], [1, 2], [3, 1]]), Limits(velocity=size, acceleration=2 * size)
    )
    unit = TrajectoryTask(np.array([[0.0, 0], [1, 2], [3, 1]]), Limits(velocity=1.0, acceleration=2.0))
    assert method(task, "chord").duration == pytest.approx(method(unit, "chord").duration, rel=1e-5)


@pytest.mark.parametrize("method", METHODS)
def test_a_still_joint_and_duplicate_waypoints_change_nothing(method: object) -> None:
    points = np.array([[0.0, 0, 5], [1, 2, 5], [1, 2, 5], [3, 1, 5]])
    task = TrajectoryTask(points, Limits(velocity=1.0, acceleration=2.0))
    plain = TrajectoryTask(points[[0, 1, 3], :2], Limits(velocity=1.0, acceleration=2.0))
    assert method(task, "chord").duration == pytest.approx(method(plain, "chord").duration, rel=1e-5)


@pytest.mark.parametrize("method", METHODS)
def test_waypoints_that_are_all_equal_take_no_time(method: object) -> None:
    task = TrajectoryTask(np.ones((3, 2)), Limits(velocity=1.0, acceleration=1.0))
    assert method(task, "uniform").duration == 0.0


def test_durations_of_the_public_case(machines: TrajectoryTask) -> None:
    # toppra's own constraints and 4000 grid points give 1.60925 and 1.64522
    assert toppra_reference(machines, "uniform").duration == pytest.approx(1.60925, rel=1e-3)
    assert toppra_reference(machines, "chord").duration == pytest.approx(1.64522, rel=1e-3)


@pytest.mark.parametrize("path", ["uniform", "chord"])
def test_the_grid_is_refined_until_the_duration_is_stable(machines: TrajectoryTask, path: str) -> None:
    fine = toppra_reference(machines, path, points=3200)
    assert toppra_reference(machines, path).duration == pytest.approx(fine.duration, rel=1e-3)


def test_refinement_doubles_the_cells_until_nothing_changes() -> None:
    asked = []

    def solve(cells: int) -> ReferenceResult:
        asked.append(cells)
        return ReferenceResult("toppra", "chord", 1.0 + 1.0 / cells, points=cells)

    result = refine(solve, 1e-3, None)
    assert asked == [200, 400, 800, 1600] and result.points == 1600  # 1/800 - 1/1600 is the first below 0.001


def test_agrees_with_toppra_on_its_own_constraints() -> None:
    import toppra
    from toppra.algorithm import TOPPRA
    from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint

    rng = np.random.default_rng(5)
    points = rng.normal(size=(5, 4))
    path = toppra.SplineInterpolator(np.linspace(0, 1, 5), points)
    limits = [
        JointVelocityConstraint(np.tile([-1.0, 1.0], (4, 1))),
        JointAccelerationConstraint(np.tile([-2.0, 2.0], (4, 1))),
    ]
    theirs = TOPPRA(limits, path, gridpoints=np.linspace(0, 1, 3000), parametrizer="ParametrizeConstAccel")
    task = TrajectoryTask(points, Limits(velocity=1.0, acceleration=2.0))
    assert toppra_reference(task, "uniform").duration == pytest.approx(
        theirs.compute_trajectory().duration, rel=1e-3
    )


def test_both_methods_agree_and_name_the_same_limits(machines: TrajectoryTask) -> None:
    first = toppra_reference(machines, "uniform", points=400)
    second = convex_reference(machines, "uniform", points=400)
    assert second.duration == pytest.approx(first.duration, rel=1e-4)
    assert first.largest_ratio <= 1 + 1e-4 and second.largest_ratio <= 1 + 1e-4
    same = [a == b for a, b in zip(first.active, second.active) if a and b]
    assert len(same) > 300 and np.mean(same) > 0.9


def test_multipliers_tell_what_loosening_a_limit_gains() -> None:
    task = TrajectoryTask(np.array([[0.0], [1.0]]), Limits(acceleration=1.0))
    result = convex_reference(task, "chord", points=200)
    # T = 2 sqrt(1 / a): one percent more acceleration in every cell gains T / 2 percent
    assert result.multipliers.sum() == pytest.approx(0.5 * result.duration, rel=1e-3)
    assert set(result.active) == {"acceleration, joint 1"}


def test_the_path_of_a_motion_can_be_driven_at_least_as_fast() -> None:
    coefficients = np.zeros((1, 1, 6))
    coefficients[0, 0, 3:] = [10.0, -15.0, 6.0]
    motion = Trajectory(np.array([0.0, 1.0]), coefficients, np.array([0.0, 1.0]))
    task = TrajectoryTask(np.array([[0.0], [1.0]]), Limits(acceleration=10 / np.sqrt(3)))
    result = toppra_reference(task, motion)
    assert result.path == "spline"
    assert result.duration == pytest.approx(2 * np.sqrt(np.sqrt(3) / 10), rel=1e-4)


def test_limits_of_one_gap_hold_there_alone() -> None:
    velocity = np.full((2, 2, 1), [[-1.0], [1.0]])
    velocity[1] *= 0.5
    task = TrajectoryTask(np.array([[0.0], [1.0], [2.0]]), Limits(velocity=velocity, acceleration=1e6))
    result = toppra_reference(task, "chord")
    assert result.duration == pytest.approx(3.0, rel=1e-3)
    assert result.waypoint_times == pytest.approx([0.0, 1.0, 3.0], rel=1e-3, abs=1e-3)


def test_a_wanted_duration_is_kept() -> None:
    task = TrajectoryTask(np.array([[0.0, 0], [1, 2], [3, 1]]), Limits(velocity=1.0, acceleration=2.0))
    result = toppra_reference(task, "chord", duration=10.0)
    assert result.duration == pytest.approx(10.0, rel=1e-12)
    assert result.times[-1] == pytest.approx(10.0, rel=1e-12)
    assert result.largest_ratio < 1.0


def test_a_wanted_duration_below_the_least_is_refused_with_the_least() -> None:
    task = TrajectoryTask(np.array([[0.0], [1.0]]), Limits(acceleration=1.0))
    result = toppra_reference(task, "chord", duration=1.0)
    assert result.duration is None
    assert result.reason == "a duration of 1 s was asked for, this path takes at least 2 s"


def test_a_moving_start_is_kept() -> None:
    boundary = Boundary(velocity=[[1.0], [0.0]])
    task = TrajectoryTask(np.array([[0.0], [0.5]]), Limits(acceleration=1.0), boundary=boundary)
    assert toppra_reference(task, "chord").duration == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize(
    ("limits", "boundary", "sentence"),
    [
        (Limits(), Boundary(), "no velocity, acceleration or torque limit bounds the speed along this path"),
        (
            Limits(velocity=[1.0, 0.0]),
            Boundary(),
            "velocity, joint 2: a limit of 0 where the path needs motion, in gap 1 at 0 % of the path's length",
        ),
        (
            Limits(acceleration=[1.0, 0.0]),
            Boundary(),
            "acceleration, joint 2: a limit of 0 where the path needs motion, in gap 1 at 0 % of the path's length",
        ),
        (
            Limits(velocity=1.0, acceleration=1.0),
            Boundary(velocity=[[2.0, 2.0], [0.0, 0.0]]),
            "velocity, joint 1: the given velocity at the start is above the limit along this path",
        ),
    ],
)
@pytest.mark.parametrize("method", METHODS)
def test_a_failure_says_which_limit_and_where(
    method: object, limits: Limits, boundary: Boundary, sentence: str
) -> None:
    result = method(TrajectoryTask(np.array([[0.0, 0.0], [1.0, 1.0]]), limits, boundary=boundary), "chord")
    assert result.duration is None and not result.found
    assert result.reason == sentence


def test_a_start_too_fast_to_stop_is_a_failure_with_a_place() -> None:
    boundary = Boundary(velocity=[[3.0], [0.0]])
    task = TrajectoryTask(np.array([[0.0], [1.0]]), Limits(velocity=5.0, acceleration=1.0), boundary=boundary)
    result = toppra_reference(task, "chord")
    assert result.duration is None
    assert result.reason.startswith(
        "no speed at which the rest of the path can be driven within the limits exists"
    )
    assert convex_reference(task, "chord").duration is None


@pytest.mark.parametrize("duration", [0.0, -1.0, np.nan, np.inf])
def test_an_impossible_wanted_duration_is_refused(duration: float) -> None:
    task = TrajectoryTask(np.array([[0.0], [1.0]]), Limits(acceleration=1.0))
    with pytest.raises(InputError, match="expected a positive number of seconds"):
        toppra_reference(task, "chord", duration=duration)


def test_a_thermal_weight_without_torque_is_refused() -> None:
    task = TrajectoryTask(np.array([[0.0], [1.0]]), Limits(acceleration=1.0))
    with pytest.raises(InputError, match="needs a robot with inertia and torque limits"):
        convex_reference(task, "chord", thermal_weight=1.0)
    with pytest.raises(InputError, match="expected a number of 0 or more"):
        convex_reference(task, "chord", thermal_weight=-1.0)
