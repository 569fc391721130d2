"""The verdict as a whole: waypoints, ends, durations, sentences, JSON, wrong input."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from helpers.audit_motions import clamped_cubic, pendulum, random_spline
from ocp_traj.audit import audit
from ocp_traj.exceptions import InputError
from ocp_traj.task import Boundary, Limits, Objective, TrajectoryTask
from ocp_traj.trajectory import Trajectory


def unit_cubic() -> Trajectory:
    """Return q = 3 x^2 - 2 x^3 with x = t / 2: velocity 3/4 at 1 s, acceleration 3/2 at the ends, jerk -3/2."""
    return Trajectory([0.0, 2.0], [[[0.0, 0.0, 0.75, -0.25]]], [0.0, 2.0], "cubic", "unit")


def test_a_rest_to_rest_cubic_has_its_known_peaks() -> None:
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=1.5, acceleration=3.0, jerk=3.0), virtual_knots=0)
    verdict = audit(task, unit_cubic())
    assert verdict.feasible
    assert verdict.findings == ()
    assert {name: peak.ratio for name, peak in verdict.limits.items()} == pytest.approx(
        {"velocity": 0.5, "acceleration": 0.5, "jerk": 0.5}
    )
    assert verdict.limits["velocity"].time == pytest.approx(1.0)
    assert verdict.smallest_feasible_scale == pytest.approx(0.5 ** (1 / 3))
    assert verdict.duration == 2.0
    assert verdict.waypoint_error == 0.0
    assert verdict.boundary_error == 0.0


@pytest.mark.parametrize(("excess", "feasible"), [(0.9e-6, True), (1.1e-6, False)])
def test_a_ratio_may_exceed_one_by_a_millionth(excess: float, feasible: bool) -> None:
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=0.75 / (1 + excess)))
    assert audit(task, unit_cubic()).feasible is feasible


@pytest.mark.parametrize(("miss", "feasible"), [(0.9e-8, True), (1.1e-8, False)])
def test_a_waypoint_may_be_missed_by_ten_nanoradians(miss: float, feasible: bool) -> None:
    verdict = audit(TrajectoryTask([[0.0], [1.0 + miss]], Limits(velocity=9.0)), unit_cubic())
    assert verdict.feasible is feasible
    assert verdict.waypoint_error == pytest.approx(miss, rel=1e-6)


def test_a_missed_waypoint_is_named() -> None:
    waypoints = np.array([[0.0, 0.0], [1.0, 2.0], [0.0, 1.0]])
    trajectory = clamped_cubic(waypoints, np.array([1.0, 1.5]))
    asked = waypoints + np.array([[0.0, 0.0], [0.0, 0.25], [0.0, 0.0]])
    verdict = audit(TrajectoryTask(asked, Limits(velocity=9.0)), trajectory)
    assert verdict.findings == ("waypoint 2: joint 2 misses it by 0.25 rad (m) at 1 s, allowed 1e-08",)
    assert verdict.waypoint_error == pytest.approx(0.25)
    boxed = audit(TrajectoryTask(asked, Limits(velocity=9.0), tolerance=0.3), trajectory)
    assert boxed.feasible
    assert boxed.waypoint_error == 0.0


@pytest.mark.parametrize("row", [0, 1])
@pytest.mark.parametrize(("miss", "feasible"), [(0.9e-8, True), (1.1e-8, False)])
def test_boundary_conditions_are_relative_to_the_limit(row: int, miss: float, feasible: bool) -> None:
    asked = np.zeros((2, 1))
    asked[row] = miss * 5.0
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=5.0), boundary=Boundary(velocity=asked))
    verdict = audit(task, unit_cubic())
    assert verdict.feasible is feasible
    assert verdict.boundary_error == pytest.approx(miss, rel=1e-6)


def test_without_a_limit_a_boundary_is_relative_to_the_largest_value() -> None:
    task = TrajectoryTask([[0.0], [1.0]], boundary=Boundary(velocity=[[0.0], [0.0075]]))
    assert audit(task, unit_cubic()).boundary_error == pytest.approx(0.01)


def test_a_missed_boundary_condition_is_named() -> None:
    task = TrajectoryTask(
        [[0.0], [1.0]],
        Limits(acceleration=3.0),
        virtual_knots=2,
        boundary=Boundary(acceleration=0.0),
    )
    verdict = audit(task, unit_cubic())
    assert not verdict.feasible
    assert verdict.findings == (
        "boundary acceleration at the start: joint 1 has 1.5, expected 0",
        "boundary acceleration at the end: joint 1 has -1.5, expected 0",
    )
    assert verdict.boundary_error == pytest.approx(0.5)


def test_end_jerks_are_checked_where_they_are_given() -> None:
    rng = np.random.default_rng(1)
    trajectory = random_spline(rng, 5, 2, 3)  # zero velocity and acceleration, jerk as it comes
    waypoints = trajectory(trajectory.waypoint_times)
    quintic = audit(TrajectoryTask(waypoints, family="quintic"), trajectory)
    assert quintic.feasible
    septic = audit(TrajectoryTask(waypoints, family="septic"), trajectory)
    assert not septic.feasible
    assert septic.findings[0].startswith("boundary jerk at the start: joint ")


def test_durations_outside_their_bounds_are_named() -> None:
    objective = Objective(duration=(0.5, 1.5), gap_durations=[[2.5, 3.0]])
    verdict = audit(TrajectoryTask([[0.0], [1.0]], Limits(velocity=9.0), objective=objective), unit_cubic())
    assert not verdict.feasible
    assert verdict.findings == (
        "duration: 2 s in total, expected between 0.5 and 1.5 s",
        "duration of gap 1: 2 s, expected between 2.5 and 3 s",
    )


@pytest.mark.parametrize(("bound", "feasible"), [(2.0 * (1 + 0.9e-9), True), (2.0 * (1 + 1.1e-9), False)])
def test_a_duration_may_miss_its_bound_by_a_billionth(bound: float, feasible: bool) -> None:
    task = TrajectoryTask([[0.0], [1.0]], objective=Objective(duration=(bound, 9.0)))
    assert audit(task, unit_cubic()).feasible is feasible


def test_every_broken_limit_and_joint_gets_its_sentence(tmp_path: Path) -> None:
    limits = Limits(
        velocity=0.5, acceleration=1.0, jerk=1.0, torque=9.0, torque_rate=1.0, position=[[-1.0], [1.0]]
    )
    task = TrajectoryTask([[0.0], [1.0]], limits, robot=pendulum(tmp_path), virtual_knots=0)
    verdict = audit(task, unit_cubic())
    assert [finding.split(":")[0] for finding in verdict.findings] == [
        "velocity",
        "acceleration",
        "jerk",
        "torque",
        "torque rate",
    ]
    assert (
        verdict.findings[0]
        == "velocity: joint 1, gap 1, at 1 s: 0.75 against 0.5 rad/s (m/s), 1.5 times the limit"
    )
    assert verdict.findings[3].endswith("against 9 N m (N), 1.19 times the limit")
    assert verdict.worst == verdict.limits["torque_rate"]


def test_worst_is_none_without_limits() -> None:
    verdict = audit(TrajectoryTask([[0.0], [1.0]]), unit_cubic())
    assert verdict.feasible
    assert verdict.worst is None
    assert verdict.limits == {}
    assert verdict.to_json()["worst"] is None


def test_json_is_what_the_contract_says(tmp_path: Path) -> None:
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=0.5), robot=pendulum(tmp_path), name="swing")
    data = json.loads(json.dumps(audit(task, unit_cubic()).to_json(), allow_nan=False))
    for key in (
        "schema",
        "case",
        "feasible",
        "duration",
        "worst",
        "limits",
        "waypoint_error",
        "smallest_feasible_scale",
    ):
        assert key in data
    assert (data["schema"], data["case"], data["feasible"], data["duration"]) == (1, "swing", False, 2.0)
    assert {key: data["worst"][key] for key in ("limit", "joint", "time", "ratio")} == {
        "limit": "velocity",
        "joint": 1,
        "time": pytest.approx(1.0),
        "ratio": pytest.approx(1.5),
    }
    assert set(data["limits"]) == {"position", "velocity", "torque"}
    assert data["limits"]["torque"]["joint"] == 1
    assert data["smallest_feasible_scale"] == pytest.approx(1.5)


def test_a_verdict_prints_its_numbers() -> None:
    text = str(audit(TrajectoryTask([[0.0], [1.0]], Limits(velocity=0.5)), unit_cubic()))
    assert text.splitlines() == [
        "NOT feasible, 2 s",
        "  velocity       1.5000000  joint 1, gap 1, 1 s",
        "  waypoints met within 0, boundary within 0",
        "  smallest feasible uniform slowing: 1.5",
        "  - velocity: joint 1, gap 1, at 1 s: 0.75 against 0.5 rad/s (m/s), 1.5 times the limit",
    ]
    hopeless = str(audit(TrajectoryTask([[0.0], [2.0]], Limits(velocity=1.0)), unit_cubic()))
    assert "no uniform slowing makes it feasible" in hopeless


def test_a_trajectory_with_other_joints_or_waypoints_is_refused() -> None:
    with pytest.raises(InputError, match="the trajectory has 1 joints, expected 2"):
        audit(TrajectoryTask([[0.0, 0.0], [1.0, 1.0]]), unit_cubic())
    three = clamped_cubic(np.array([[0.0], [1.0], [2.0]]), np.array([1.0, 1.0]))
    with pytest.raises(InputError, match="the trajectory passes 3 waypoints, expected 4"):
        audit(TrajectoryTask([[0.0], [1.0], [1.5], [2.0]]), three)


def test_a_degree_that_samples_could_not_see_is_refused() -> None:
    high = Trajectory([0.0, 1.0], np.zeros((1, 1, 32)), [0.0, 1.0])
    with pytest.raises(InputError, match="the trajectory has degree 31, expected at most 30"):
        audit(TrajectoryTask([[0.0], [0.0]]), high)


def test_joints_may_be_permuted() -> None:
    rng = np.random.default_rng(4)
    waypoints = rng.normal(size=(4, 3))
    order = np.array([2, 0, 1])
    h = rng.uniform(0.3, 1.0, 3)
    velocity = np.array([1.0, 2.0, 3.0])
    one = audit(TrajectoryTask(waypoints, Limits(velocity=velocity)), clamped_cubic(waypoints, h))
    task = TrajectoryTask(waypoints[:, order], Limits(velocity=velocity[order]))
    other = audit(task, clamped_cubic(waypoints[:, order], h))
    assert one.worst is not None
    assert other.worst is not None
    assert other.worst.ratio == pytest.approx(one.worst.ratio, rel=1e-12)
    assert order[other.worst.joint] == one.worst.joint


def test_thirty_joints_and_a_thousand_waypoints_are_judged() -> None:
    rng = np.random.default_rng(5)
    waypoints = np.cumsum(rng.normal(size=(1000, 30)), axis=0) * 0.01
    trajectory = clamped_cubic(waypoints, np.full(999, 0.1))
    samples = np.abs(trajectory(np.linspace(0, trajectory.duration, 50_000), 1)).max()
    verdict = audit(TrajectoryTask(waypoints, Limits(velocity=1.0)), trajectory)
    assert verdict.waypoint_error < 1e-8
    assert verdict.limits["velocity"].ratio == pytest.approx(samples, rel=1e-4)
    assert verdict.limits["velocity"].ratio >= samples


@pytest.mark.parametrize(("size", "seconds"), [(1e300, 1.0), (1.0, 1e100), (1.0, 1e-150), (1e300, 1e-3)])
def test_numbers_out_of_range_are_refused_without_warnings(
    size: float, seconds: float, recwarn: pytest.WarningsRecorder
) -> None:
    trajectory = Trajectory([0.0, seconds], [[[0.0, 1e-3 * size, -size]]], [0.0, seconds])
    limits = Limits(velocity=1.0, acceleration=1.0, jerk=1.0, position=[[-1.0], [2.0]])
    verdict = audit(TrajectoryTask([[0.0], [1.0]], limits), trajectory)
    assert not verdict.feasible
    json.dumps(verdict.to_json(), allow_nan=False)
    assert not recwarn.list


@pytest.mark.parametrize("zero", [0.0, -0.0])
@pytest.mark.parametrize("name", ["velocity", "acceleration", "jerk"])
@pytest.mark.parametrize("side", [0, 1])
def test_a_joint_that_may_move_to_one_side_only_may_not_move_back(zero: float, name: str, side: int) -> None:
    motion = clamped_cubic(np.array([[0.0], [1.0], [0.0]]), np.array([1.0, 1.0]))
    limit = [[-1e3], [1e3]]
    limit[side] = [zero]
    verdict = audit(TrajectoryTask([[0.0], [1.0], [0.0]], Limits(**{name: limit})), motion)
    assert not verdict.feasible
    assert verdict.limits[name].ratio == np.inf
    assert verdict.smallest_feasible_scale is None


@pytest.mark.parametrize("zero", [0.0, -0.0])
@pytest.mark.parametrize("side", [0, 1])
def test_a_motor_that_may_push_to_one_side_only_may_not_pull(tmp_path: Path, zero: float, side: int) -> None:
    motion = clamped_cubic(np.array([[0.0], [1.0], [0.0]]), np.array([1.0, 1.0]))
    torque = [[-1e3], [1e3]]
    torque[side] = [zero]
    limits = Limits(velocity=np.inf, torque=torque)
    task = TrajectoryTask([[0.0], [1.0], [0.0]], limits, robot=pendulum(tmp_path, gravity=0.0))
    verdict = audit(task, motion)
    assert not verdict.feasible
    assert verdict.limits["torque"].ratio == np.inf
