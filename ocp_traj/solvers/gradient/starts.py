"""Other motions to start from, for when the first start fails or several shall compete."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import OcpTrajError
from ocp_traj.solvers.gradient.along_chords import chord_start, hermite_curve
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.guess import closed_form_durations, initial_guess

if TYPE_CHECKING:
    from ocp_traj.references import ReferenceResult

logger = logging.getLogger(__name__)

DURATION_SPREAD = 0.5
"""Standard deviation of the logarithm of a random start's durations."""

DURATION_STRETCH = 1.5
"""Random starts are slower than the closed-form timing by this, which leaves room inside the limits."""

TOPPRA_CELLS = 400
"""Cells of the path whose timing by TOPP-RA is a start; more for long paths."""

FINE_CELLS = 200
"""Cells per gap in which knots are placed."""

LEAST_DISTANCE = 0.1
"""Least distance of two knots that are placed, as a fraction of even spacing."""


def other_starts(task: TrajectoryTask, rng: np.random.Generator, count: int) -> Iterator[Trajectory]:
    """Yield up to `count` starts: centripetal timing, TOPP-RA timing, closed-form timing with random proportions.

    Parameters
    ----------
    task : TrajectoryTask
    rng : numpy.random.Generator
    count : int
    """
    if count <= 0:
        return
    yield initial_guess(task, centripetal_durations(task))
    durations = toppra_durations(task) if count > 1 else None
    if durations is not None:
        yield initial_guess(task, durations)
        count -= 1
    count -= 1
    for factors in random_factors(task, rng, count):
        yield initial_guess(task, closed_form_durations(task) * (DURATION_STRETCH * factors))


def random_factors(
    task: TrajectoryTask, rng: np.random.Generator, count: int, spread: float = DURATION_SPREAD
) -> Iterator[Array]:
    """Yield `count` times random proportions (K - 1,) to multiply the gap durations of a motion by.

    Parameters
    ----------
    task : TrajectoryTask
    rng : numpy.random.Generator
    count : int
    spread : float
        Standard deviation of the logarithm of each gap's duration.
    """
    for _ in range(count):
        yield np.exp(spread * rng.standard_normal(task.gaps))


def centripetal_durations(task: TrajectoryTask) -> Array:
    """Return gap durations that grow with the root of the distance, (K - 1,) s, before any scaling.

    Splines timed so leave the waypoints' range least (Lee 1989, "Choosing nodes in parametric curve interpolation"),
    which helps where positions are limited. Every joint counts by the range it passes through.
    """
    travel = np.ptp(task.waypoints, axis=0)
    steps = np.diff(task.waypoints, axis=0) / np.where(travel > 0, travel, 1.0)
    roots = np.sqrt(np.linalg.norm(steps, axis=1))
    largest = float(roots.max()) or 1.0
    return np.maximum(roots, 0.05 * largest) / largest


def further_starts(task: TrajectoryTask) -> Iterator[Trajectory]:
    """Yield starts that compete with the closed-form timing; none where that leads to good optima by itself.

    Where an end moves, the closed-form timing is too slow for its speed, and the loop that the spline then makes
    stays in the answer. TOPP-RA's motion does without it, or speeds along the chords where its path has no timing.

    Parameters
    ----------
    task : TrajectoryTask
        Of a family that has a lifted form.
    """
    if task.boundary.is_rest or task.gaps == 1:
        return
    for knots in dict.fromkeys((task.family.first_virtual_knots, task.virtual_knots)):
        if knots <= task.virtual_knots:
            start = toppra_start(task, knots) or chord_start(task, knots)
            if start is not None:
                yield start


def toppra_start(task: TrajectoryTask, virtual_knots: int) -> Trajectory | None:
    """Return the cubic Hermite curve through TOPP-RA's positions and velocities at knots where joints switch.

    Waypoints and end velocities are exact; the acceleration jumps at knots, which a solver mends. None where TOPP-RA
    has no timing, for instance where its path cannot take an end velocity.

    Parameters
    ----------
    task : TrajectoryTask
    virtual_knots : int
        Per gap.
    """
    result = _toppra(task, max(TOPPRA_CELLS, 4 * task.gaps))
    if result is None:
        return None
    knots, per_gap = _switching_knots(result, virtual_knots), virtual_knots + 1
    q, v = (
        np.stack([np.interp(knots, result.times, values[:, j]) for j in range(task.n)], axis=1)
        for values in (result.q, result.v)
    )
    q[::per_gap] = task.waypoints
    v[[0, -1]] = task.boundary.velocity
    return hermite_curve(task, knots, q, v, knots[::per_gap])


def _switching_knots(result: ReferenceResult, virtual_knots: int) -> Array:
    """Return waypoint times with virtual knots between them, crowded where the accelerations change, s.

    A spline needs two knots to switch an acceleration quickly, and a solver seldom moves a knot across another one.
    Knots share the changes of each gap evenly, half of the weight being the time itself.
    """
    times, velocities = np.asarray(result.times), np.asarray(result.v)
    acceleration = np.diff(velocities, axis=0) / np.diff(times)[:, None]
    size = np.abs(acceleration).max(axis=0)
    changes = np.abs(np.diff(acceleration, axis=0) / np.where(size > 0, size, 1.0)).sum(axis=1)
    middle = (times[1:] + times[:-1]) / 2
    grown = np.concatenate([[0.0], np.cumsum(changes)])  # at the middles of the cells
    even = np.arange(1, virtual_knots + 1) / (virtual_knots + 1)
    knots: list[float] = []
    for start, end in zip(result.waypoint_times, result.waypoint_times[1:]):
        fine = np.linspace(start, end, FINE_CELLS + 1)
        weight = np.interp(fine, middle, grown) - np.interp(start, middle, grown)
        share = np.linspace(0.0, 1.0, FINE_CELLS + 1)
        share = (share + weight / weight[-1]) / 2 if weight[-1] > 0 else share
        crowded = np.interp(even, share, np.linspace(0.0, 1.0, FINE_CELLS + 1))
        knots += [start, *(start + (end - start) * _apart(crowded, LEAST_DISTANCE / (virtual_knots + 1)))]
    return np.array([*knots, result.waypoint_times[-1]])


def _apart(places: Array, least: float) -> Array:
    """Return increasing places in (0, 1), those that nearly meet moved apart about their middle."""
    apart = [0.0, *places, 1.0]
    for _ in range(len(apart)):
        for k in range(len(apart) - 1):
            missing = least - (apart[k + 1] - apart[k])
            if missing > 0:
                left, right = (0.0 if k == 0 else 0.5), (0.0 if k == len(apart) - 2 else 0.5)
                apart[k] -= missing * (left if right else 1.0)
                apart[k + 1] += missing * (right if left else 1.0)
    inside = np.array(apart[1:-1])
    even = np.arange(1, len(places) + 1) / (len(places) + 1)
    return inside if (np.diff([0.0, *inside, 1.0]) > 0).all() else even


def toppra_durations(task: TrajectoryTask) -> Array | None:
    """Return the gap durations of a spline path timed by TOPP-RA, (K - 1,) s; None where it has none."""
    result = _toppra(task, None) if task.boundary.is_rest else None
    return None if result is None else np.diff(result.waypoint_times)


def _toppra(task: TrajectoryTask, points: int | None) -> ReferenceResult | None:
    """Return TOPP-RA's timing of a spline path; None where it has none or not one duration per gap."""
    try:
        from ocp_traj.references import toppra_reference

        result: ReferenceResult = toppra_reference(task, "chord", points=points)
    except (ImportError, OcpTrajError) as error:
        logger.info("no start by TOPP-RA: %s", error)
        return None
    if result.duration is None or result.waypoint_times is None:
        logger.info("no start by TOPP-RA: %s", result.reason)
        return None
    durations = np.diff(result.waypoint_times)
    # A path leaves out a waypoint that repeats the one before; its gap has no timing then.
    return result if len(durations) == task.gaps and bool((durations > 0).all()) else None
