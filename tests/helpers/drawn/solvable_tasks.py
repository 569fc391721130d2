"""Random tasks that have a motion by construction: the limits are drawn around a motion of the task's own family."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import TaskError
from ocp_traj.quantities import RATES
from ocp_traj.solvers.gradient.along_chords import hermite_curve
from ocp_traj.solvers.gradient.starts import random_factors
from ocp_traj.spline import FAMILIES
from ocp_traj.task import Boundary, Limits, Objective, TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.curve import build_trajectory
from ocp_traj.transcription.guess import closed_form_durations, initial_guess

SAMPLES = 400
"""Samples per segment of the motion that limits are drawn around."""

TIGHTEST = 1.02
"""Limits are at least this far from the motion."""


@dataclass(frozen=True)
class SolvableTask:
    """A task, a motion that keeps its limits, and the words for what is unusual about it."""

    task: TrajectoryTask
    witness: Trajectory
    kinds: tuple[str, ...]


def solvable_task(seed: int) -> SolvableTask:
    """Return a task of any family: 0 to 5 knots, 1 to 7 joints, 2 to 8 waypoints, sizes and paces over six decades."""
    for attempt in range(100):
        rng = np.random.default_rng([17, seed, attempt])
        try:
            return _draw(rng, f"solvable-{seed}")
        except TaskError:  # too few free coefficients for the conditions drawn
            continue
    raise AssertionError(f"no task from seed {seed}")


def _draw(rng: np.random.Generator, name: str) -> SolvableTask:
    family = str(rng.choice(sorted(FAMILIES)))
    knots = {"cubic": int(rng.integers(0, 6)), "3-5-3": 0}.get(family, int(rng.choice([0, 0, 0, 1, 2, 3, 5])))
    n, count = int(rng.integers(1, 8)), int(rng.integers(4 if family == "3-5-3" else 2, 9))
    kinds: list[str] = []
    waypoints = _waypoints(rng, n, count, kinds)
    pace = 10.0 ** rng.uniform(-3, 3)
    size = np.abs(waypoints).max(axis=0)
    moves = rng.random() < 0.25 and family != "3-5-3"
    velocity = np.zeros((2, n))
    if moves:
        kinds.append("moving end")
        sides = [[0], [1], [0, 1]][int(rng.integers(3))]
        velocity[sides] = rng.uniform(-1, 1, (len(sides), n)) * size * pace
        velocity[:, np.ptp(waypoints, axis=0) == 0] = 0.0
    task = TrajectoryTask(
        waypoints, Limits(), family=family, virtual_knots=knots, boundary=Boundary(velocity), name=name
    )
    witness = _witness(rng, task, pace)
    weights: dict[str, Any] = {"time": 1.0}
    if rng.random() < 0.15:
        kinds.append("smoothness")
        order = int(rng.integers(2, 4))
        term = {2: "acceleration", 3: "jerk"}[order]
        weights[term] = 10.0 ** rng.uniform(-3, 3) / float((size**2).sum()) * pace ** (1 - 2 * order)
    bounds = _duration_bounds(rng, witness, kinds)
    tolerance = 0.0
    if rng.random() < 0.15:
        kinds.append("tolerance")
        tolerance = np.abs(np.diff(waypoints, axis=0)).max(axis=0) * 10.0 ** rng.uniform(-4, -1.5)
    task = task.changed(
        limits=_limits(rng, task, witness, kinds), objective=Objective(**weights, **bounds), tolerance=tolerance
    )
    return SolvableTask(task, witness, tuple(kinds))


def _waypoints(rng: np.random.Generator, n: int, count: int, kinds: list[str]) -> Array:
    size = 10.0 ** (rng.uniform(-3, 3) + rng.uniform(-1, 1, n))
    if rng.random() < 0.4:
        kinds.append("one way")
        passed = np.concatenate([[0.0], np.sort(rng.uniform(0.03, 0.97, count - 2)), [1.0]])[:, None]
        points = passed * rng.choice([-1.0, 1.0], n) * rng.uniform(0.5, 1.0, n)
        points = points + 0.05 * rng.standard_normal((count, n)) * passed * (1.0 - passed)
    else:
        points = rng.uniform(-1, 1, (count, n))
    if n > 1 and rng.random() < 0.2:
        kinds.append("still joint")
        points[:, int(rng.integers(n))] = 0.5
    if count > 2 and rng.random() < 0.1:
        kinds.append("duplicate")
        place = int(rng.integers(1, count))
        points[place] = points[place - 1]
    return np.asarray(points * size)


def _witness(rng: np.random.Generator, task: TrajectoryTask, pace: float) -> Trajectory:
    """Return a spline through the waypoints at random times, its virtual knots near a smooth curve."""
    gaps, per_gap = task.gaps, task.virtual_knots + 1
    ranges = np.ptp(task.waypoints, axis=0)
    travel = np.abs(np.diff(task.waypoints, axis=0)) / np.where(ranges > 0, ranges, 1.0)
    durations = (0.2 + travel.max(axis=1)) * rng.uniform(0.7, 1.3, gaps) / pace
    bare = task.changed(virtual_knots=0, boundary=Boundary(task.boundary.velocity))
    curve = build_trajectory(bare, durations, np.asarray(task.waypoints))
    share = np.repeat(durations / per_gap, per_gap) * rng.uniform(0.9, 1.1, gaps * per_gap)
    share *= np.repeat(durations / share.reshape(gaps, per_gap).sum(axis=1), per_gap)
    knots = np.concatenate([[0.0], np.cumsum(share)])
    positions = np.array(curve(knots))
    positions[::per_gap] = task.waypoints
    return build_trajectory(task, share, positions)


def _limits(rng: np.random.Generator, task: TrajectoryTask, witness: Trajectory, kinds: list[str]) -> Limits:
    """Return limits that the witness keeps: some close to it, some decades away, some left out, some per gap."""
    extremes = {order: _extremes(task, witness, order) for order in range(4)}
    limits: dict[str, Array] = {}
    for order, name in enumerate(RATES, start=1):
        if rng.random() < (0.15, 0.25, 0.5)[order - 1] and len(limits) + 3 - order > 0:
            continue
        room = TIGHTEST + (10.0 ** rng.uniform(-1.5, rng.choice([0.5, 3.0])))
        low, high = extremes[order]
        if rng.random() < 0.3:
            kinds.append(f"{name} per gap")
        else:
            low, high = np.tile(low.min(axis=0), (task.gaps, 1)), np.tile(high.max(axis=0), (task.gaps, 1))
        largest = np.maximum(np.abs(low), np.abs(high)).max(axis=0)
        largest = np.where(largest > 0, largest, largest.max() or 1.0)
        if rng.random() < 0.3:
            kinds.append(f"asymmetric {name}")
            low, high = np.minimum(low, -0.2 * largest), np.maximum(high, 0.2 * largest)
        else:
            both = np.maximum(np.maximum(-low, high), 0.2 * largest)
            low, high = -both, both
        limits[name] = np.stack([low, high], axis=1) * room
    if rng.random() < 0.3:
        kinds.append("position")
        low, high = (side for side in extremes[0])
        low, high = low.min(axis=0), high.max(axis=0)
        room = (high - low) * 10.0 ** rng.uniform(-2, 0) + 0.01 * np.abs(high).max()
        limits["position"] = np.stack([low - room, high + room])
    return Limits(**limits)


def _extremes(task: TrajectoryTask, motion: Trajectory, order: int) -> tuple[Array, Array]:
    """Return the least and largest value of a derivative in every gap, (G, n) each."""
    fractions = np.linspace(0.0, 1.0, SAMPLES)
    per_gap = task.virtual_knots + 1
    coefficients = motion.derivative_coefficients(order)
    local = np.diff(motion.breakpoints)[:, None] * fractions
    powers = local[:, :, None] ** np.arange(coefficients.shape[2])
    values = np.einsum("sfp,snp->sfn", powers, coefficients)
    if len(values) != task.gaps * per_gap:  # 3-5-3 has pieces of its own
        gap = motion.gap_at(0.5 * (np.asarray(motion.breakpoints)[1:] + np.asarray(motion.breakpoints)[:-1]))
    else:
        gap = np.repeat(np.arange(task.gaps), per_gap)
    low = np.stack([values[gap == each].min(axis=(0, 1)) for each in range(task.gaps)])
    high = np.stack([values[gap == each].max(axis=(0, 1)) for each in range(task.gaps)])
    return low, high


def _duration_bounds(rng: np.random.Generator, witness: Trajectory, kinds: list[str]) -> dict[str, Any]:
    """Return bounds of durations that the witness keeps."""
    gaps, draw = witness.segment_durations, rng.random()
    if draw < 0.05:
        kinds.append("given durations")
        return {"gap_durations": np.stack([gaps, gaps], axis=1)}
    if draw < 0.15:
        kinds.append("gap bounds")
        wide = np.stack([gaps * rng.uniform(0.1, 1.0, len(gaps)), gaps * rng.uniform(1.0, 3.0, len(gaps))], axis=1)
        wide[rng.random(len(gaps)) < 0.3, 1] = np.inf
        return {"gap_durations": wide}
    if draw < 0.25:
        kinds.append("total bound")
        return {"duration": (witness.duration * rng.uniform(0.1, 0.9), witness.duration * rng.uniform(1.0, 2.0))}
    return {}


def random_start(task: TrajectoryTask, rng: np.random.Generator) -> Trajectory:
    """Return a start with random proportions; where an end moves, with random velocities at the waypoints as well."""
    durations = closed_form_durations(task) * next(iter(random_factors(task, rng, 1))) * rng.choice([0.7, 1.0, 1.5])
    bounds = np.asarray(task.objective.gap_durations)
    durations = np.clip(durations, bounds[:, 0], bounds[:, 1])
    if task.boundary.is_rest:
        return initial_guess(task, durations)
    times = np.concatenate([[0.0], np.cumsum(durations)])
    points = np.asarray(task.waypoints)
    slope = np.diff(points, axis=0) / durations[:, None]
    velocity = np.zeros_like(points)
    velocity[1:-1] = 0.5 * (slope[1:] + slope[:-1]) * rng.uniform(0, 2, (len(points) - 2, 1))
    velocity[[0, -1]] = task.boundary.velocity
    curve = hermite_curve(task, times, points, velocity, times)
    per_gap = task.virtual_knots + 1
    inside = times[:-1, None] + durations[:, None] * np.arange(per_gap) / per_gap
    knots = np.append(inside.ravel(), times[-1])
    return hermite_curve(task, knots, curve(knots), curve(knots, 1), knots[::per_gap])


def moving_end_task(seed: int) -> TrajectoryTask:
    """Return two to seven joints with ends that move, half of them nearly along a line, half of them loose."""
    rng = np.random.default_rng([7, seed])
    n, count = int(rng.integers(2, 8)), int(rng.integers(3, 7))
    dense = bool(seed % 2)
    if dense:
        passed = np.concatenate([[0.0], np.sort(rng.uniform(0.03, 0.97, count - 2)), [1.0]])[:, None]
        aside = 0.05 * rng.standard_normal((count, n)) * passed * (1 - passed)
        points = (passed * (1 + aside)) * rng.uniform(0.2, 2, n) * rng.choice([-1, 1], n)
    else:
        points = rng.uniform(-1, 1, (count, n))
    acceleration, speed = np.full(n, 5.0), np.full(n, 50.0 if seed % 4 < 2 else 2.0)
    velocity, part, kind = np.zeros((2, n)), rng.uniform(0.3, 0.95), int(rng.integers(3))
    for side, (first, last) in enumerate(((0, 1), (-2, -1))):
        if kind in (side, 2):
            step = points[-1] - points[0] if dense else points[last] - points[first]
            reach = np.minimum(speed, np.sqrt(2 * acceleration * np.abs(step)))
            velocity[side] = part * np.min(reach / np.maximum(np.abs(step), 1e-9)) * step
    limits = Limits(velocity=speed, acceleration=acceleration)
    boundary = Boundary(velocity=np.clip(velocity, -0.95 * speed, 0.95 * speed))
    return TrajectoryTask(points, limits, virtual_knots=3, boundary=boundary, name=f"moving-ends-{seed}")


def squeezed_task(seed: int) -> TrajectoryTask:
    """Return a task that may have no motion: a solvable one with less time, faster ends or narrower positions."""
    rng = np.random.default_rng([23, seed])
    drawn = solvable_task(seed)
    task, witness = drawn.task, drawn.witness
    kind = int(rng.integers(4))
    bounds = Objective(time=1.0)
    if kind == 0:
        bounds = Objective(time=1.0, duration=(0.0, witness.duration * 10.0 ** rng.uniform(-1.0, 0.0)))
    elif kind == 1:
        gaps = witness.segment_durations * 10.0 ** rng.uniform(-0.7, 0.1, task.gaps)
        bounds = Objective(time=1.0, gap_durations=np.stack([gaps, gaps], axis=1))
    elif kind == 2 and task.limited("velocity"):
        speed = np.abs(task.limits.get("velocity")).max(axis=(0, 1)) * rng.uniform(0.5, 1.2)
        return task.changed(boundary=Boundary(np.stack([speed, -speed])), objective=bounds)
    return task.changed(objective=bounds)
