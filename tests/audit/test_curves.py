"""Cartesian speeds and a user's own constraints at every time."""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from helpers.audit_motions import INERTIA, clamped_cubic, pendulum
from ocp_traj.audit import audit
from ocp_traj.audit.numerics import chebyshev
from ocp_traj.exceptions import InputError
from ocp_traj.robot import Robot, load_robot
from ocp_traj.task import CustomConstraint, Limits, TrajectoryTask


@pytest.fixture(scope="module")
def ur5() -> Robot:
    return load_robot("ur5")


@pytest.mark.parametrize("seed", range(3))
def test_cartesian_speed_peaks_agree_with_dense_sampling(ur5: Robot, seed: int) -> None:
    rng = np.random.default_rng(seed)
    waypoints = rng.uniform(-1.5, 1.5, (4, 6))
    trajectory = clamped_cubic(waypoints, rng.uniform(0.3, 0.8, 3))
    limits = Limits(cartesian_speed=(("tool0", 2.0), ("forearm_link", 1.0)), position=np.inf)
    verdict = audit(TrajectoryTask(waypoints, limits, robot=ur5), trajectory)
    times = np.linspace(0, trajectory.duration, 40_001)
    for frame, limit in limits.cartesian_speed:
        velocity = np.array(ur5.symbolic.velocity(frame)(trajectory(times).T, trajectory(times, 1).T))
        speeds = np.linalg.norm(velocity, axis=0)
        peak = verdict.limits[f"cartesian_speed:{frame}"]
        assert peak.ratio >= speeds.max() / limit - 1e-9
        assert peak.ratio == pytest.approx(speeds.max() / limit, rel=1e-6)
        assert peak.time == pytest.approx(times[np.argmax(speeds)], abs=1e-3)
        assert (peak.joint, peak.label) == (-1, frame)


def test_a_broken_cartesian_speed_is_named(ur5: Robot) -> None:
    # only the first joint turns: the tool moves on a circle about its axis
    robot = ur5
    waypoints = np.zeros((2, 6))
    waypoints[1, 0] = 1.0
    trajectory = clamped_cubic(waypoints, np.array([1.0]))
    reach = np.linalg.norm(robot.pose(waypoints[0], "tool0")[:2, 3])
    limits = Limits(cartesian_speed=(("tool0", 0.5),), velocity=9.0)
    verdict = audit(TrajectoryTask(waypoints, limits, robot=robot), trajectory)
    peak = verdict.limits["cartesian_speed:tool0"]
    assert peak.value == pytest.approx(1.5 * reach, rel=1e-9)
    assert peak.to_json()["joint"] is None
    assert peak.to_json()["label"] == "tool0"
    assert any(finding.startswith("cartesian speed tool0: gap 1, at 0.5 s: ") for finding in verdict.findings)
    assert verdict.smallest_feasible_scale is not None
    assert verdict.smallest_feasible_scale >= 1.5 * reach / 0.5 * (1 - 1e-9)


def test_cartesian_speed_needs_a_robot() -> None:
    task = TrajectoryTask([[0.0], [1.0]], Limits(cartesian_speed=(("tool0", 1.0),)))
    with pytest.raises(InputError, match=r"limits\.cartesian_speed needs a robot"):
        audit(task, clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0])))


def symbols(n: int) -> list[ca.SX]:
    return [ca.SX.sym(name, n) for name in ("q", "v", "a", "tau")]


def test_a_users_constraint_sees_position_velocity_acceleration_and_torque(tmp_path: Path) -> None:
    q, v, a, tau = symbols(1)
    trajectory = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    function = ca.Function("f", [q, v, a, tau], [ca.vertcat(q, 2 * v, 3 * a, tau)])
    constraint = CustomConstraint("all", function, lower=[-1, -1, -np.inf, -1], upper=[4.0, 6.0, 9.0, 20.0])
    task = TrajectoryTask(
        [[0.0], [1.0]], Limits(velocity=9.0), robot=pendulum(tmp_path), constraints=(constraint,)
    )
    peak = audit(task, trajectory).limits["constraint:all"]
    # 3 a is 18 at the start, 9 above its bound; the scale is the largest finite bound, 20
    assert peak.ratio == pytest.approx(1 + 9.0 / 20.0)
    assert (peak.value, peak.bound, peak.time) == (pytest.approx(18.0), 9.0, 0.0)
    only_torque = CustomConstraint("tau", ca.Function("f", [q, v, a, tau], [tau]), upper=10.0, scale=1.0)
    peak = audit(task.changed(constraints=(only_torque,)), trajectory).limits["constraint:tau"]
    assert peak.value == pytest.approx(9.81 + 6 * INERTIA)
    assert peak.ratio == pytest.approx(1 + peak.value - 10.0)


def test_without_inertia_a_constraint_gets_no_torque() -> None:
    q, v, a, tau = symbols(1)
    constraint = CustomConstraint("tau", ca.Function("f", [q, v, a, tau], [tau]), lower=-1.0, upper=1.0)
    task = TrajectoryTask([[0.0], [1.0]], constraints=(constraint,))
    verdict = audit(task, clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0])))
    assert verdict.feasible
    assert verdict.limits["constraint:tau"].value == 0.0


def test_a_constraint_with_a_kink_is_met_exactly() -> None:
    # the largest of min(q, 1 - q) is 1/2, at the kink in the middle
    q, v, a, tau = symbols(1)
    constraint = CustomConstraint("kink", ca.Function("f", [q, v, a, tau], [ca.fmin(q, 1 - q)]), upper=0.25)
    task = TrajectoryTask([[0.0], [1.0]], constraints=(constraint,))
    trajectory = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    verdict = audit(task, trajectory)
    assert verdict.limits["constraint:kink"].value == pytest.approx(0.5, abs=1e-8)
    assert verdict.findings == ("constraint kink: gap 1, at 0.5 s: 0.5 against 0.25",)


def test_a_constraint_that_is_no_number_is_broken() -> None:
    q, v, a, tau = symbols(1)
    constraint = CustomConstraint("root", ca.Function("f", [q, v, a, tau], [ca.sqrt(q - 0.5)]), upper=5.0)
    task = TrajectoryTask([[0.0], [1.0]], constraints=(constraint,))
    verdict = audit(task, clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0])))
    assert not verdict.feasible
    assert verdict.limits["constraint:root"].ratio == np.inf
    assert verdict.smallest_feasible_scale is None


def test_curves_that_cannot_be_resolved_are_not_called_feasible(
    ur5: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(chebyshev, "_MAX_SEGMENTS", 0)
    q, v, a, tau = symbols(6)
    wave = CustomConstraint("wave", ca.Function("f", [q, v, a, tau], [ca.sin(9 * q[0])]), upper=2.0)
    waypoints = np.stack([np.zeros(6), np.full(6, 30.0)])
    limits = Limits(position=np.inf, torque=np.inf, cartesian_speed=(("tool0", 10.0),))
    task = TrajectoryTask(waypoints, limits, robot=ur5, constraints=(wave,))
    verdict = audit(task, clamped_cubic(waypoints, np.array([100.0])))
    assert not verdict.feasible
    assert verdict.findings == (
        "cartesian speed tool0: could not be resolved between samples",
        "constraint wave: could not be resolved between samples",
    )


def test_a_function_of_something_else_is_an_error() -> None:
    q = ca.SX.sym("q")
    constraint = CustomConstraint("wrong", ca.Function("f", [q], [q]))
    task = TrajectoryTask([[0.0], [1.0]], constraints=(constraint,))
    with pytest.raises(InputError, match="a custom function cannot be called with q, v, a, tau of 1 joints"):
        audit(task, clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0])))


def test_bounds_that_do_not_fit_are_an_error() -> None:
    q, v, a, tau = symbols(1)
    constraint = CustomConstraint(
        "two", ca.Function("f", [q, v, a, tau], [ca.vertcat(q, v)]), upper=[1.0, 2.0, 3.0]
    )
    task = TrajectoryTask([[0.0], [1.0]], constraints=(constraint,))
    with pytest.raises(InputError, match="constraint two: has 2 values, its bounds do not fit"):
        audit(task, clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0])))
