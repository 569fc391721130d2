"""The references there are; a further one is a line here, or an entry point of a package of yours."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import metadata
from typing import TYPE_CHECKING, Any

from ocp_traj.deadline import Deadline
from ocp_traj.exceptions import InputError, UnavailableError, UnknownNameError
from ocp_traj.references.reference import (
    ESTIMATED,
    FOUND,
    PROVED,
    Reference,
    ReferenceFinding,
    ReferenceRequest,
    missing_packages,
)

if TYPE_CHECKING:
    from ocp_traj.references.timing.result import ReferenceResult
    from ocp_traj.task import TrajectoryTask

GROUP = "ocp_traj.references"
"""Entry points of this group are `Reference` objects."""


CONVEX_PACKAGES = ("toppra", "cvxpy", "clarabel")
"""What convex path tracking needs; it starts from TOPP-RA's timing."""


def _find_bound(request: ReferenceRequest) -> ReferenceFinding:
    from ocp_traj.references.bounds.kinematic_bound import kinematic_bound

    bound = kinematic_bound(request.task, time_limit=request.time_limit, rng=request.rng)
    seconds = {"lower": bound.lower, "estimate": bound.estimate}
    return ReferenceFinding(seconds, {"": bound.message}, (bound,))


def _find_toppra(request: ReferenceRequest) -> ReferenceFinding:
    from ocp_traj.references.timing.toppra_reference import toppra_reference

    return timed(_for_each_path(toppra_reference, request, request.paths))


def _find_convex(request: ReferenceRequest) -> ReferenceFinding:
    from ocp_traj.references.timing.convex_reference import convex_reference

    return timed(_for_each_path(convex_reference, request, request.paths))


def _find_jerk_estimate(request: ReferenceRequest) -> ReferenceFinding:
    from ocp_traj.references.bounds.jerk_estimate import jerk_estimate
    from ocp_traj.references.timing.jerk_limited_reference import jerk_limited_reference
    from ocp_traj.references.timing.result import ReferenceResult

    deadline = Deadline(request.time_limit)
    paths: tuple[str, ...] = () if request.brief else ("uniform", "chord")
    try:
        estimate = jerk_estimate(request.task, time_limit=deadline.fraction(1.0 / (1 + len(paths))).left)
    except InputError as error:
        return ReferenceFinding({}, {"": str(error)})
    missing = ", ".join(missing_packages(CONVEX_PACKAGES))

    def along(task: TrajectoryTask, path: str, *, time_limit: float) -> ReferenceResult:
        if missing:
            return ReferenceResult("convex-jerk", path, None, f"needs {missing}, not installed here")
        try:
            return jerk_limited_reference(task, path, time_limit=time_limit)
        except InputError as error:
            return ReferenceResult("convex-jerk", path, None, str(error))

    results = _for_each_path(along, replace(request, time_limit=deadline.left), paths)
    found = timed(results)
    return ReferenceFinding(
        {"estimate": estimate.estimate, **found.seconds},
        {"": estimate.message, **found.messages},
        (estimate, *results),
    )


def _for_each_path(time_path: Callable[..., Any], request: ReferenceRequest, paths: Sequence[Any]) -> list[Any]:
    """Return the timings of several paths, each with an equal share of the time that is left."""
    deadline = Deadline(request.time_limit)
    return [
        time_path(request.task, path, time_limit=deadline.fraction(1.0 / (len(paths) - done)).left)
        for done, path in enumerate(paths)
    ]


def _find_certificate(request: ReferenceRequest) -> ReferenceFinding:
    from ocp_traj.references.bounds.certify import certify

    proof = certify(request.task, time_limit=request.time_limit)
    return ReferenceFinding({"lower": proof.lower, "upper": proof.upper}, {"": proof.message}, (proof,))


def timed(results: list[Any]) -> ReferenceFinding:
    """Return what timings of fixed paths found, each a `ReferenceResult`."""
    return ReferenceFinding(
        {result.path: result.duration for result in results},
        {result.path: result.reason for result in results if result.reason},
        tuple(results),
    )


REFERENCES = (
    Reference(
        "kinematic_bound",
        "bound",
        _find_bound,
        {"lower": (PROVED, "kinematic bound"), "estimate": (ESTIMATED, "kinematic estimate")},
        "Bound: certified kinematic bound, or its estimate where there is no certificate (marked ~).",
        patient=True,
    ),
    Reference(
        "toppra", "TOPP-RA", _find_toppra, note="TOPP-RA: the best of its paths.", requires=("toppra",)
    ),
    Reference("convex", "convex", _find_convex, option="convex", compared=False, requires=CONVEX_PACKAGES),
    Reference(
        "jerk_estimate",
        "jerk estimate",
        _find_jerk_estimate,
        {"estimate": (ESTIMATED, "with bounded jerk, estimate")},
        "Jerk estimate: a local optimum with bounded jerk, no bound.",
        option="jerk",
        wanted=False,
    ),
    Reference(
        "certificate",
        "certificate",
        _find_certificate,
        {
            "lower": (PROVED, "spline family: no durations below"),
            "upper": (FOUND, "spline family: best durations"),
        },
        option="certificate",
        wanted=False,
        compared=False,
        patient=True,
    ),
)
"""The references of this package, in the order in which they are shown."""


def all_references() -> tuple[Reference, ...]:
    """Return all references, those of other packages last.

    Raises
    ------
    UnavailableError
        A reference of another package cannot be loaded.
    """
    return (*REFERENCES, *(_load(point) for point in metadata.entry_points(group=GROUP)))


def reference_named(name: str) -> Reference:
    """Return a reference by name.

    Raises
    ------
    UnknownNameError
        There is no such reference.
    """
    known = {reference.name: reference for reference in all_references()}
    if name not in known:
        raise UnknownNameError(f"reference {name!r} is unknown, expected one of {', '.join(known)}")
    return known[name]


def _load(point: metadata.EntryPoint) -> Reference:
    try:
        reference = point.load()
    except Exception as error:  # somebody else's package: whatever it raises is the reason we report
        raise UnavailableError(f"reference {point.name!r} cannot be loaded: {error}") from error
    if not isinstance(reference, Reference):
        raise UnavailableError(f"reference {point.name!r} is a {type(reference).__name__}, expected a Reference")
    return reference
