"""Waypoints, boundary conditions and durations: what must be met rather than not exceeded."""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.audit.allowances import fractions_of, measures
from ocp_traj.audit.motion import Motion, nearest_index
from ocp_traj.audit.tolerances import BOUNDARY_TOLERANCE, DURATION_TOLERANCE, WAYPOINT_TOLERANCE
from ocp_traj.quantities import DERIVATIVES
from ocp_traj.task import TrajectoryTask


def waypoint_miss(task: TrajectoryTask, motion: Motion) -> tuple[float, list[str]]:
    """Return the largest distance of a joint from a waypoint's box, rad or m, and a sentence each one missed.

    At a breakpoint both pieces are asked.
    """
    first, last = (high for high, _ in motion.ends(0))
    times = motion.trajectory.waypoint_times
    after = np.concatenate([first, last[-1:]])
    before = np.concatenate([first[:1], last])
    index = nearest_index(motion.trajectory.breakpoints, times)
    distance = np.maximum(np.abs(after[index] - task.waypoints), np.abs(before[index] - task.waypoints))
    miss = np.maximum(distance - task.tolerance, 0.0)
    findings = []
    for waypoint in np.flatnonzero((miss > WAYPOINT_TOLERANCE).any(axis=1)):
        joint = int(np.argmax(miss[waypoint]))
        findings.append(
            f"waypoint {waypoint + 1}: joint {joint + 1} misses it by {miss[waypoint, joint]:.6g} rad (m) "
            f"at {times[waypoint]:.6g} s, allowed {WAYPOINT_TOLERANCE:g}"
        )
    return float(miss.max()), findings


def boundary_miss(task: TrajectoryTask, motion: Motion) -> tuple[float, list[str]]:
    """Return the largest miss of a boundary condition relative to its limit, and a sentence each one missed.

    Without a limit (or with a limit of 0) the motion's largest value of that derivative is the measure.
    """
    largest, findings = 0.0, []
    for order in (1, 2, 3):
        wanted: Array | None = getattr(task.boundary, DERIVATIVES[order])
        if wanted is None:
            continue
        first, last = (high for high, _ in motion.ends(order))
        measure = measures(task, motion, order)
        for row, (name, given, piece) in enumerate((("start", first[0], 0), ("end", last[-1], -1))):
            relative = fractions_of(np.abs(given - wanted[row]), measure[piece])
            joint = int(np.argmax(relative))
            largest = max(largest, float(relative[joint]))
            if not relative[joint] <= BOUNDARY_TOLERANCE:
                findings.append(
                    f"boundary {DERIVATIVES[order]} at the {name}: joint {joint + 1} has {given[joint]:.9g}, "
                    f"expected {wanted[row][joint]:.9g}"
                )
    return largest, findings


def free_end_notes(task: TrajectoryTask, motion: Motion) -> list[str]:
    """Return a sentence where the jerk is limited, but the acceleration jumps at an end of the motion.

    The task leaves such an acceleration free: at that instant the jerk has no value that a limit could bound.
    """
    limited = np.isfinite(task.limits.get("jerk")).any(axis=(0, 1))
    first, last = (high for high, _ in motion.ends(2))
    allowed = BOUNDARY_TOLERANCE * measures(task, motion, 2)
    ends = (("starts", np.abs(first[0]) > allowed[0]), ("ends", np.abs(last[-1]) > allowed[-1]))
    where = [(name, np.flatnonzero(moving & limited) + 1) for name, moving in ends]
    return [
        f"the motion {name} with an acceleration other than 0 (joint {', '.join(map(str, joints))}): "
        "the jerk at that instant is not limited"
        for name, joints in where
        if joints.size
    ]


def duration_findings(task: TrajectoryTask, motion: Motion) -> list[str]:
    """Return a sentence for each duration outside its bounds."""
    findings = []
    lower, upper = np.asarray(task.objective.duration, dtype=np.float64)
    duration = motion.trajectory.duration
    if not _within(duration, lower, upper):
        findings.append(
            f"duration: {duration:.9g} s in total, expected between {lower:.9g} and {upper:.9g} s"
        )
    gap_bounds = np.asarray(task.objective.gap_durations, dtype=np.float64)
    lengths = motion.trajectory.segment_durations
    for gap, (length, bounds) in enumerate(zip(lengths, gap_bounds, strict=True)):
        if not _within(length, *bounds):
            findings.append(
                f"duration of gap {gap + 1}: {length:.9g} s, "
                f"expected between {bounds[0]:.9g} and {bounds[1]:.9g} s"
            )
    return findings


def moments_findings(task: TrajectoryTask, motion: Motion) -> list[str]:
    """Return a sentence for every two waypoints that differ and are passed at the same time."""
    same_time = np.diff(motion.trajectory.waypoint_times) == 0
    differ = (task.waypoints[1:] != task.waypoints[:-1]).any(axis=1)
    return [
        f"waypoints {gap + 1} and {gap + 2} differ, but both are passed at "
        f"{motion.trajectory.waypoint_times[gap]:.6g} s"
        for gap in np.flatnonzero(same_time & differ)
    ]


def _within(value: float, lower: float, upper: float) -> bool:
    return bool(lower * (1 - DURATION_TOLERANCE) <= value <= upper * (1 + DURATION_TOLERANCE))


def scale_bounds(task: TrajectoryTask, motion: Motion) -> tuple[float, float]:
    """Return the smallest and largest uniform slowing that the bounds on durations allow."""
    lengths = np.concatenate([[motion.trajectory.duration], motion.trajectory.segment_durations])
    bounds = np.concatenate([[task.objective.duration], np.asarray(task.objective.gap_durations)])
    lower, upper = (fractions_of(side, lengths) for side in bounds.T)
    return float(lower.max()), float(np.where(lengths > 0, upper, np.inf).min())
