"""The kinematic bound: known values, validity, honesty."""

from __future__ import annotations

import numpy as np
import pytest

from helpers import bounds_guard
from helpers.bounds_guard import contradiction
from ocp_traj.audit import audit
from ocp_traj.references import kinematic_bound, toppra_reference
from ocp_traj.task import Boundary, Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription import trajectory_from_durations


def test_one_gap_is_bang_bang() -> None:
    task = TrajectoryTask(np.array([[0.0, 0.0], [2.0, 0.1]]), Limits(velocity=1.0, acceleration=2.0))
    bound = kinematic_bound(task, gap=1e-4)
    assert bound.certified
    assert bound.estimate == pytest.approx(2.0 + 0.5, rel=1e-7)
    assert bound.lower == pytest.approx(2.5, rel=1.1e-4)


def test_a_straight_line_through_waypoints_need_not_slow_down() -> None:
    task = TrajectoryTask(np.linspace(0, 4, 5)[:, None], Limits(velocity=1.0, acceleration=2.0))
    assert kinematic_bound(task).estimate == pytest.approx(4.5, rel=1e-6)


def test_a_reversal_stops_the_joint() -> None:
    task = TrajectoryTask(np.array([[0.0], [1.0], [0.0]]), Limits(acceleration=1.0))
    bound = kinematic_bound(task)
    assert bound.estimate == pytest.approx(4.0, rel=1e-6)
    assert bound.velocities[1] == pytest.approx([0.0], abs=1e-3)


def test_machines_case_reaches_the_known_bound(machines: TrajectoryTask) -> None:
    bound = kinematic_bound(machines)
    assert bound.estimate == pytest.approx(1.4839, abs=1e-4)
    assert bound.certified and 1.469 <= bound.lower <= bound.estimate


def test_fanuc_case_reaches_the_known_bound(fanuc: TrajectoryTask) -> None:
    bound = kinematic_bound(fanuc)
    assert bound.estimate == pytest.approx(0.7212, abs=1e-4)
    assert bound.certified and bound.lower <= bound.estimate


def test_joint_order_and_units_do_not_matter(machines: TrajectoryTask) -> None:
    order = [3, 1, 5, 0, 2, 4]
    factor = np.array([1.0, 2.0, 0.1, 30.0, 1.0, 5.0])
    limits = Limits(
        velocity=(machines.limits.get("velocity") * factor)[:, :, order],
        acceleration=(machines.limits.get("acceleration") * factor)[:, :, order],
    )
    other = TrajectoryTask((machines.waypoints * factor)[:, order], limits)
    assert kinematic_bound(other).estimate == pytest.approx(kinematic_bound(machines).estimate, rel=1e-6)


def test_a_moving_end_has_no_bound(machines: TrajectoryTask) -> None:
    boundary = Boundary(velocity=np.full((2, 6), 0.1), acceleration=0.0)
    bound = kinematic_bound(machines.changed(boundary=boundary))
    assert bound.lower is None and bound.estimate is None
    assert bound.message == "the ends are not at rest, the bound is defined from rest to rest"


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        (Limits(), "no velocity or acceleration limit bounds the duration"),
        (Limits(velocity=0.0, acceleration=1.0), "a joint that has to move has a velocity limit of 0"),
        (Limits(acceleration=0.0), "a joint that has to move has a acceleration limit of 0"),
    ],
)
def test_why_there_is_no_bound(limits: Limits, message: str) -> None:
    bound = kinematic_bound(TrajectoryTask(np.array([[0.0], [1.0]]), limits))
    assert bound.lower is None and bound.message == message


def test_nothing_to_move_takes_no_time() -> None:
    bound = kinematic_bound(TrajectoryTask(np.ones((3, 2)), Limits(acceleration=1.0)))
    assert (bound.lower, bound.estimate, bound.certified) == (0.0, 0.0, True)


def test_speed_limits_alone_bound_the_duration() -> None:
    bound = kinematic_bound(TrajectoryTask(np.array([[0.0], [1.0], [-1.0]]), Limits(velocity=2.0)))
    assert bound.lower == pytest.approx(1.5, rel=1e-6)
    assert bound.estimate == pytest.approx(1.5, rel=1e-6)


def test_wide_tolerances_leave_the_way_between_the_ends() -> None:
    """A waypoint that may be anywhere between its neighbours costs nothing, but the whole way stays."""
    waypoints, limits = np.array([[0.0], [1.0], [2.0]]), Limits(velocity=1.0, acceleration=1.0)
    loose = TrajectoryTask(waypoints, limits, tolerance=np.array([[0.0], [1.0], [0.0]]))
    bound = kinematic_bound(loose, time_limit=1.0)
    assert bound.estimate == pytest.approx(3.0, abs=1e-6)  # 1 s up, 1 s at full speed, 1 s down
    assert bound.lower is not None and 2.0 * (1 - 1e-8) <= bound.lower <= bound.estimate


def test_tolerance_around_waypoints_shortens_the_bound() -> None:
    points = np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]])
    exact = TrajectoryTask(points, Limits(acceleration=1.0))
    loose = kinematic_bound(exact.changed(tolerance=0.1))
    assert loose.lower <= loose.estimate < kinematic_bound(exact).lower


def random_lopsided_task(rng: np.random.Generator, gaps: int, n: int) -> TrajectoryTask:
    """Return a task with random waypoints and random, asymmetric limits that may differ from gap to gap."""
    waypoints = rng.normal(size=(gaps + 1, n)) * rng.choice([1e-3, 0.1, 1.0])
    if n > 1 and rng.random() < 0.3:
        waypoints[:, 0] = waypoints[0, 0]
    scale = np.abs(np.diff(waypoints, axis=0)).max()
    shape = (gaps, n) if rng.random() < 0.3 else (1, n)

    def limit(size: float) -> np.ndarray:
        sides = np.stack([-rng.uniform(0.3, 2.0, shape), rng.uniform(0.3, 2.0, shape)], axis=1) * size
        return np.broadcast_to(sides, (gaps, 2, n))

    velocity = limit(scale) if rng.random() < 0.8 else np.inf
    return TrajectoryTask(waypoints, Limits(velocity=velocity, acceleration=limit(3 * scale)))


def check_random_cases(count: int, seed: int) -> int:
    """Compare certified bounds with motions that exist: TOPP-RA timings and random local optima."""
    rng = np.random.default_rng(seed)
    compared = 0
    for _ in range(count):
        task = random_lopsided_task(rng, int(rng.integers(1, 5)), int(rng.integers(1, 5)))
        bound = kinematic_bound(task, gap=0.05, largest_nodes=4000, starts=2, time_limit=2.0)
        assert bound.lower is not None and bound.estimate is not None
        assert 0.0 < bound.lower <= bound.estimate * (1 + 1e-9)
        for path in ("uniform", "chord"):
            timed = toppra_reference(task, path, points=200)
            if timed.duration is not None:
                # limits hold at the grid points; between them by a little less
                assert bound.lower <= timed.duration * (1 + 1e-3)
                compared += 1
    return compared


def test_no_motion_of_random_cases_is_shorter_than_its_bound() -> None:
    assert check_random_cases(8, 20) >= 12


@pytest.mark.parametrize(
    "cases", [pytest.param(60, marks=pytest.mark.slow), pytest.param(500, marks=pytest.mark.long)]
)
def test_no_motion_of_many_random_cases_is_shorter_than_its_bound(cases: int) -> None:
    assert check_random_cases(cases, 21) >= 1.8 * cases


def test_the_whole_suite_holds_accepted_motions_against_their_bounds() -> None:
    task = TrajectoryTask(np.array([[0.0], [2.0]]), Limits(velocity=1.0, acceleration=2.0))
    shape = 2.0 * np.array([[[0.0, 0, 0, 10.0, -15.0, 6.0]]])
    for duration, complaint in ((6.0, ""), (2.4, "pass the audit, but not the exact test")):
        scaled = shape / duration ** np.arange(6)
        motion = Trajectory(np.array([0.0, duration]), scaled, np.array([0.0, duration]), "quintic")
        assert complaint in contradiction(task, motion)
        assert bool(contradiction(task, motion)) == bool(complaint)
        assert audit(task, motion).feasible == (not complaint)


def test_a_contradiction_fails_the_test_wherever_the_judge_was_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    import ocp_traj

    task = TrajectoryTask(np.array([[0.0], [2.0]]), Limits(velocity=1.0, acceleration=2.0))
    motion = trajectory_from_durations(task, np.array([6.0]))
    monkeypatch.setattr(bounds_guard, "contradiction", lambda task, trajectory: "shorter than proved")
    for judge in (audit, ocp_traj.audit):
        with pytest.raises(AssertionError, match="shorter than proved"):
            judge(task, motion)
    with pytest.raises(AssertionError, match="shorter than proved"):
        ocp_traj.solve(task)
