"""All references of a task in the form that `reference --json` writes."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.references.convex import convex_reference
from ocp_traj.references.result import ReferenceResult
from ocp_traj.references.shortest_motion import KinematicBound, kinematic_bound
from ocp_traj.references.time_optimal import toppra_reference

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

_logger = logging.getLogger(__name__)


def references(
    task: TrajectoryTask,
    trajectory: Trajectory | None = None,
    *,
    convex: bool = True,
    time_limit: float = 20.0,
    rng: np.random.Generator | None = None,
) -> dict[str, Any]:
    """Return the kinematic bound and the timings of fixed paths, ready for JSON.

    Parameters
    ----------
    task : TrajectoryTask
    trajectory : Trajectory, optional
        A motion through the same waypoints: its path is timed too, under the name ``"spline"``.
    convex : bool
        False leaves the convex timings out (their entries are then null); TOPP-RA gives the same durations faster.
    time_limit : float
        Seconds for the proof of the lower bound.
    rng : numpy.random.Generator, optional
        For the local search's starting points.

    Returns
    -------
    dict
        ``schema``, ``case``, ``kinematic_bound`` (``lower``, ``estimate``), ``toppra`` and ``convex`` (duration by
        path; null where none was found), and ``messages``: what was proved, and why a timing failed.
    """
    bound = kinematic_bound(task, time_limit=time_limit, rng=rng)
    paths: list[str | Trajectory] = ["uniform", "chord"]
    if trajectory is not None:
        paths.append(trajectory)
    fastest = [toppra_reference(task, path) for path in paths]
    tracked = [convex_reference(task, path) for path in paths] if convex else []
    names = [result.path for result in fastest]
    return {
        "schema": 1,
        "case": task.name,
        "kinematic_bound": {"lower": bound.lower, "estimate": bound.estimate},
        "toppra": {result.path: result.duration for result in fastest},
        "convex": {result.path: result.duration for result in tracked} or dict.fromkeys(names),
        "messages": _messages(bound, fastest + tracked),
    }


def _messages(bound: KinematicBound, results: list[ReferenceResult]) -> dict[str, str]:
    messages = {"kinematic_bound": bound.message}
    for result in results:
        if result.reason:
            messages[f"{result.method}.{result.path}"] = result.reason
            _logger.warning("%s on the %s path: %s", result.method, result.path, result.reason)
    return messages


def reference_columns(task: TrajectoryTask, *, time_limit: float = 20.0) -> dict[str, Any]:
    """Return what a result carries: the kinematic bound and the best TOPP-RA duration of uniform and chord.

    The form of ``references`` in `solve --json`: ``{"kinematic_bound": {"lower", "estimate"}, "toppra": seconds}``.
    """
    bound = kinematic_bound(task, time_limit=time_limit)
    durations = [toppra_reference(task, path).duration for path in ("uniform", "chord")]
    found = [duration for duration in durations if duration is not None]
    return {
        "kinematic_bound": {"lower": bound.lower, "estimate": bound.estimate},
        "toppra": min(found) if found else None,
    }
