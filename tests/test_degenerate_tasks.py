"""Tasks at the edge of having nothing to do: doubled waypoints, standing still, tiny moves from far positions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ocp_traj as ot
from ocp_traj.exceptions import TaskError
from ocp_traj.references import collect_references, jerk_estimate, kinematic_bound, toppra_reference
from ocp_traj.task import Boundary, Limits, Objective, TrajectoryTask

FAULTS = Path(__file__).parent / "data" / "faults"


def solved(task: TrajectoryTask, solver: str = "ipopt", **options):
    result = ot.solve(task, solver, **options)
    assert result.feasible, f"{result}\n{result.audit and result.audit.findings}"
    assert len(result.trajectory.waypoint_times) == len(task.waypoints)
    return result


def test_a_doubled_waypoint_is_passed_once() -> None:
    result = solved(ot.load_case(FAULTS / "dup-middle.toml"))
    assert result.duration == pytest.approx(1.5, rel=1e-5)
    assert result.segment_durations[1] == 0.0
    assert result.to_json()["segment_durations"][1] == 0.0


def test_bound_and_timings_agree_that_it_is_one_point(recwarn: pytest.WarningsRecorder) -> None:
    found = collect_references(ot.load_case(FAULTS / "dup-middle.toml"), convex=False)
    bound = found.bound
    assert 1.497 <= bound.lower <= bound.estimate == pytest.approx(1.5, rel=1e-6)
    np.testing.assert_allclose(bound.durations, [0.75, 0.0, 0.75], atol=1e-5)
    assert bound.velocities.shape == (4, 1) and bound.velocities[1, 0] == bound.velocities[2, 0]
    for timing in found.toppra:
        assert timing.duration == pytest.approx(1.5, rel=1e-3)
        assert len(timing.waypoint_times) == 4 and timing.waypoint_times[1] == timing.waypoint_times[2]
    assert not recwarn.list


def test_a_gap_with_a_duration_is_a_dwell() -> None:
    result = solved(ot.load_case(FAULTS / "dup-middle-dwell-still.toml"))
    assert result.duration == pytest.approx(2.5, rel=5e-3)
    assert result.segment_durations[1] == pytest.approx(0.5, rel=1e-9)


def test_standing_still_is_a_motion() -> None:
    result = solved(ot.load_case(FAULTS / "all-equal.toml"))
    assert result.duration < 1e-2
    task = ot.load_case(FAULTS / "all-equal.toml")
    bounded = task.changed(objective=Objective(time=1.0, duration=(0.5, 2.0)))
    assert solved(bounded).duration == pytest.approx(0.5, rel=1e-6)


@pytest.mark.parametrize("solver", ["pso", "cmaes+ipopt", "ipopt-multistart"])
def test_every_kind_of_solver_takes_it_once(solver: str) -> None:
    task = ot.load_case(FAULTS / "dup-middle.toml").changed(virtual_knots=0)
    result = solved(task, solver, budget=1500)
    once = solved(task.changed(waypoints=[[0.0], [1.0], [2.0]], limits=Limits(velocity=2.0, acceleration=4.0),
                               objective=Objective(), tolerance=0.0))  # fmt: skip
    assert result.segment_durations[1] == 0.0
    assert result.duration == pytest.approx(once.duration, rel=5e-2 if solver == "pso" else 1e-3)
    decoded = result.solution.problem.decode(result.solution.x)
    np.testing.assert_allclose(decoded.segment_durations, result.segment_durations, rtol=2e-2, atol=0)


@pytest.mark.parametrize("jerk", [np.inf, 1.0])
@pytest.mark.parametrize(
    ("family", "knots"), [("cubic", 0), ("cubic", 3), ("cubic", 5), ("cubic", 7), ("quintic", 0), ("septic", 0)]
)
def test_a_doubled_end_costs_nothing(family: str, knots: int, jerk: float) -> None:
    limits = Limits(velocity=1.0, acceleration=1.0, jerk=jerk)
    doubled, single = (
        TrajectoryTask(np.array(waypoints)[:, None], limits, family=family, virtual_knots=knots)
        for waypoints in ([0.0, 0.0, 1.0, 1.0, 1.0], [0.0, 1.0])
    )
    assert solved(doubled).duration == pytest.approx(solved(single).duration, rel=1e-9)


def test_a_doubled_waypoint_with_a_box_and_limits_by_gap() -> None:
    velocity = np.array([2.0, 0.0, 1.0])[:, None, None] * np.array([[-1.0], [1.0]])
    limits = Limits(velocity=velocity, acceleration=4.0)
    task = TrajectoryTask(
        np.array([[0.0], [1.0], [1.0], [2.0]]), limits, virtual_knots=3, tolerance=[[0.0], [0.1], [0.2], [0.0]]
    )
    result = solved(task)
    single = TrajectoryTask(
        np.array([[0.0], [1.0], [2.0]]),
        Limits(velocity=velocity[[0, 2]], acceleration=4.0),
        virtual_knots=3,
        tolerance=[[0.0], [0.1], [0.0]],
    )
    assert result.duration == pytest.approx(solved(single).duration, rel=1e-9)


def test_a_warm_start_has_the_waypoints_of_the_task() -> None:
    task = ot.load_case(FAULTS / "dup-middle.toml")
    first = solved(task)
    again = solved(task, warm_start=first.trajectory)
    assert again.duration <= first.duration * (1 + 1e-9)


def test_conflicts_are_named_by_the_gaps_of_the_task() -> None:
    velocity = np.array([2.0, 2.0, 0.0])[:, None, None] * np.array([[-1.0], [1.0]])
    task = TrajectoryTask(np.array([[0.0], [1.0], [1.0], [2.0]]), Limits(velocity=velocity, acceleration=4.0))
    assert "gap 3" in ot.solve(task).message


def test_too_few_points_are_refused() -> None:
    task = TrajectoryTask(np.array([[0.0], [1.0], [1.0], [2.0]]), Limits(velocity=1.0), family="3-5-3")
    for refuse in (ot.solve, kinematic_bound):
        with pytest.raises(TaskError, match="equal consecutive waypoints are one point"):
            refuse(task)


@pytest.mark.parametrize("acceleration", [0.0, None])
def test_a_tiny_move_takes_its_tiny_time(acceleration: float | None) -> None:
    task = ot.load_case(FAULTS / "tiny-1e-12.toml")
    task = task.changed(boundary=Boundary(acceleration=acceleration))
    travel = task.waypoints[1, 0] - task.waypoints[0, 0]
    # jerk alone: full jerk up and down in quarters, or in halves where the acceleration is free at both ends
    exact = (32.0 * travel / 150.0) ** (1 / 3) if acceleration == 0.0 else (12.0 * travel / 150.0) ** (1 / 3)
    assert solved(task).duration == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("travel", [1e-15, 1e-9, 1.0, 1e6])
@pytest.mark.parametrize("origin", [0.3, 1e3])
def test_moves_of_all_sizes_from_far_positions(travel: float, origin: float) -> None:
    waypoints = np.array([[origin, 0.2], [origin + travel, 0.2]])
    moved = waypoints[1, 0] - waypoints[0, 0]
    if moved == 0.0:
        waypoints[1, 0] = np.nextafter(origin, np.inf)
        moved = waypoints[1, 0] - waypoints[0, 0]
    limits = Limits(velocity=[3.0, 0.0], acceleration=[6.0, 0.0])  # the second joint rests and may not move
    result = solved(TrajectoryTask(waypoints, limits, virtual_knots=3))
    exact = 2.0 * np.sqrt(moved / 6.0) if moved < 1.5 else moved / 3.0 + 0.5
    # of days at full speed the half seconds of acceleration would be less than the shortest piece a solver makes
    assert result.duration == pytest.approx(exact, rel=1e-3 if travel < 1e6 else 6e-3)


@pytest.mark.parametrize("bounded", [False, True])
@pytest.mark.parametrize("waypoints", [[0.0, 0.0, 1.0, 2.0], [0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 2.0, 2.0]])
def test_the_estimate_is_not_above_a_motion_that_exists(waypoints: list[float], bounded: bool) -> None:
    bounds = [[0.0, 10.0]] * 3 if bounded else None
    task = TrajectoryTask(
        np.array(waypoints)[:, None], Limits(velocity=2.0, acceleration=4.0), objective=Objective(gap_durations=bounds)
    )
    bound = kinematic_bound(task, time_limit=1e9, largest_nodes=100, starts=2)
    assert bound.lower <= bound.estimate <= 1.5 * (1 + 1e-9)
    assert bound.estimate <= toppra_reference(task, "chord").duration * (1 + 1e-9)


def test_the_estimate_is_not_above_the_timed_spline_on_random_tasks() -> None:
    rng = np.random.default_rng(4)
    for _ in range(4):
        waypoints = np.repeat(rng.uniform(-1, 1, (3, 3)), rng.integers(1, 3, 3), axis=0)
        task = TrajectoryTask(waypoints, Limits(velocity=2.0, acceleration=4.0))
        timed = min(toppra_reference(task, path).duration for path in ("uniform", "chord"))
        assert kinematic_bound(task, starts=1, time_limit=1e9, largest_nodes=1).estimate <= timed * (1 + 1e-3)


def test_the_estimate_with_bounded_jerk_passes_it_once_too() -> None:
    limits = Limits(velocity=1.0, acceleration=1.0, jerk=1.0)
    doubled, single = (
        jerk_estimate(TrajectoryTask(np.array(waypoints)[:, None], limits), knots=3)
        for waypoints in ([0.0, 1.0, 1.0], [0.0, 1.0])
    )
    assert doubled.estimate == pytest.approx(single.estimate, rel=1e-9)
    assert doubled.durations[1] == 0.0
