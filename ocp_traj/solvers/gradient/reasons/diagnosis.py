"""Why a task has no solution: conflicts that are certain before anything is solved, and what stood in the way."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.limits.limit import bound_scales
from ocp_traj.quantities import JOINT_LIMITS, RATES
from ocp_traj.solvers.gradient.reasons.reach import cannot_keep_durations, cannot_stop
from ocp_traj.task import Objective, TrajectoryTask


def certain_conflict(task: TrajectoryTask) -> str:
    """Return a sentence when no motion whatever can solve the task, else an empty one."""
    return (
        _zero_limit(task)
        or _boundary_outside(task)
        or _end_torque(task)
        or _too_fast(task)
        or cannot_stop(task)
        or cannot_keep_durations(task)
    )


def _zero_limit(task: TrajectoryTask) -> str:
    slack = np.asarray(task.tolerance)
    least = np.abs(np.diff(task.waypoints, axis=0)) - slack[1:] - slack[:-1]
    signed = np.diff(task.waypoints, axis=0)
    for name in RATES:
        limits = task.limits.get(name)
        for gap, joint in np.argwhere(least > 0):
            lower, upper = limits[gap, :, joint]
            stuck = lower == 0 == upper and (name == "velocity" or _starts_still(task, gap, joint))
            wrong_way = name == "velocity" and (upper == 0 if signed[gap, joint] > 0 else lower == 0)
            if stuck or wrong_way:
                return (
                    f"{name}: joint {joint + 1}, gap {gap + 1}: the limit is 0, but the joint must move by "
                    f"{signed[gap, joint]:.6g}."
                )
    return ""


def _starts_still(task: TrajectoryTask, gap: int, joint: int) -> bool:
    """Return whether a joint enters or leaves a gap at rest, so that it cannot move without acceleration."""
    velocity = np.asarray(task.boundary.velocity)
    acceleration = task.boundary.acceleration
    still = [velocity[side, joint] == 0 for side in (0, 1)]
    if acceleration is not None:
        still = [flag and np.asarray(acceleration)[side, joint] == 0 for side, flag in enumerate(still)]
    return bool((gap == 0 and still[0]) or (gap == task.gaps - 1 and still[1]))


def _boundary_outside(task: TrajectoryTask) -> str:
    for name in RATES:
        given = getattr(task.boundary, name)
        if given is None:
            continue
        for side, gap, word in ((0, 0, "start"), (1, task.gaps - 1, "end")):
            lower, upper = task.limits.get(name)[gap]
            value = np.asarray(given)[side]
            outside = np.flatnonzero((value > upper * (1 + 1e-12)) | (value < lower * (1 + 1e-12)))
            if len(outside):
                joint = int(outside[0])
                return (
                    f"{name}: joint {joint + 1}, gap {gap + 1}: {value[joint]:.6g} {JOINT_LIMITS[name].unit} is asked "
                    f"for at the {word}, outside the limits {lower[joint]:.6g} to {upper[joint]:.6g}."
                )
    return ""


def _end_torque(task: TrajectoryTask) -> str:
    """Look at the ends: the velocity is given there, so the torque is affine in the acceleration.

    Where the acceleration is given, too, the torque is a number; else a linear program finds the acceleration within
    its limits that exceeds the torque limits least.
    """
    if not task.limited("torque") or np.any(np.asarray(task.tolerance)[[0, -1]]):
        return ""
    for side, gap, number in ((0, 0, 1), (-1, task.gaps - 1, len(task.waypoints))):
        lower, upper = task.limits.get("torque")[gap]
        torque = _least_torque(task, side, gap)
        over = np.maximum(torque - upper, lower - torque)
        joint = int(np.argmax(over / bound_scales(np.stack([lower, upper]))))
        if over[joint] > 1e-7 * max(abs(torque[joint]), 1e-300):
            return (
                f"torque: joint {joint + 1}, gap {gap + 1}: {torque[joint]:.6g} N m are needed at waypoint "
                f"{number}{_whatever(task)}, outside the limits {lower[joint]:.6g} to {upper[joint]:.6g}."
            )
    return ""


def _whatever(task: TrajectoryTask) -> str:
    return "" if task.boundary.acceleration is not None else " whatever the acceleration within its limits"


def _least_torque(task: TrajectoryTask, side: int, gap: int) -> Array:
    """Return the torques (n,) at one end that exceed their limits least, N m."""
    assert task.robot is not None
    q, v = task.waypoints[[side]], np.asarray(task.boundary.velocity)[[side]]
    if task.boundary.acceleration is not None:
        return task.robot.torque(q, v, np.asarray(task.boundary.acceleration)[[side]])[0]
    still = task.robot.torque(q, v, np.zeros_like(q))[0]
    inertia = np.stack([task.robot.torque(q, v, unit[None])[0] - still for unit in np.eye(task.n)], axis=1)
    lower, upper = task.limits.get("torque")[gap]
    scale = bound_scales(np.stack([lower, upper]))[:, None]
    rows = np.block([[inertia, -scale], [-inertia, -scale]])
    room = np.concatenate([upper - still, still - lower])
    finite = np.isfinite(room)
    acceleration = [tuple(bounds) for bounds in task.limits.get("acceleration")[gap].T]
    cost = np.append(np.zeros(task.n), 1.0)
    from scipy.optimize import linprog  # its package takes longer to load than many a solve

    found = linprog(cost, rows[finite], room[finite], bounds=[*acceleration, (0.0, None)])
    if not found.success:  # every torque can be reached, by the solver's own tolerance
        return np.asarray(np.clip(still, lower, upper), dtype=np.float64)
    return still + inertia @ found.x[:-1]


def _too_fast(task: TrajectoryTask) -> str:
    """Compare the durations allowed with the travel at full speed."""
    slack = np.asarray(task.tolerance)
    travel = np.diff(task.waypoints, axis=0)
    least = np.maximum(np.abs(travel) - slack[1:] - slack[:-1], 0.0)
    limit = task.limits.get("velocity")
    speed = np.where(travel > 0, limit[:, 1], -limit[:, 0])
    needed = np.divide(least, speed, out=np.zeros_like(least), where=(least > 0) & (speed > 0))
    gaps, total = needed.max(axis=1), np.asarray(task.objective.duration)[1]
    for gap, most in enumerate(np.asarray(task.objective.gap_durations)[:, 1]):
        if gaps[gap] > most * (1 + 1e-9):
            joint = int(np.argmax(needed[gap]))
            return (
                f"duration: gap {gap + 1}: at most {most:.6g} s are allowed, but joint {joint + 1} needs "
                f"{gaps[gap]:.6g} s at its velocity limit."
            )
    if gaps.sum() > total * (1 + 1e-9):
        return (
            f"duration: at most {total:.6g} s are allowed in total, but the velocity limits alone need "
            f"{gaps.sum():.6g} s."
        )
    return ""


def too_short(task: TrajectoryTask, shortest: Callable[[TrajectoryTask, bool], float | None]) -> str:
    """Return a sentence when the total duration is bounded and the shortest motion found is longer: no proof.

    Parameters
    ----------
    shortest : callable
        Solves a task, with its limits kept at first samples only (true) or everywhere, and returns the duration,
        None where it found none.
    """
    high = float(np.asarray(task.objective.duration)[1])
    if not np.isfinite(high):
        return ""
    fastest = task.changed(objective=Objective(time=1.0, gap_durations=task.objective.gap_durations))
    for sampled, words in ((True, "even with limits kept at samples only, "), (False, "")):
        found = shortest(fastest, sampled)
        if found is None:
            return ""
        if found > high * (1 + 1e-9):
            return f"duration: at most {high:.6g} s are allowed, {words}the shortest motion found takes {found:.6g} s."
    return ""
