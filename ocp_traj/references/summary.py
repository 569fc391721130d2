"""All references of a task in the form that `reference --json` writes."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.deadline import Deadline
from ocp_traj.exceptions import InputError
from ocp_traj.references.reference import ReferenceFinding, ReferenceRequest
from ocp_traj.references.registry import all_references, reference_named

if TYPE_CHECKING:
    from ocp_traj.references.bounds.certify import Certificate
    from ocp_traj.references.bounds.jerk_estimate import JerkEstimate
    from ocp_traj.references.bounds.kinematic_bound import KinematicBound
    from ocp_traj.references.timing.result import ReferenceResult
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

USUAL_SECONDS = 20.0
"""Seconds for all references of a task together, but for a certificate."""

CERTIFICATE_SECONDS = 120.0
"""Seconds more where a certificate is asked for."""

_logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class ReferenceSet:
    """The references of one task, with everything their pictures need.

    Attributes
    ----------
    task : TrajectoryTask
        The problem.
    findings : mapping
        From the name of each reference that was asked for to what it found.
    """

    task: TrajectoryTask
    findings: Mapping[str, ReferenceFinding]

    def _results(self, name: str) -> tuple[Any, ...]:
        return self.findings[name].results if name in self.findings else ()

    @property
    def bound(self) -> KinematicBound:
        """The kinematic bound and its estimate."""
        return self._results("kinematic_bound")[0]

    @property
    def toppra(self) -> tuple[ReferenceResult, ...]:
        """TOPP-RA's timings, one per path."""
        return self._results("toppra")

    @property
    def convex(self) -> tuple[ReferenceResult, ...]:
        """The convex timings, one per path; empty where they were left out."""
        return self._results("convex")

    @property
    def jerk(self) -> JerkEstimate | None:
        """The estimate with bounded jerk; None where it was not asked for or does not apply."""
        return next(iter(self._results("jerk_estimate")), None)

    @property
    def certificate(self) -> Certificate | None:
        """The proof of the best durations; None where it was not asked for."""
        return next(iter(self._results("certificate")), None)

    def to_json(self) -> dict[str, Any]:
        """Return what `reference --json` writes."""
        tables = {name: dict(found.seconds) for name, found in self.findings.items() if found.seconds}
        return {"schema": 1, "case": self.task.name, **tables, "messages": self.messages()}

    def messages(self) -> dict[str, str]:
        """Return what was proved, and why a timing failed."""
        return {
            f"{name}.{part}" if part else name: message
            for name, found in self.findings.items()
            for part, message in found.messages.items()
        }


def collect_references(
    task: TrajectoryTask,
    trajectory: Trajectory | None = None,
    *,
    time_limit: float | None = None,
    rng: np.random.Generator | None = None,
    **wanted: bool,
) -> ReferenceSet:
    """Return the kinematic bound and the timings of fixed paths, and on request what needs more time.

    Parameters
    ----------
    task : TrajectoryTask
        The problem.
    trajectory : Trajectory, optional
        A motion through the same waypoints: its path is timed too, under the name ``"spline"``.
    time_limit : float, optional
        Seconds for all references together; `USUAL_SECONDS`, and `CERTIFICATE_SECONDS` more for a certificate, when
        left out. What they left undone stands in the messages.
    rng : numpy.random.Generator, optional
        For the local search's starting points.
    **wanted : bool
        ``convex`` (default True): False leaves the convex timings out; TOPP-RA gives the same durations faster.
        ``jerk``: estimate the shortest motion with bounded jerk too, on any path (`jerk_estimate`) and on the fixed
        paths (`jerk_limited_reference`): local optima, no bounds. ``certificate``: prove the best durations of the
        task's own spline family too (`certify`). A reference of another package may have a keyword of its own.

    Raises
    ------
    InputError
        A keyword is none of these.
    """
    known = all_references()
    unknown = set(wanted) - {reference.option for reference in known}
    if unknown:
        expected = ", ".join(sorted(reference.option for reference in known if reference.option))
        raise InputError(f"{min(unknown)!r} asks for no reference, expected one of {expected}")
    if time_limit is None:
        time_limit = USUAL_SECONDS + (CERTIFICATE_SECONDS if wanted.get("certificate") else 0.0)
    if not time_limit > 0:
        raise InputError(f"time_limit is {time_limit}, expected a positive number of seconds")
    deadline = Deadline(time_limit)
    request = ReferenceRequest(task, trajectory, time_limit, rng)
    asked = [reference for reference in known if wanted.get(reference.option, reference.wanted)]
    computed = {}
    for done, reference in enumerate(sorted(asked, key=lambda each: each.patient)):
        allowed = deadline.fraction(1.0 / (len(asked) - done)).left
        computed[reference.name] = reference.find(replace(request, time_limit=allowed))
    nothing = ReferenceFinding(dict.fromkeys(request.path_names))
    findings = {
        reference.name: computed.get(reference.name, nothing)
        for reference in known
        if reference in asked or reference.wanted  # the place in the answer of one left out stays
    }
    found = ReferenceSet(task, findings)
    for name, reason in found.messages().items():
        if "." in name:  # a path that could not be timed
            _logger.warning("%s: %s", name.replace(".", " on the path "), reason)
    return found


def references(
    task: TrajectoryTask, trajectory: Trajectory | None = None, **options: Any
) -> dict[str, Any]:
    """Return `collect_references` ready for JSON.

    Parameters
    ----------
    task, trajectory
        See `collect_references`.
    **options
        Its other arguments.

    Returns
    -------
    dict
        ``schema``, ``case``, ``kinematic_bound`` (``lower``, ``estimate``), ``toppra`` and ``convex`` (duration by
        path; null where none was found), on request ``jerk_estimate`` (``estimate`` for any path, and by path) and
        ``certificate`` (``lower``, ``upper``), and ``messages``: what was proved, and why a timing failed.
    """
    return collect_references(task, trajectory, **options).to_json()


def reference_columns(task: TrajectoryTask, *, time_limit: float = USUAL_SECONDS) -> dict[str, Any]:
    """Return what a result carries: the kinematic bound and the best TOPP-RA duration of uniform and chord.

    The form of ``references`` in `solve --json`: ``{"kinematic_bound": {"lower", "estimate"}, "toppra": seconds}``.

    Parameters
    ----------
    task : TrajectoryTask
        The problem.
    time_limit : float
        Seconds they may take together.
    """
    deadline = Deadline(time_limit)
    toppra, bound = (
        reference_named(name).find(ReferenceRequest(task, time_limit=deadline.fraction(share).left)).seconds
        for name, share in (("toppra", 0.5), ("kinematic_bound", 1.0))
    )
    found = [duration for duration in toppra.values() if duration is not None]
    return {"kinematic_bound": dict(bound), "toppra": min(found, default=None)}
