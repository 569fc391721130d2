"""A feasible motion stays feasible however it is cut into pieces; one that turns round in no time never is."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from helpers.audit_motions import random_spline
from helpers.bounds_guard import unguarded
from ocp_traj.audit import Verdict
from ocp_traj.audit import audit as audit_with_bound
from ocp_traj.task import Boundary, Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory

NAMES = ("velocity", "acceleration", "jerk")


def audit(task: TrajectoryTask, motion: Trajectory) -> Verdict:
    """Judge without the certified bound that the tests hold verdicts against: it costs more than all else here."""
    with unguarded():
        return audit_with_bound(task, motion)


def riding_task(motion: Trajectory) -> TrajectoryTask:
    """Return a task whose limits the motion uses up to the last bit, with the ends it has."""
    loose = Limits(**dict.fromkeys(NAMES, 1e300))
    waypoints = motion(motion.waypoint_times)
    boundary = Boundary(velocity=motion(motion.breakpoints[[0, -1]], 1), acceleration=None)
    task = TrajectoryTask(waypoints, loose, boundary=boundary)
    peaks = audit(task, motion).peaks
    size = {name: np.array([peak.value for peak in peaks if peak.limit == name]) for name in NAMES}
    return task.changed(limits=Limits(**{name: np.abs(values) for name, values in size.items()}))


def cuts(rng: np.random.Generator, motion: Trajectory) -> np.ndarray:
    """Return random times inside a motion; some lie closely together, down to 1e-12 of the motion."""
    places = rng.uniform(0.0, motion.duration, int(rng.integers(1, 8)))
    base = rng.choice(np.concatenate([places, motion.breakpoints[:-1]]), int(rng.integers(1, 8)))
    close = base + motion.duration * 10.0 ** rng.uniform(-12, -3, base.size)
    times = np.concatenate([motion.breakpoints, places, close])
    times = np.unique(times[times <= motion.duration])
    apart = np.concatenate([[True], np.diff(times) >= 1e-12 * motion.duration])
    return np.union1d(times[apart], motion.breakpoints)


def cut(motion: Trajectory, times: np.ndarray, *, padding: int = 0, shift: float = 0.0) -> Trajectory:
    """Return the motion with pieces from `times` on, coefficients rounded once, padded, and started later."""
    pieces = np.searchsorted(motion.breakpoints, times[:-1], side="right") - 1
    coefficients = np.zeros((len(pieces), motion.n, motion.degree + 1 + padding))
    for row, (piece, time) in enumerate(zip(pieces, times)):
        step = Fraction(float(time)) - Fraction(float(motion.breakpoints[piece]))
        for joint in range(motion.n):
            old = [Fraction(float(value)) for value in motion.coefficients[piece, joint]]
            for i in range(len(old)):
                terms = (math.comb(k, i) * old[k] * step ** (k - i) for k in range(i, len(old)))
                coefficients[row, joint, i] = float(sum(terms))
    return Trajectory(times + shift, coefficients, motion.waypoint_times + shift, motion.family)


def random_cut_motion(rng: np.random.Generator) -> tuple[TrajectoryTask, Trajectory]:
    """Return a task and a motion that rides on its limits, cut, padded and shifted."""
    motion = random_spline(rng, int(rng.choice([3, 5, 7])), int(rng.integers(1, 3)), int(rng.integers(1, 5)))
    task = riding_task(motion)
    padding = int(rng.integers(0, 4))
    return task, cut(motion, cuts(rng, motion), padding=padding, shift=float(rng.choice([0.0, 1.0, 7.3])))


def check_cut_motions(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(count):
        task, motion = random_cut_motion(rng)
        verdict = audit(task, motion)
        assert verdict.feasible, verdict.findings


@pytest.mark.parametrize("seed", range(3))
def test_a_feasible_motion_may_be_cut_anywhere(seed: int) -> None:
    check_cut_motions(seed, 30)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 120))
def test_ten_thousand_feasible_motions_may_be_cut_anywhere(seed: int) -> None:
    check_cut_motions(seed, 500)


@pytest.mark.parametrize("seed", range(3))
def test_a_change_hidden_in_a_short_piece_is_seen(seed: int) -> None:
    """One derivative of one joint gets another value at once, by a ramp or a jump, between two short pieces."""
    rng = np.random.default_rng(seed)
    for _ in range(30):
        task, motion = random_cut_motion(rng)
        piece, joint = int(rng.integers(1, len(motion.breakpoints) - 1)), int(rng.integers(motion.n))
        order = int(rng.integers(0, 3))
        size = 1e-9 if order == 0 else [1e-8, 1e-6][order - 1] * task.limits.get(NAMES[order - 1])[0, 1, joint]
        coefficients = motion.coefficients.copy()
        coefficients[piece:, joint, order] += 1.5 * size / [1, 1, 2][order]
        assert not audit(task, replace(motion, coefficients=coefficients)).feasible
