"""Kinematic limits: exact extrema against brute force, jumps, limits by gap and by side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PPoly

from helpers.audit_motions import clamped_cubic, random_pieces, random_spline
from ocp_traj.audit import audit
from ocp_traj.audit.kinematics import changes_of, kinematic_peaks
from ocp_traj.audit.motion import Motion
from ocp_traj.audit.numerics.polynomials import candidate_points, evaluate, roots_in_unit_interval
from ocp_traj.quantities import DERIVATIVES
from ocp_traj.task import Boundary, Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory


def brute_force(trajectory: Trajectory, order: int, samples: int = 60) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return values of a derivative by joint: at SciPy's roots of the next one, at ends and at many samples.

    Each entry holds values and their pieces.
    """
    pieces = len(trajectory.breakpoints) - 1
    fractions = np.linspace(0.0, 1.0, samples)
    local = np.diff(trajectory.breakpoints)[:, None] * fractions
    found = []
    for joint in range(trajectory.n):
        descending = trajectory.coefficients[:, joint, ::-1].T
        curve = PPoly(descending, trajectory.breakpoints).derivative(order)
        values = [np.polyval(curve.c[:, piece], local[piece]) for piece in range(pieces)]
        index = [np.full(samples, piece) for piece in range(pieces)]
        roots = curve.derivative().roots(discontinuity=False, extrapolate=False)
        roots = roots[np.isfinite(roots)]
        at = np.clip(np.searchsorted(trajectory.breakpoints, roots, side="right") - 1, 0, pieces - 1)
        values.append(curve(roots))
        index.append(at)
        found.append((np.concatenate(values), np.concatenate(index)))
    return found


def random_limits(rng: np.random.Generator, trajectory: Trajectory) -> dict[str, np.ndarray]:
    """Return asymmetric limits of the motion's order of size, different in each gap."""
    gaps = len(trajectory.waypoint_times) - 1
    limits = {}
    for order, name in enumerate(DERIVATIVES):
        samples = trajectory(np.linspace(0, trajectory.duration, 50), order)
        size = np.abs(samples).max(axis=0) + 1e-300
        block = rng.uniform(0.3, 2.0, (gaps, 2, trajectory.n)) * size
        block[:, 0] *= -1.0
        limits[name] = block
    return limits


def compare_with_brute_force(trajectory: Trajectory, seconds: float, rng: np.random.Generator) -> None:
    limits = random_limits(rng, trajectory)
    waypoints = np.zeros((len(trajectory.waypoint_times), trajectory.n))
    scaled_limits = {name: limits[name] / seconds**order for order, name in enumerate(DERIVATIVES)}
    task = TrajectoryTask(waypoints, Limits(**scaled_limits))
    motion = Motion.of(trajectory.scaled(seconds))
    nothing = np.zeros((len(motion.starts), motion.n), dtype=bool)
    strict = replace(changes_of(task, motion), forgiven=(nothing,) * 3)
    peaks = {(peak.limit, peak.joint): peak for peak in kinematic_peaks(task, motion, strict)}
    assert len(peaks) == 4 * trajectory.n
    gaps = Motion.of(trajectory).gaps
    for order, name in enumerate(DERIVATIVES):
        for joint, (values, pieces) in enumerate(brute_force(trajectory, order)):
            lower, upper = limits[name][gaps[pieces], :, joint].T
            if order == 0:
                expected = (1 + np.maximum(lower - values, values - upper) / (upper - lower)).max()
            else:
                expected = np.where(values >= 0, values / upper, values / lower).max()
            peak = peaks[name, joint]
            assert peak.ratio == pytest.approx(expected, rel=1e-9, abs=1e-12)
            here = trajectory.scaled(seconds)
            assert 0 <= peak.time <= here.duration * (1 + 1e-12)


def random_motion(rng: np.random.Generator) -> Trajectory:
    n, count = int(rng.integers(1, 4)), int(rng.integers(1, 7))
    if rng.random() < 0.5:
        return random_spline(rng, int(rng.choice([3, 5, 7])), n, count)
    return random_pieces(rng, int(rng.integers(1, 9)), n, count)


@pytest.mark.parametrize("block", range(5))
def test_extrema_agree_with_brute_force(block: int) -> None:
    rng = np.random.default_rng(block)
    for _ in range(60):
        compare_with_brute_force(random_motion(rng), 10.0 ** rng.uniform(-6, 5), rng)


@pytest.mark.parametrize(
    "block",
    [pytest.param(block, marks=pytest.mark.slow if block < 8 else pytest.mark.long) for block in range(20)],
)
def test_extrema_agree_with_brute_force_on_ten_thousand_splines(block: int) -> None:
    rng = np.random.default_rng(1000 + block)
    for _ in range(500):
        compare_with_brute_force(random_motion(rng), 10.0 ** rng.uniform(-6, 5), rng)


def test_roots_are_found_whatever_the_leading_coefficients() -> None:
    roots = np.array([0.1, 0.5, 0.7])
    cubic = np.polynomial.polynomial.polyfromroots(roots)
    for tiny in (0.0, 1e-300, 1e-18, -1e-18, 1e-12):
        points = roots_in_unit_interval(np.array([[*cubic, 0.0, tiny]]))[0]
        for root in roots:
            assert np.abs(points - root).min() < 1e-10


def test_a_double_root_neither_hides_nor_invents_an_extremum() -> None:
    # (x - 1/2)^2 is the derivative of a curve that is monotone: its extrema are its ends
    curve = np.array([[0.0, 0.25, -0.5, 1.0 / 3.0]])
    points = candidate_points(curve, 1)[0]
    values = evaluate(curve, points)
    assert values.max() == pytest.approx(1.0 / 12.0)
    assert values.min() == 0.0


def test_a_limit_broken_only_between_samples_is_refused() -> None:
    # a bump of 0.8 ms between two samples of a 1 kHz file: position moves by a micrometre, velocity exceeds by far
    bump = 1e-5 * 4**4 * np.polynomial.polynomial.polypow([0, 1, -1], 4)  # C3, height 1e-5 at x = 1/2
    width = 8e-4
    rest = np.zeros((1, 9))
    coefficients = np.array([rest, [bump / width ** np.arange(9.0)], rest])
    breakpoints = np.array([0.0, 0.5001, 0.5009, 1.0])
    quiet = Trajectory(breakpoints, coefficients, [0.0, 1.0])
    moving = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    base = np.zeros((3, 1, 9))
    for k, start in enumerate(breakpoints[:-1]):
        base[k, 0, :4] = [moving(start, order)[0] / [1, 1, 2, 6][order] for order in range(4)]
    trajectory = Trajectory(breakpoints, quiet.coefficients + base, [0.0, 1.0])
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=1.51))
    samples = trajectory(np.arange(1001) / 1000.0, 1)
    assert np.abs(samples).max() < 1.51
    assert audit(task, moving).feasible
    verdict = audit(task, trajectory)
    assert not verdict.feasible
    assert verdict.worst is not None
    assert verdict.worst.limit == "velocity"
    assert 0.5001 < verdict.worst.time < 0.5009
    assert "velocity: joint 1, gap 1, at 0.500" in verdict.findings[0]


def test_limits_may_differ_by_gap() -> None:
    trajectory = clamped_cubic(np.array([[0.0], [1.0], [2.0]]), np.array([1.0, 1.0]))
    limits = np.array([[[-2.0], [2.0]], [[-1.0], [1.0]]])
    verdict = audit(TrajectoryTask([[0.0], [1.0], [2.0]], Limits(velocity=limits)), trajectory)
    peak = verdict.limits["velocity"]
    assert (peak.gap, peak.ratio) == (1, pytest.approx(1.5))
    assert verdict.findings == (
        "velocity: joint 1, gap 2, at 1 s: 1.5 against 1 rad/s (m/s), 1.5 times the limit",
    )


def test_each_side_has_its_own_limit() -> None:
    there = clamped_cubic(np.array([[0.0], [1.0]]), np.array([1.0]))
    limits = Limits(velocity=[[-1.0], [2.0]], acceleration=[[-12.0], [6.0]])
    verdict = audit(TrajectoryTask([[0.0], [1.0]], limits), there)
    assert verdict.limits["velocity"].ratio == pytest.approx(0.75)
    assert verdict.limits["acceleration"].ratio == pytest.approx(1.0)
    back = Trajectory(there.breakpoints, -there.coefficients, there.waypoint_times)
    verdict = audit(TrajectoryTask([[0.0], [-1.0]], limits), back)
    assert verdict.limits["velocity"].ratio == pytest.approx(1.5)
    assert verdict.limits["velocity"].bound == -1.0


def test_a_position_ratio_is_one_plus_excess_over_the_width() -> None:
    # through 0, 1, 0 with equal times: the top is at the middle waypoint
    trajectory = clamped_cubic(np.array([[0.0], [1.0], [0.0]]), np.array([1.0, 1.0]))
    inside = audit(TrajectoryTask([[0.0], [1.0], [0.0]], Limits(position=[[-1.0], [3.0]])), trajectory)
    assert inside.limits["position"].ratio == pytest.approx(1.0 - 1.0 / 4.0)
    swing = clamped_cubic(np.array([[0.0], [1.0], [1.0], [0.0]]), np.array([1.0, 1.0, 1.0]))
    top = swing(1.5)[0]
    task = TrajectoryTask([[0.0], [1.0], [1.0], [0.0]], Limits(position=[[-1.0], [1.0]]))
    verdict = audit(task, swing)
    assert verdict.limits["position"].ratio == pytest.approx(1.0 + (top - 1.0) / 2.0)
    assert verdict.findings[0].startswith("position: joint 1, gap 2, at 1.5 s: 1.2")
    assert verdict.smallest_feasible_scale is None


def test_a_range_open_to_one_side_is_still_kept() -> None:
    swing = clamped_cubic(np.array([[0.0], [1.0], [1.0], [0.0]]), np.array([1.0, 1.0, 1.0]))
    task = TrajectoryTask([[0.0], [1.0], [1.0], [0.0]], Limits(position=[[-np.inf], [1.0]]))
    verdict = audit(task, swing)
    assert not verdict.feasible
    # the farthest waypoint is 1 away from the finite end
    assert verdict.limits["position"].ratio == pytest.approx(1.0 + swing(1.5)[0] - 1.0)


def test_a_zero_limit_holds_for_a_joint_that_does_not_move() -> None:
    waypoints = np.array([[0.0, 1.3], [1.0, 1.3], [0.5, 1.3]])
    trajectory = clamped_cubic(waypoints, np.array([0.3, 0.7]))
    noisy = trajectory.coefficients.copy()
    noisy[:, 1, 1] += 1e-16
    verdict = audit(
        TrajectoryTask(waypoints, Limits(velocity=[100.0, 0.0])),
        Trajectory(trajectory.breakpoints, noisy, trajectory.waypoint_times),
    )
    assert verdict.feasible
    noisy[:, 1, 1] += 1e-9
    verdict = audit(
        TrajectoryTask(waypoints, Limits(velocity=[100.0, 0.0])),
        Trajectory(trajectory.breakpoints, noisy, trajectory.waypoint_times),
    )
    assert not verdict.feasible
    assert verdict.limits["velocity"].ratio == np.inf
    assert verdict.to_json()["limits"]["velocity"]["ratio"] is None


def broken_at_middle(order: int, size: float) -> Trajectory:
    """Return 0 -> 1 -> 0 with a jump of one derivative in the middle."""
    trajectory = clamped_cubic(np.array([[0.0], [1.0], [0.0]]), np.array([1.0, 1.0]))
    coefficients = trajectory.coefficients.copy()
    coefficients[1, 0, order] += size / [1, 1, 2][order]
    return Trajectory(trajectory.breakpoints, coefficients, trajectory.waypoint_times)


@pytest.mark.parametrize(
    ("order", "limits", "broken"),
    [
        (0, {}, ["velocity"]),
        (0, {"velocity": 9.0, "jerk": 900.0}, ["jerk", "velocity"]),
        (1, {"velocity": 9.0}, []),
        (1, {"acceleration": 90.0}, ["acceleration"]),
        (1, {"jerk": 900.0}, ["jerk"]),
        (2, {"acceleration": 90.0}, []),
        (2, {"jerk": 900.0}, ["jerk"]),
    ],
)
def test_a_jump_makes_the_next_derivative_infinite(
    order: int, limits: dict[str, float], broken: list[str]
) -> None:
    task = TrajectoryTask([[0.0], [1.0], [0.0]], Limits(**limits), tolerance=1.0, boundary=Boundary())
    verdict = audit(task, broken_at_middle(order, 0.01))
    infinite = sorted(name for name, peak in verdict.limits.items() if peak.ratio == np.inf)
    assert infinite == broken
    sentences = [finding for finding in verdict.findings if "jumps" in finding]
    word = DERIVATIVES[order]
    assert sentences == [
        f"{name}: joint 1, gap 2, at 1 s: inf against {limits.get(name, np.inf):g} "
        f"{ {'velocity': 'rad/s (m/s)', 'acceleration': 'rad/s^2 (m/s^2)', 'jerk': 'rad/s^3 (m/s^3)'}[name] }"
        f", the {word} of joint 1 jumps by 0.01"
        for name in DERIVATIVES
        if name in broken
    ]


@pytest.mark.parametrize("order", [0, 1, 2])
def test_rounding_is_no_jump(order: int) -> None:
    task = TrajectoryTask(
        [[0.0], [1.0], [0.0]], Limits(velocity=9.0, acceleration=90.0, jerk=900.0), tolerance=1.0
    )
    verdict = audit(task, broken_at_middle(order, 1e-12))
    assert all(np.isfinite(peak.ratio) for peak in verdict.limits.values())


@pytest.mark.parametrize("seconds", [1e-6, 1e-3, 1.0, 1e5])
def test_ratios_do_not_depend_on_the_scale_of_time(seconds: float) -> None:
    rng = np.random.default_rng(3)
    trajectory = random_spline(rng, 7, 3, 5)
    waypoints = trajectory(trajectory.waypoint_times)
    one = audit(
        TrajectoryTask(waypoints, Limits(velocity=1.0, acceleration=1.0, jerk=1.0), family="septic"),
        trajectory,
    )
    limits = Limits(velocity=1 / seconds, acceleration=seconds**-2, jerk=seconds**-3)
    other = audit(TrajectoryTask(waypoints, limits, family="septic"), trajectory.scaled(seconds))
    for name in ("velocity", "acceleration", "jerk"):
        assert other.limits[name].ratio == pytest.approx(one.limits[name].ratio, rel=1e-9)
    assert other.boundary_error <= 1e-8
    assert other.waypoint_error <= 1e-8


def test_a_jump_is_placed_in_the_gap_that_follows_it() -> None:
    waypoints = np.array([[0.0], [1.0], [2.0], [3.0], [4.0]])
    trajectory = clamped_cubic(waypoints, np.ones(4))
    coefficients = np.pad(trajectory.coefficients, ((0, 0), (0, 0), (0, 2)))
    coefficients[2, 0] += [0.0, 0.0, 1.0, -3.0, 3.0, -1.0]  # x^2 (1 - x)^3: its acceleration ends at 0
    broken = Trajectory(trajectory.breakpoints, coefficients, trajectory.waypoint_times)
    verdict = audit(TrajectoryTask(waypoints, Limits(jerk=1e4), tolerance=9.0), broken)
    peak = verdict.limits["jerk"]
    assert (peak.ratio, peak.time, peak.gap) == (np.inf, 2.0, 2)
