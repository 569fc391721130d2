"""What velocity and acceleration limits rule out whatever the motion: proofs, each in one sentence.

Limits, durations and waypoints are widened by what the audit lets pass, so that no motion it accepts is ruled out.
"""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.audit.tolerances import DURATION_TOLERANCE, RATIO_TOLERANCE, WAYPOINT_TOLERANCE
from ocp_traj.references.bounds.double_integrator import JointLimits, feasible
from ocp_traj.task import TrajectoryTask

WIDER = 1.0 + 2.0 * RATIO_TOLERANCE
"""Factor on limits in proofs."""

PROOF_SECONDS = 5.0
"""Seconds at most for the certified lower bound of a duration."""


def cannot_stop(task: TrajectoryTask) -> str:
    """Return a sentence when an end moves so fast that the joint crosses a position limit before it could turn.

    A joint that leaves q with velocity v > 0 and has to be at rest or further back later travels v^2 / (2 B) first,
    with braking limit B. The end is the same, backwards in time; a lower limit is the same, mirrored.
    """
    position, acceleration = task.limits.get("position"), task.limits.get("acceleration")
    waypoints, velocity = np.asarray(task.waypoints), np.asarray(task.boundary.velocity)
    slack = np.asarray(task.tolerance) + WAYPOINT_TOLERANCE
    for side, word in ((0, "start"), (1, "end")):
        order = 1 if side == 0 else -1
        for joint in np.flatnonzero(velocity[side]):
            outwards = order * velocity[side, joint]  # positive: towards the upper limit as time runs away from it
            sign = np.sign(outwards)
            at = sign * waypoints[::order, joint]
            room = slack[::order, joint]
            turns = sign * order * velocity[1 - side, joint] <= 0 or bool((at[1:] + room[1:] <= at[0] - room[0]).any())
            limit = float((sign * position[:, int(sign > 0), joint]).max())
            braking = float(np.abs(acceleration[:, int(order * sign < 0), joint]).max()) * WIDER
            reached = at[0] - room[0] + outwards**2 / (2.0 * braking) * (1.0 - 1e-6)
            width = float(np.ptp(position[:, :, joint])) if np.isfinite(position[:, :, joint]).all() else abs(limit)
            if turns and np.isfinite(limit) and reached > limit + 2.0 * RATIO_TOLERANCE * max(width, 1e-12):
                gap = 1 if side == 0 else task.gaps
                return (
                    f"position: joint {joint + 1}, gap {gap}: with {velocity[side, joint]:.6g} rad/s (m/s) at the "
                    f"{word} the acceleration limit takes it to {sign * reached:.6g} at least, beyond the limit "
                    f"{sign * limit:.6g}."
                )
    return ""


def cannot_keep_durations(task: TrajectoryTask) -> str:
    """Return a sentence when no joint motion within velocity and acceleration limits has durations in their bounds.

    Looked at by joints, where all durations are bounded; exact where they are given.
    """
    total = float(np.asarray(task.objective.duration)[1])
    bounds = np.asarray(task.objective.gap_durations)
    shortest, longest = bounds[:, 0], np.minimum(bounds[:, 1], total)
    if not np.isfinite(longest).all() or not (longest > 0).all():
        return ""
    shortest = shortest * (1.0 - 2.0 * DURATION_TOLERANCE)
    longest = longest * (1.0 + 2.0 * DURATION_TOLERANCE)
    for joint in range(task.n):
        limits = _limits_of(task, joint, float(longest.sum()))
        if limits is None:
            continue
        for gap in range(1, task.gaps + 1):
            if not feasible(limits.part(0, gap), shortest[None, :gap], longest[None, :gap])[0]:
                return (
                    f"duration: joint {joint + 1}, gap {gap}: no motion within the velocity and acceleration limits "
                    "has durations in their bounds up to there."
                )
    return ""


def _limits_of(task: TrajectoryTask, joint: int, total: float) -> JointLimits | None:
    """Return one joint's limits, widened; None where its acceleration is not limited or a limit is zero."""
    acceleration = task.limits.get("acceleration")[:, :, [joint]] * WIDER
    velocity = task.limits.get("velocity")[:, :, [joint]] * WIDER
    given = np.asarray(task.boundary.velocity)[:, [joint]]
    if not np.isfinite(acceleration).all():
        return None
    reachable = np.abs(given).max() + np.abs(acceleration).max() * total
    fastest, slowest = np.minimum(velocity[:, 1], reachable), np.minimum(-velocity[:, 0], reachable)
    speeding, braking = acceleration[:, 1], -acceleration[:, 0]
    if min(side.min() for side in (fastest, slowest, speeding, braking)) <= 0:
        return None
    distance = np.diff(np.asarray(task.waypoints)[:, [joint]], axis=0)
    slack = np.asarray(task.tolerance)[:, [joint]] + WAYPOINT_TOLERANCE
    room = slack[1:] + slack[:-1]
    miss = 1e-7 * np.maximum(fastest, slowest).max()

    def about(value: Array) -> Array:
        return np.stack([value - miss, value + miss])

    return JointLimits(
        fastest, slowest, speeding, braking, distance - room, distance + room, about(given[0]), about(given[1])
    )


def proved_longer(task: TrajectoryTask, seconds: float | None) -> str:
    """Return a sentence when the certified kinematic bound is above the duration allowed in total.

    Parameters
    ----------
    task : TrajectoryTask
    seconds : float or None
        Left at most.
    """
    high = float(np.asarray(task.objective.duration)[1])
    if not np.isfinite(high) or not task.boundary.is_rest:
        return ""
    from ocp_traj.references import kinematic_bound  # loads CasADi and the search, seldom needed

    lower = kinematic_bound(task, time_limit=PROOF_SECONDS if seconds is None else min(seconds, PROOF_SECONDS)).lower
    if lower is None or lower * (1.0 - 1e-5) <= high:
        return ""
    return (
        f"duration: at most {high:.6g} s are allowed, but no motion within the velocity and acceleration limits takes "
        f"less than {lower:.6g} s."
    )
