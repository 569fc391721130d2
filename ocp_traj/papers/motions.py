"""Motions the papers' pages are about: judged, compared with references and proved optima, measured."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.papers.paper import AuditedMotion, Claim, Paper
from ocp_traj.papers.records import Records

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask

JOINT_GAP = 0.02
"""To what the optimum of one joint alone is proved; the best found is much closer."""


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


def reference_numbers(paper: Paper, records: Records) -> dict[str, Any]:
    """Return TOPP-RA, convex and bound of the case, computed once."""
    from ocp_traj.case import task_digest
    from ocp_traj.references import references

    task = paper.task()
    return records.computed("references", lambda: references(task), task_digest(task))


def certified_optimum(task: TrajectoryTask, records: Records, gap: float = 1e-3) -> dict[str, Any]:
    """Return the best duration of a task's family, proved to a relative `gap`, computed once."""
    from ocp_traj.case import task_digest
    from ocp_traj.references import certify

    def work() -> dict[str, Any]:
        found = certify(task, gap=gap)
        return {
            "lower": found.lower,
            "upper": found.upper,
            "message": found.message,
            "durations": found.durations.tolist(),
        }

    return records.computed(f"certificate {gap:g}", work, task_digest(task))


def joint_optima(paper: Paper, records: Records) -> dict[int, dict[str, Any]]:
    """Return the optimum of every moving joint (from 1) alone, proved to `JOINT_GAP` where it moves in all gaps."""
    from ocp_traj.solvers.per_joint import joint_task

    task = paper.task()
    moving = np.flatnonzero(np.ptp(task.waypoints, axis=0) > 0).tolist()
    return {joint + 1: certified_optimum(joint_task(task, joint), records, JOINT_GAP) for joint in moving}


def synchronised_optima(paper: Paper, optima: dict[int, dict[str, Any]]) -> list[float]:
    """Return the largest duration per gap over the joints that move in it, from each joint's own optimum."""
    from ocp_traj.solvers.per_joint import synchronise

    task = paper.task()
    durations = np.zeros((task.n, task.gaps))
    for joint, found in optima.items():
        durations[joint - 1] = found["durations"]
    return [float(h) for h in synchronise(task, durations)]


def path_length(task: TrajectoryTask, durations: list[float]) -> float:
    """Return the length of the tool's path, m, of the motion with these durations."""
    from ocp_traj.transcription import trajectory_from_durations

    assert task.robot is not None
    robot, motion = task.robot, trajectory_from_durations(task, durations)
    points = np.stack([robot.pose(q)[:3, 3] for q in motion(np.linspace(0, motion.duration, 2000))])
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


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
