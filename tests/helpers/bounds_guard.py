"""A stricter judge for all tests: a motion it accepts must not be shorter than what is proved possible."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

CERTIFIED_GAPS = 3
"""Gaps up to which packaged cases, however changed, are certified before their motions are judged: a second each."""

_bounds: dict[Any, float | None] = {}
_off: list[bool] = []


@pytest.fixture(scope="session", autouse=True)
def no_accepted_motion_beats_its_bound() -> Iterator[None]:
    """Fail every test in which a motion is accepted although it is shorter than what is proved possible.

    The function inside `ocp_traj.audit` is replaced, so that modules that imported `audit` already are guarded too.
    """
    from ocp_traj.audit import judge

    inner = judge._judge

    def guarded(task: Any, motion: Any, notes: list[str]) -> Any:
        verdict = inner(task, motion, notes)
        if verdict.feasible and not _off:
            complaint = contradiction(task, motion.trajectory)
            assert not complaint, complaint
        return verdict

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(judge, "_judge", guarded)
        yield


@contextmanager
def unguarded() -> Iterator[None]:
    """Judge by the audit alone, for motions by the thousand or tasks that the bound reads more strictly."""
    _off.append(True)
    try:
        yield
    finally:
        _off.pop()


def contradiction(task: Any, trajectory: Any) -> str:
    """Return how an accepted motion contradicts the kinematic bound, or an empty string.

    Its durations have to pass the exact test of the double integrator, and its total the certified lower bound; both
    with the tolerances of the audit.
    """
    from ocp_traj.references.bounds.double_integrator import feasible
    from ocp_traj.references.bounds.kinematic_bound import bounded_velocities, joint_limits

    moving, limits, reason = joint_limits(task)
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
    """Return the certified lower bound of packaged cases with few gaps, proved once per task; None for others."""
    from ocp_traj.case import case_names

    if task.gaps > CERTIFIED_GAPS or task.name not in case_names():
        return None
    from ocp_traj.references import kinematic_bound

    parts = (task.waypoints, task.tolerance, task.limits.get("velocity"), task.limits.get("acceleration"))
    key = tuple(np.asarray(part).tobytes() for part in parts)
    if key not in _bounds:
        bound = kinematic_bound(task, gap=0.02, time_limit=1e9, largest_nodes=2000, starts=1)
        _bounds[key] = bound.lower
    return _bounds[key]
