"""Motions the papers' pages are about: judged, compared with references and proved optima, measured."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.papers.paper import AuditedMotion, Claim
from ocp_traj.papers.records import Records
from ocp_traj.pictures.motion import path_length, tool_path

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask

SHARED_GAP = 1e-3
"""To what the optimum with durations shared by all joints is proved, relative."""

JOINT_GAP = 0.02
"""To what the optimum of one joint alone is proved, relative; the best found is much closer."""

PATH_SAMPLES = 2000
"""Points of the tool's path whose distances are summed."""


def audit_durations(task: TrajectoryTask, words: str, durations: list[float]) -> AuditedMotion:
    """Judge the task's curve with given gap durations."""
    from ocp_traj.audit import audit
    from ocp_traj.transcription import trajectory_from_durations

    verdict = audit(task, trajectory_from_durations(task, durations))
    worst = verdict.worst
    finding = "keeps every limit" if verdict.feasible else str(worst)
    return AuditedMotion(
        words,
        float(np.sum(durations)),
        verdict.feasible,
        np.nan if worst is None else float(worst.ratio),
        finding,
        verdict.smallest_feasible_scale,
    )


def reference_numbers(task: TrajectoryTask, records: Records) -> dict[str, Any]:
    """Return TOPP-RA, convex and bound of the case, computed once."""
    from ocp_traj.references import references

    return records.computed("references", lambda: references(task))


def certified_optimum(task: TrajectoryTask, records: Records) -> dict[str, Any]:
    """Return the best duration of a task's family, proved to `SHARED_GAP`, computed once."""
    return records.computed("certificate", lambda: _prove(task, SHARED_GAP))


def joint_optima(task: TrajectoryTask, records: Records) -> dict[int, dict[str, Any]]:
    """Return the optimum of every moving joint (from 1) alone, proved to `JOINT_GAP` where it moves in all gaps."""
    from ocp_traj.solvers.per_joint import joint_task

    moving = np.flatnonzero(np.ptp(task.waypoints, axis=0) > 0).tolist()
    return {
        joint + 1: records.computed(
            f"certificate, joint {joint + 1}", partial(_prove, joint_task(task, joint), JOINT_GAP)
        )
        for joint in moving
    }


def _prove(task: TrajectoryTask, gap: float) -> dict[str, Any]:
    from ocp_traj.references import certify

    found = certify(task, gap=gap)
    return {
        "lower": found.lower,
        "upper": found.upper,
        "message": found.message,
        "durations": found.durations.tolist(),
    }


def synchronised_optima(task: TrajectoryTask, optima: dict[int, dict[str, Any]]) -> list[float]:
    """Return the largest duration per gap over the joints that move in it, from each joint's own optimum."""
    from ocp_traj.solvers.per_joint import synchronise

    durations = np.zeros((task.n, task.gaps))
    for joint, found in optima.items():
        durations[joint - 1] = found["durations"]
    return [float(h) for h in synchronise(task, durations)]


def travelled(task: TrajectoryTask, durations: list[float]) -> float:
    """Return the length of the tool's path, m, of the motion with these durations."""
    from ocp_traj.transcription import trajectory_from_durations

    motion = trajectory_from_durations(task, durations)
    return path_length(tool_path(task, motion, np.linspace(0, motion.duration, PATH_SAMPLES)))


def claim_smooth(task: TrajectoryTask, durations: list[float], source: str) -> Claim:
    """Judge that displacement, velocity and acceleration have no jumps, from one-sided limits at the inner points."""
    from ocp_traj.transcription import trajectory_from_durations

    motion = trajectory_from_durations(task, durations)
    inner = motion.breakpoints[1:-1]
    jumps = [
        float(np.abs(motion(inner + 1e-9, order) - motion(inner - 1e-9, order)).max()) for order in (1, 2, 3)
    ]
    return Claim(
        "displacement, velocity and acceleration are smooth, without abrupt changes",
        source,
        f"at the inner points velocity jumps by {jumps[0]:.1e} rad/s, acceleration by "
        f"{jumps[1]:.1e} rad/s² (1e-9 s on both sides), jerk by {jumps[2]:.3g} rad/s³",
        "holds up to acceleration; jerk jumps" if max(jumps[:2]) < 1e-5 else "does not hold",
    )
