"""Settings for every test: one thread a process, no display, reproducible property tests; and no accepted motion may
be shorter than its certified lower bound."""

from __future__ import annotations

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")
os.environ.setdefault("MPLBACKEND", "Agg")

from hypothesis import HealthCheck, settings  # noqa: E402

settings.register_profile(
    "default", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("long", deadline=None, max_examples=5000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))

import functools  # noqa: E402
from dataclasses import replace  # noqa: E402
from importlib import import_module  # noqa: E402
from typing import Any  # noqa: E402

import numpy as np  # noqa: E402

_package, _judge = (import_module(name) for name in ("ocp_traj.audit", "ocp_traj.audit.judge"))
_audit = _judge.audit
_bounds: dict[Any, float | None] = {}

CERTIFIED_GAPS = 3
"""Gaps up to which packaged cases, however changed, are certified before their motions are judged: a second each."""


@functools.wraps(_audit)
def audit_against_bounds(task: Any, trajectory: Any) -> Any:
    """Judge a motion, and fail the test if it is accepted although it is shorter than what is proved possible."""
    verdict = _audit(task, trajectory)
    if verdict.feasible:
        complaint = contradiction(task, trajectory)
        assert not complaint, complaint
    return verdict


def contradiction(task: Any, trajectory: Any) -> str:
    """Return how an accepted motion contradicts the kinematic bound, or an empty string.

    Its durations have to pass the exact test of the double integrator, and its total the certified lower bound; both
    with the tolerances of the audit.
    """
    from ocp_traj.references.bounds.double_integrator import feasible
    from ocp_traj.references.bounds.kinematic_bound import _joint_limits, bounded_velocities

    moving, limits, reason = _joint_limits(task)
    at_rest = not np.any(task.boundary.velocity)
    known = len(trajectory.waypoint_times) == task.gaps + 1
    if reason or not (moving.any() and at_rest and known):
        return ""
    sides = ("fastest", "slowest", "speeding", "braking")
    wide = {name: getattr(limits, name) * (1 + 2e-6) for name in sides}
    slow = 2e-8 * np.minimum(limits.fastest.max(axis=0), 1e3)
    wide |= {"nearest": limits.nearest - 2e-8, "farthest": limits.farthest + 2e-8}
    wide |= {name: np.stack([-slow, slow]) for name in ("start", "end")}
    durations = np.diff(trajectory.waypoint_times)[None, :]
    exact = all(np.isfinite(getattr(limits, name)).all() for name in ("speeding", "braking"))
    if (
        exact
        and not feasible(
            bounded_velocities(replace(limits, **wide), 2 * trajectory.duration), durations, durations
        )[0]
    ):
        return f"{task.name}: durations {durations[0]} pass the audit, but not the exact test of the kinematic bound"
    bound = certified_bound(task)
    if bound is not None and trajectory.duration < bound * (1 - 3e-6) - 1e-7:
        return f"{task.name}: {trajectory.duration} s pass the audit, but {bound} s are proved necessary"
    return ""


def certified_bound(task: Any) -> float | None:
    """Return the certified lower bound of packaged cases with few gaps, proved once a task; None for others."""
    from ocp_traj.case import case_names

    if task.gaps > CERTIFIED_GAPS or task.name not in case_names():
        return None
    from ocp_traj.references import kinematic_bound

    parts = (task.waypoints, task.tolerance, task.limits.get("velocity"), task.limits.get("acceleration"))
    key = tuple(np.asarray(part).tobytes() for part in parts)
    if key not in _bounds:
        bound = kinematic_bound(task, gap=0.02, time_limit=0.5, largest_nodes=2000, starts=1)
        _bounds[key] = bound.lower
    return _bounds[key]


for _place in (_package, _judge):
    setattr(_place, "audit", audit_against_bounds)  # noqa: B010
