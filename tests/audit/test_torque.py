"""Torque and torque rate at every time: against very dense sampling and Pinocchio's derivatives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from helpers.audit_motions import INERTIA, clamped_cubic, pendulum
from ocp_traj.audit import audit
from ocp_traj.audit.motion import Motion
from ocp_traj.audit.numerics import chebyshev
from ocp_traj.audit.torque import relative_bound, torque_curve
from ocp_traj.exceptions import InputError
from ocp_traj.robot import Robot, load_robot
from ocp_traj.robot.additions import Friction
from ocp_traj.task import Boundary, Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory


@pytest.fixture(scope="module")
def ur5() -> Robot:
    return load_robot("ur5")


@pytest.fixture(scope="module")
def rubbing_ur5(ur5: Robot) -> Robot:
    return ur5.with_changes(friction=Friction(np.full(6, 0.5), np.array([1.0, 2.0, 0.0, 1.0, 0.5, 1.0])))


def random_task(robot: Robot, seed: int, **limits: object) -> tuple[TrajectoryTask, Trajectory]:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 7))
    waypoints = rng.uniform(-2.0, 2.0, (count, robot.n))
    trajectory = clamped_cubic(waypoints, rng.uniform(0.2, 0.8, count - 1))
    return TrajectoryTask(waypoints, Limits(position=np.inf, **limits), robot=robot), trajectory  # type: ignore[arg-type]


def dense_times(trajectory: Trajectory, samples: int = 4001) -> tuple[np.ndarray, np.ndarray]:
    """Return times inside each piece, the ends included, and the piece of each."""
    h = np.diff(trajectory.breakpoints)
    fractions = np.linspace(1e-12, 1 - 1e-12, samples)
    pieces = np.repeat(np.arange(len(h)), samples)
    return (trajectory.breakpoints[:-1, None] + h[:, None] * fractions).ravel(), pieces


def states(trajectory: Trajectory, times: np.ndarray, pieces: np.ndarray) -> list[np.ndarray]:
    """Evaluate inside given pieces, so that ends are one-sided."""
    local = (times - trajectory.breakpoints[pieces])[:, None]
    found = []
    for order in range(4):
        coefficients = trajectory.derivative_coefficients(order)[pieces]
        found.append(sum(coefficients[:, :, k] * local**k for k in range(coefficients.shape[2])))
    return found


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("friction", [False, True])
def test_torque_peaks_agree_with_dense_sampling(
    ur5: Robot, rubbing_ur5: Robot, seed: int, friction: bool
) -> None:
    robot = rubbing_ur5 if friction else ur5
    task, trajectory = random_task(
        robot, seed, torque=[[-90, -100, -90, -9, -8, -7], [100, 80, 90, 8, 9, 10]]
    )
    times, pieces = dense_times(trajectory)
    q, v, a, _ = states(trajectory, times, pieces)
    torques = robot.torque(q, v, a)
    lower, upper = task.limits.get("torque")[0]
    ratios = np.where(torques >= 0, torques / upper, torques / lower)
    verdict = audit(task, trajectory)
    peak = verdict.limits["torque"]
    assert peak.ratio >= ratios.max() - 1e-9
    assert peak.ratio == pytest.approx(ratios.max(), rel=2e-6)
    assert peak.joint == np.argmax(ratios.max(axis=0))
    assert peak.time == pytest.approx(times[np.argmax(ratios.max(axis=1))], abs=1e-3)
    assert verdict.torque_bound < 1e-8


@pytest.mark.parametrize("seed", range(3))
def test_the_stated_bound_holds(ur5: Robot, seed: int) -> None:
    task, trajectory = random_task(ur5, seed)
    curve = torque_curve(task, Motion.of(trajectory))
    times, pieces = dense_times(trajectory, 501)
    q, v, a, _ = states(trajectory, times, pieces)
    x = (times - trajectory.breakpoints[pieces]) / np.diff(trajectory.breakpoints)[pieces]
    segment, theta = curve.curve.locate(pieces, x)
    basis = np.cos(np.multiply.outer(theta, np.arange(curve.curve.coefficients.shape[2])))
    interpolated = np.einsum("sjk,sk->sj", curve.coefficients()[segment], basis)
    limit = task.limits.get("torque")[0, 1]
    error = (np.abs(interpolated - ur5.torque(q, v, a)) / limit).max()
    assert error <= max(relative_bound(task, curve), 1e-12)


def exact_rates(robot: Robot, q: np.ndarray, v: np.ndarray, a: np.ndarray, j: np.ndarray) -> np.ndarray:
    """Return d tau / dt = dtau/dq v + dtau/dv a + M j by Pinocchio's derivatives."""
    data = robot.model.createData()
    rates = np.empty_like(q)
    for row in range(len(q)):
        pin.computeRNEADerivatives(robot.model, data, q[row], v[row], a[row])
        inertia = np.triu(data.M) + np.triu(data.M, 1).T
        rates[row] = data.dtau_dq @ v[row] + data.dtau_dv @ a[row] + inertia @ j[row]
    return rates + robot.friction.viscous * a


@pytest.mark.parametrize("seed", range(3))
def test_torque_rate_peaks_agree_with_exact_derivatives(rubbing_ur5: Robot, seed: int) -> None:
    task, trajectory = random_task(rubbing_ur5, seed, torque=np.inf, torque_rate=[900, 1000, 800, 90, 90, 80])
    times, pieces = dense_times(trajectory, 1001)
    rates = exact_rates(rubbing_ur5, *states(trajectory, times, pieces))
    ratios = np.abs(rates) / task.limits.get("torque_rate")[0, 1]
    peak = audit(task, trajectory).limits["torque_rate"]
    assert peak.ratio >= ratios.max() * (1 - 1e-7)
    assert peak.ratio == pytest.approx(ratios.max(), rel=1e-4)
    assert peak.joint == np.argmax(ratios.max(axis=0))


def test_a_torque_limit_broken_only_between_samples_is_refused(ur5: Robot) -> None:
    # the torque peak of a fast motion lies inside a piece; the limit is a hair below it
    task, trajectory = random_task(ur5, 11)
    times, pieces = dense_times(trajectory, 20001)
    q, v, a, _ = states(trajectory, times, pieces)
    torques = np.abs(ur5.torque(q, v, a))
    inner = (times - trajectory.breakpoints[pieces]) / np.diff(trajectory.breakpoints)[pieces]
    middle = (inner > 0.05) & (inner < 0.95)
    joint = int(np.argmax(torques[middle].max(axis=0) >= torques.max(axis=0) * (1 - 1e-12)))
    assert torques[middle, joint].max() == torques[:, joint].max()
    limits = np.full(6, np.inf)
    limits[joint] = torques[:, joint].max() * (1 - 2e-6)
    coarse = np.abs(ur5.torque(*states(trajectory, *dense_times(trajectory, 12))[:3]))
    assert coarse[:, joint].max() < limits[joint]
    verdict = audit(task.changed(limits=Limits(position=np.inf, velocity=np.inf, torque=limits)), trajectory)
    assert not verdict.feasible
    assert verdict.findings[0].startswith(f"torque: joint {joint + 1}, gap ")


def test_a_pendulum_has_its_hand_computed_torques(tmp_path: Path) -> None:
    # without gravity tau = I a: I = 0.6 kg m^2, a = 6 rad/s^2 at the ends of a unit cubic over 1 s
    robot = pendulum(tmp_path, gravity=0.0)
    trajectory = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    task = TrajectoryTask([[0.0], [1.0]], Limits(torque=7.2, torque_rate=14.4), robot=robot)
    verdict = audit(task, trajectory)
    assert verdict.limits["torque"].ratio == pytest.approx(INERTIA * 6.0 / 7.2)
    assert verdict.limits["torque_rate"].ratio == pytest.approx(INERTIA * 12.0 / 14.4)


def test_coulomb_friction_counts_on_both_sides_of_a_reversal(tmp_path: Path) -> None:
    # there and back: the velocity turns round at 1 s, where a = -6; friction 2 N m helps after it, hurts before it
    robot = pendulum(tmp_path, gravity=0.0, coulomb=2.0)
    waypoints = np.array([[0.0], [1.0], [0.0]])
    trajectory = clamped_cubic(waypoints, np.array([1.0, 1.0]))
    verdict = audit(TrajectoryTask(waypoints, Limits(torque=[[-6.0], [100.0]]), robot=robot), trajectory)
    peak = verdict.limits["torque"]
    assert peak.value == pytest.approx(-INERTIA * 6.0 - 2.0)
    assert peak.time == pytest.approx(1.0)
    verdict = audit(TrajectoryTask(waypoints, Limits(torque=[[-100.0], [6.0]]), robot=robot), trajectory)
    assert verdict.limits["torque"].value == pytest.approx(INERTIA * 6.0 + 2.0)
    assert verdict.limits["torque"].time == pytest.approx(0.0, abs=1e-12)


def test_a_still_joint_feels_no_coulomb_friction(tmp_path: Path) -> None:
    robot = pendulum(tmp_path, gravity=0.0, coulomb=2.0)
    still = clamped_cubic(np.array([[0.5], [0.5]]), np.array([1.0]))
    verdict = audit(TrajectoryTask([[0.5], [0.5]], Limits(torque=1.0), robot=robot), still)
    assert verdict.limits["torque"].ratio == pytest.approx(0.0, abs=1e-12)


def test_an_acceleration_jump_breaks_a_torque_rate_limit(tmp_path: Path) -> None:
    robot = pendulum(tmp_path)
    # bang-bang: 4 then -4 rad/s^2
    trajectory = Trajectory([0.0, 0.5, 1.0], [[[0.0, 0.0, 2.0]], [[0.5, 2.0, -2.0]]], [0.0, 1.0])
    torque_only = audit(TrajectoryTask([[0.0], [1.0]], Limits(torque=100.0), robot=robot), trajectory)
    assert torque_only.feasible
    both = audit(
        TrajectoryTask([[0.0], [1.0]], Limits(torque=100.0, torque_rate=1e6), robot=robot), trajectory
    )
    assert not both.feasible
    assert both.findings == (
        "torque rate: joint 1, gap 1, at 0.5 s: inf against 1000000 N m/s (N/s), "
        "the acceleration of joint 1 jumps by 8",
    )


def test_torque_limits_may_differ_by_gap(tmp_path: Path) -> None:
    robot = pendulum(tmp_path, gravity=0.0)
    waypoints = np.array([[0.0], [1.0], [2.0]])
    trajectory = clamped_cubic(waypoints, np.array([1.0, 1.0]))
    limits = np.array([[[-4.0], [4.0]], [[-1.0], [1.0]]])
    verdict = audit(TrajectoryTask(waypoints, Limits(torque=limits), robot=robot), trajectory)
    assert verdict.limits["torque"].gap == 1
    assert verdict.limits["torque"].ratio == pytest.approx(INERTIA * 3.0)


def test_what_cannot_be_resolved_is_not_called_feasible(ur5: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    # one long piece: several turns of every joint, far too much for one interpolant
    waypoints = np.stack([np.zeros(6), np.full(6, 30.0)])
    trajectory = clamped_cubic(waypoints, np.array([100.0]))
    task = TrajectoryTask(waypoints, Limits(position=np.inf), robot=ur5)
    assert audit(task, trajectory).feasible
    monkeypatch.setattr(chebyshev, "_MAX_SEGMENTS", 0)
    verdict = audit(task, trajectory)
    assert not verdict.feasible
    assert verdict.torque_bound > 1e-7
    assert verdict.findings[0].startswith("torque: could only be bounded to ")
    assert verdict.smallest_feasible_scale is None


def test_torques_need_inertia() -> None:
    trajectory = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    with pytest.raises(InputError, match="torques need a robot with inertia"):
        torque_curve(TrajectoryTask([[0.0], [1.0]]), Motion.of(trajectory))


def test_many_short_pieces_have_the_torques_of_the_whole(ur5: Robot) -> None:
    task, trajectory = random_task(ur5, 3)
    cuts = np.unique(np.concatenate([np.linspace(0, trajectory.duration, 301), trajectory.breakpoints]))
    orders = [trajectory(cuts[:-1], order) / [1, 1, 2, 6][order] for order in range(4)]
    cut = Trajectory(cuts, np.stack(orders, axis=2), trajectory.waypoint_times)
    whole, parts = audit(task, trajectory).limits["torque"], audit(task, cut).limits["torque"]
    assert parts.ratio == pytest.approx(whole.ratio, rel=1e-9)
    assert parts.joint == whole.joint


def vanishing_at(points: np.ndarray, seconds: float) -> np.ndarray:
    """Return powers of t whose second derivative is 0 at these points of [-1, 1] and reaches 100 between them."""
    bump = np.polynomial.polynomial.polyfromroots(0.5 + 0.5 * points)
    bump *= 100.0 / np.abs(np.polynomial.polynomial.polyval(np.linspace(0, 1, 20_001), bump)).max()
    q = np.polynomial.polynomial.polyint(bump, 2)
    return q * seconds ** (2.0 - np.arange(q.size))


@pytest.mark.parametrize("count", [1, 70])
def test_an_acceleration_that_vanishes_at_all_samples_is_not_overlooked(tmp_path: Path, count: int) -> None:
    """A polynomial can have its roots at all nodes and checks; in a short piece gravity does not betray it."""
    seconds, hidden = 1e-4, count // 2
    nodes = chebyshev.NODES[:: 2 if count > 64 else 1]
    bump = vanishing_at(np.concatenate([nodes, chebyshev.CHECKS]), seconds)
    times = np.arange(count + 1.0) * seconds
    pieces = np.zeros((count, 1, bump.size))
    q, v = 0.3, 0.0
    for piece in range(count):
        pieces[piece, 0, :2] = q, v
        pieces[piece, 0] += bump * (piece == hidden)
        curve = np.polynomial.Polynomial(pieces[piece, 0])
        q, v = curve(seconds), curve.deriv()(seconds)
    trajectory = Trajectory(times, pieces, times[[0, -1]])
    ends = times[[0, -1]]
    boundary = Boundary(velocity=trajectory(ends, 1), acceleration=None)
    limits = Limits(velocity=np.inf, position=np.inf, torque=11.0)
    task = TrajectoryTask(trajectory(ends), limits, robot=pendulum(tmp_path), boundary=boundary)
    inside = np.linspace(times[hidden], times[hidden + 1] * (1 - 1e-9), 9999)
    states_inside = [trajectory(inside, order) for order in range(3)]
    seen = np.abs(pendulum(tmp_path).torque(*states_inside)).max()
    assert seen > 40.0
    assert audit(task, trajectory).limits["torque"].ratio == pytest.approx(seen / 11.0, rel=1e-4)
