"""All references of a task in the form that `reference --json` writes."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.exceptions import InputError
from ocp_traj.references.bounds.certify import Certificate, certify
from ocp_traj.references.bounds.jerk_estimate import JerkEstimate, jerk_estimate
from ocp_traj.references.bounds.kinematic_bound import KinematicBound, kinematic_bound
from ocp_traj.references.timing.convex_reference import convex_reference
from ocp_traj.references.timing.jerk_limited_reference import jerk_limited_reference
from ocp_traj.references.timing.paths import WAYPOINT_PATHS
from ocp_traj.references.timing.result import ReferenceResult
from ocp_traj.references.timing.toppra_reference import toppra_reference

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

_logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class ReferenceSet:
    """All references of one task, with everything their pictures need.

    Attributes
    ----------
    task : TrajectoryTask
    bound : KinematicBound
    toppra, convex : tuple of ReferenceResult
        One a path; `convex` is empty where it was left out.
    jerk : JerkEstimate or None
        None where it was not asked for, or the task has no jerk limits.
    jerk_paths : tuple of ReferenceResult
        Timings with bounded jerk of the uniform and the chord path.
    certificate : Certificate or None
        None where it was not asked for.
    left_out : str
        Why the estimate with bounded jerk was asked for and is not there.
    """

    task: TrajectoryTask
    bound: KinematicBound
    toppra: tuple[ReferenceResult, ...]
    convex: tuple[ReferenceResult, ...] = ()
    jerk: JerkEstimate | None = None
    jerk_paths: tuple[ReferenceResult, ...] = ()
    certificate: Certificate | None = None
    left_out: str = ""

    def to_json(self) -> dict[str, Any]:
        """Return what `reference --json` writes."""
        names = [result.path for result in self.toppra]
        found: dict[str, Any] = {
            "schema": 1,
            "case": self.task.name,
            "kinematic_bound": {"lower": self.bound.lower, "estimate": self.bound.estimate},
            "toppra": {result.path: result.duration for result in self.toppra},
            "convex": {result.path: result.duration for result in self.convex} or dict.fromkeys(names),
        }
        if self.jerk is not None:
            found["jerk_estimate"] = {
                "estimate": self.jerk.estimate,
                **{result.path: result.duration for result in self.jerk_paths},
            }
        if self.certificate is not None:
            found["certificate"] = {"lower": self.certificate.lower, "upper": self.certificate.upper}
        return {**found, "messages": self.messages()}

    def messages(self) -> dict[str, str]:
        """Return what was proved, and why a timing failed."""
        said = {"kinematic_bound": self.bound.message}
        for result in (*self.toppra, *self.convex, *self.jerk_paths):
            if result.reason:
                said[f"{result.method}.{result.path}"] = result.reason
        if self.jerk is not None:
            said["jerk_estimate"] = self.jerk.message
        elif self.left_out:
            said["jerk_estimate"] = self.left_out
        if self.certificate is not None:
            said["certificate"] = self.certificate.message
        return said


def collect_references(
    task: TrajectoryTask,
    trajectory: Trajectory | None = None,
    *,
    convex: bool = True,
    jerk: bool = False,
    certificate: bool = False,
    time_limit: float = 20.0,
    rng: np.random.Generator | None = None,
) -> ReferenceSet:
    """Return the kinematic bound and the timings of fixed paths, and on request what needs more time.

    Parameters
    ----------
    task : TrajectoryTask
    trajectory : Trajectory, optional
        A motion through the same waypoints: its path is timed too, under the name ``"spline"``.
    convex : bool
        False leaves the convex timings out; TOPP-RA gives the same durations faster.
    jerk : bool
        Estimate the shortest motion with bounded jerk too, on any path (`jerk_estimate`) and on the fixed paths
        (`jerk_limited_reference`): local optima, no bounds.
    certificate : bool
        Prove the best durations of the task's own spline family too (`certify`).
    time_limit : float
        Seconds for the proof of the lower bound.
    rng : numpy.random.Generator, optional
        For the local search's starting points.
    """
    bound = kinematic_bound(task, time_limit=time_limit, rng=rng)
    paths: list[str | Trajectory] = ["uniform", "chord"]
    if trajectory is not None:
        paths.append(trajectory)
    found = ReferenceSet(
        task,
        bound,
        tuple(toppra_reference(task, path) for path in paths),
        tuple(convex_reference(task, path) for path in paths) if convex else (),
        certificate=certify(task) if certificate else None,
    )
    if jerk:
        found = _with_jerk(found)
    for name, reason in found.messages().items():
        if "." in name:  # a path that could not be timed
            _logger.warning("%s: %s", name.replace(".", " on the path "), reason)
    return found


def _with_jerk(found: ReferenceSet) -> ReferenceSet:
    """Add the estimates with bounded jerk, or why there are none."""
    try:
        estimate = jerk_estimate(found.task)
    except InputError as error:
        return replace(found, left_out=str(error))
    timed = []
    for path in WAYPOINT_PATHS:
        try:
            timed.append(jerk_limited_reference(found.task, path))
        except InputError as error:
            timed.append(ReferenceResult("convex-jerk", path, None, str(error)))
    return replace(found, jerk=estimate, jerk_paths=tuple(timed))


def references(
    task: TrajectoryTask,
    trajectory: Trajectory | None = None,
    *,
    convex: bool = True,
    jerk: bool = False,
    certificate: bool = False,
    time_limit: float = 20.0,
    rng: np.random.Generator | None = None,
) -> dict[str, Any]:
    """Return `collect_references` ready for JSON.

    Parameters
    ----------
    task, trajectory, convex, jerk, certificate, time_limit, rng
        See `collect_references`.

    Returns
    -------
    dict
        ``schema``, ``case``, ``kinematic_bound`` (``lower``, ``estimate``), ``toppra`` and ``convex`` (duration by
        path; null where none was found), on request ``jerk_estimate`` (``estimate`` for any path, and by path) and
        ``certificate`` (``lower``, ``upper``), and ``messages``: what was proved, and why a timing failed.
    """
    found = collect_references(
        task,
        trajectory,
        convex=convex,
        jerk=jerk,
        certificate=certificate,
        time_limit=time_limit,
        rng=rng,
    )
    return found.to_json()


def reference_columns(task: TrajectoryTask, *, time_limit: float = 20.0) -> dict[str, Any]:
    """Return what a result carries: the kinematic bound and the best TOPP-RA duration of uniform and chord.

    The form of ``references`` in `solve --json`: ``{"kinematic_bound": {"lower", "estimate"}, "toppra": seconds}``.

    Parameters
    ----------
    task : TrajectoryTask
    time_limit : float
        Seconds the bound may take.
    """
    bound = kinematic_bound(task, time_limit=time_limit)
    durations = [toppra_reference(task, path).duration for path in ("uniform", "chord")]
    found = [duration for duration in durations if duration is not None]
    return {
        "kinematic_bound": {"lower": bound.lower, "estimate": bound.estimate},
        "toppra": min(found) if found else None,
    }
