"""The judge: one motion against one task, at every time, by its own means.

It uses only the task, the exact piecewise polynomial and Pinocchio's inverse dynamics (`Robot.torque`),
nothing of what the solvers are given.
"""

from __future__ import annotations

import numpy as np

from ocp_traj.audit.clearance import judge_clearance
from ocp_traj.audit.conditions import boundary_miss, duration_findings, waypoint_miss
from ocp_traj.audit.curves import constraint_peaks, speed_peaks
from ocp_traj.audit.kinematics import jumps, kinematic_peaks
from ocp_traj.audit.measures import further_peaks
from ocp_traj.audit.motion import Motion
from ocp_traj.audit.scale import smallest_scale
from ocp_traj.audit.torque import TorqueCurve, relative_bound, torque_curve, torque_peaks, torque_rate_peaks
from ocp_traj.audit.verdict import Extremum, Verdict
from ocp_traj.audit.waypoints import with_waypoint_times
from ocp_traj.exceptions import InputError
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

_UNRESOLVED = 1e-7


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
        The motion has another number of joints or waypoints than the task.
    """
    if trajectory.n != task.n:
        raise InputError(f"the trajectory has {trajectory.n} joints, expected {task.n}")
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return _judge(task, Motion.of(with_waypoint_times(task, trajectory)))


def _judge(task: TrajectoryTask, motion: Motion) -> Verdict:
    peaks = kinematic_peaks(task, motion) + jumps(task, motion)
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
    findings += collisions + waypoint_findings + boundary_findings
    late = duration_findings(task, motion)
    broken = [peak for peak in peaks if peak.broken and peak.limit != "clearance"]  # those are findings
    limits = _largest(peaks)
    feasible = not (broken or findings or late)
    return Verdict(
        feasible=feasible,
        duration=motion.trajectory.duration,
        worst=max(limits.values(), key=_by_ratio, default=None),
        limits=limits,
        peaks=tuple(peaks),
        waypoint_error=waypoint_error,
        boundary_error=boundary_error,
        smallest_feasible_scale=None if findings else smallest_scale(task, motion, peaks, torques, feasible),
        findings=tuple([str(peak) for peak in broken] + findings + late),
        torque_bound=0.0 if torques is None else relative_bound(task, torques),
        case=task.name,
        clearance=clearance,
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
    finite = (
        all(np.isfinite(values).all() for values in motion.extrema) and np.isfinite(motion.noise(3)).all()
    )
    return [] if finite else ["motion: its derivatives are too large to be judged in floating-point numbers"]


def _unresolved(task: TrajectoryTask, torques: TorqueCurve) -> list[str]:
    bound = relative_bound(task, torques)
    if torques.curve.resolved or bound <= _UNRESOLVED:
        return []
    return [f"torque: could only be bounded to {bound:.3g} of the limit, expected {_UNRESOLVED:g}"]
