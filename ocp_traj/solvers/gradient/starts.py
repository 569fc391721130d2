"""Other motions to start from, for when the first start fails or several shall compete."""

from __future__ import annotations

import logging
from collections.abc import Iterator

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import OcpTrajError
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.guess import closed_form_durations, initial_guess

logger = logging.getLogger(__name__)

DURATION_SPREAD = 0.5
"""Standard deviation of the logarithm of a random start's durations."""

DURATION_STRETCH = 1.5
"""Random starts are slower than the closed-form timing by this, which leaves room inside the limits."""


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


def toppra_durations(task: TrajectoryTask) -> Array | None:
    """Return the gap durations of a spline path timed by TOPP-RA, (K - 1,) s; None where it has none."""
    if not task.boundary.is_rest:
        return None
    try:
        from ocp_traj.references import toppra_reference

        result = toppra_reference(task, "chord")
    except (ImportError, OcpTrajError) as error:
        logger.info("no start by TOPP-RA: %s", error)
        return None
    if result.duration is None or result.waypoint_times is None:
        logger.info("no start by TOPP-RA: %s", result.reason)
        return None
    durations = np.diff(result.waypoint_times)
    # A path leaves out a waypoint that repeats the one before; its gap has no timing then.
    return durations if len(durations) == task.gaps and bool((durations > 0).all()) else None
