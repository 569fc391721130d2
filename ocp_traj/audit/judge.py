"""The judge: one motion against one task, at every time, by its own means.

It uses only the task, the exact piecewise polynomial and Pinocchio's inverse dynamics (`Robot.torque`),
nothing of what the solvers are given.
"""

from __future__ import annotations

import numpy as np

from ocp_traj.audit.clearance.judging import judge_clearance, stays_clear
from ocp_traj.audit.conditions import (
    boundary_miss,
    duration_findings,
    free_end_notes,
    moments_findings,
    waypoint_miss,
)
from ocp_traj.audit.curves import constraint_peaks, speed_peaks
from ocp_traj.audit.kinematics import changes_of, jump_peaks, kinematic_peaks
from ocp_traj.audit.measures import further_peaks
from ocp_traj.audit.motion import Motion
from ocp_traj.audit.scale import smallest_scale
from ocp_traj.audit.torque import TorqueCurve, relative_bound, torque_curve, torque_peaks, torque_rate_peaks
from ocp_traj.audit.verdict import Extremum, Verdict
from ocp_traj.audit.waypoints import with_waypoint_times
from ocp_traj.exceptions import InputError
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.trajectory_files import MAX_DEGREE

_UNRESOLVED = 1e-7
_TIMES_NOTED = 8


def audit(task: TrajectoryTask, trajectory: Trajectory) -> Verdict:
    """Judge a motion, ours or published, against a task's limits, waypoints, ends and durations.

    Parameters
    ----------
    task : TrajectoryTask
        What was asked for.
    trajectory : Trajectory
        The exact motion; its family need not be the task's.

    Returns
    -------
    Verdict

    Raises
    ------
    InputError
        The motion has another number of joints or waypoints than the task, or pieces of a degree above 30.
    """
    if trajectory.n != task.n:
        raise InputError(f"the trajectory has {trajectory.n} joints, expected {task.n}")
    if trajectory.degree > MAX_DEGREE:
        raise InputError(f"the trajectory has degree {trajectory.degree}, expected at most {MAX_DEGREE}")
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        motion = Motion.of(with_waypoint_times(task, trajectory))
        named = len(trajectory.waypoint_times) == len(task.waypoints)
        return _judge(task, motion, [] if named else [_times_note(motion)])


def _judge(task: TrajectoryTask, motion: Motion, notes: list[str]) -> Verdict:
    changes = changes_of(task, motion)
    peaks = kinematic_peaks(task, motion, changes) + jump_peaks(task, motion, changes)
    torques, findings = None, _out_of_range(motion)
    if task.limited("torque") or task.limited("torque_rate"):
        torques = torque_curve(task, motion)
        peaks += torque_peaks(task, torques) if task.limited("torque") else []
        peaks += torque_rate_peaks(task, torques) if task.limited("torque_rate") else []
        findings += _unresolved(task, torques)
    for judge in (speed_peaks, further_peaks, constraint_peaks):
        more_peaks, more_findings = judge(task, motion)
        peaks += more_peaks
        findings += more_findings
    clearance, clearance_peaks, collisions = judge_clearance(task, motion)
    peaks += clearance_peaks
    waypoint_error, waypoint_findings = waypoint_miss(task, motion)
    boundary_error, boundary_findings = boundary_miss(task, motion)
    findings += collisions + waypoint_findings + boundary_findings + moments_findings(task, motion)
    late = duration_findings(task, motion)
    broken = [peak for peak in peaks if peak.broken and peak.limit != "clearance"]  # those are findings
    limits = _largest(peaks)
    feasible = not (broken or findings or late)
    scale = None if findings else smallest_scale(task, motion, peaks, torques, feasible, changes.slowing)
    return Verdict(
        feasible=feasible,
        duration=motion.trajectory.duration,
        worst=max(limits.values(), key=_by_ratio, default=None),
        limits=limits,
        peaks=tuple(peaks),
        waypoint_error=waypoint_error,
        boundary_error=boundary_error,
        smallest_feasible_scale=scale if scale is not None and stays_clear(task, motion, scale) else None,
        findings=tuple([str(peak) for peak in broken] + findings + late),
        torque_bound=0.0 if torques is None else relative_bound(task, torques),
        case=task.name,
        clearance=clearance,
        notes=tuple(notes + free_end_notes(task, motion)),
    )


def _times_note(motion: Motion) -> str:
    times = ", ".join(f"{time:.6g}" for time in motion.trajectory.waypoint_times[1:-1][:_TIMES_NOTED])
    return (
        "the trajectory does not name the times at which it passes the waypoints; they were taken where it comes "
        f"nearest ({times}{', ...' if len(motion.trajectory.waypoint_times) - 2 > _TIMES_NOTED else ''} s), "
        "and other times may keep limits of gaps or tolerances that these do not"
    )


def _by_ratio(extremum: Extremum) -> float:
    return extremum.ratio


def _largest(peaks: list[Extremum]) -> dict[str, Extremum]:
    """Return the largest ratio of every limit, by name."""
    limits: dict[str, Extremum] = {}
    for peak in peaks:
        if peak.key not in limits or peak.ratio > limits[peak.key].ratio:
            limits[peak.key] = peak
    return limits


def _out_of_range(motion: Motion) -> list[str]:
    """Return a sentence when some derivative of the motion is too large for floating-point numbers."""
    sentence = "motion: its derivatives are too large to be judged in floating-point numbers"
    return [] if motion.is_in_range else [sentence]


def _unresolved(task: TrajectoryTask, torques: TorqueCurve) -> list[str]:
    bound = relative_bound(task, torques)
    if torques.curve.resolved or bound <= _UNRESOLVED:
        return []
    return [f"torque: could only be bounded to {bound:.3g} of the limit, expected {_UNRESOLVED:g}"]
