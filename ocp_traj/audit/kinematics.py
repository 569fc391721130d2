"""Position, velocity, acceleration and jerk against their limits, at every time, and jumps between pieces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ocp_traj.arrays import Array
from ocp_traj.audit.motion import Motion
from ocp_traj.audit.verdict import RATIO_TOLERANCE, WAYPOINT_TOLERANCE, Extremum
from ocp_traj.quantities import DERIVATIVES, JOINT_LIMITS
from ocp_traj.task import TrajectoryTask

_AFTER_JUMP = {
    order: tuple(name for name, row in JOINT_LIMITS.items() if row.order > order) for order in range(3)
}
"""What is infinite where a derivative of this order jumps."""


def side_ratios(values: Array, lower: Array, upper: Array, noise: Array | float = 0.0) -> Array:
    """Return value over the limit on its own side; 0/0 is 0, x/0 infinite, and what is no number infinite.

    Against a limit of 0, values up to `noise` count as 0: rounding makes them.
    """
    limit = np.where(values >= 0, upper, -lower) + 0.0  # -0.0 becomes 0.0: over it lies plus infinity
    magnitude = np.where((limit == 0) & (np.abs(values) <= noise), 0.0, np.abs(values))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = np.where(magnitude == 0, 0.0, magnitude / limit)
    ratio = np.where(np.isinf(limit) & np.isfinite(values), 0.0, ratio)
    return np.where(np.isnan(ratio), np.inf, ratio)


def range_ratios(
    values: Array, lower: Array, upper: Array, width: Array, noise: Array | float = 0.0
) -> Array:
    """Return 1 + excess / width; inside the range the excess is negative and the ratio between 0 and 1.

    `width` is upper - lower; where only one side is finite the caller gives a stand-in.
    """
    with np.errstate(invalid="ignore"):
        excess = np.maximum(lower - values, values - upper)
    excess = np.where(np.abs(excess) <= noise, 0.0, excess)
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.where(excess == 0, 0.0, excess / width)
    ratio = np.maximum(1.0 + part, 0.0)
    return np.where(np.isnan(ratio), np.inf, ratio)


def position_width(task: TrajectoryTask) -> Array:
    """Return upper - lower of the positions, (G, 1, n).

    A range with one finite end has no width; the distance from that end to the farthest waypoint stands in
    for it (1 rad or m when that is 0).
    """
    lower, upper = np.split(task.limits.get("position"), 2, axis=1)
    end = np.where(np.isfinite(upper), upper, np.where(np.isfinite(lower), lower, 0.0))
    reach = np.abs(task.waypoints - end).max(axis=1, keepdims=True)
    reach = np.where(reach > 0, reach, 1.0)
    width = upper - lower
    return np.where(np.isfinite(width), width, reach)


def kinematic_peaks(task: TrajectoryTask, motion: Motion) -> list[Extremum]:
    """Return the largest ratio of every limited joint and kinematic limit."""
    peaks: list[Extremum] = []
    for order, name in enumerate(DERIVATIVES):
        if not task.limited(name):
            continue
        limits = task.limits.get(name)[motion.gaps]
        lower, upper = limits[:, 0, :, None], limits[:, 1, :, None]
        values, noise = motion.extrema[order], motion.noise(order)[:, :, None]
        if order == 0:
            width = position_width(task)[motion.gaps][:, 0, :, None]
            ratios = range_ratios(values, lower, upper, width, noise)
        else:
            ratios = side_ratios(values, lower, upper, noise)
        for joint in np.flatnonzero(np.isfinite(limits).any(axis=(0, 1))):
            piece, point = np.unravel_index(int(np.argmax(ratios[:, joint])), ratios[:, joint].shape)
            value = float(values[piece, joint, point])
            peaks.append(
                Extremum(
                    limit=name,
                    joint=int(joint),
                    time=float(
                        motion.starts[piece]
                        + motion.durations[piece] * motion.candidates[order][piece, joint, point]
                    ),
                    ratio=float(ratios[piece, joint, point]),
                    gap=int(motion.gaps[piece]),
                    value=value,
                    bound=_bound(value, limits[piece, :, joint], order == 0),
                )
            )
    return peaks


def _bound(value: float, limits: Array, centred: bool) -> float:
    """Return the limit that a value is nearest to (positions) or that lies on its side of zero."""
    lower, upper = limits
    above = (value - upper >= lower - value) if centred else value >= 0
    return float(upper if above else lower)


def jumps(task: TrajectoryTask, motion: Motion) -> list[Extremum]:
    """Return an infinite ratio for everything that a jump between pieces makes infinite.

    A position may jump by 1e-8 (at most 1e-6 of the motion's travel), velocity and acceleration by 1e-6 of
    their limit, or of the motion's largest value without one, always plus what rounding can make. A jump of a
    position is always wrong; one of the velocity where acceleration, jerk, torque or torque rate are limited;
    one of the acceleration where jerk or torque rate are.
    """
    found: list[Extremum] = []
    for order, names in _AFTER_JUMP.items():
        first, last = motion.ends(order)
        step = np.abs(first[1:] - last[:-1])
        noise = motion.noise(order)
        jumping = step > _jump_allowance(task, motion, order) + noise[1:] + noise[:-1]
        if jumping.any():
            for name in names:
                found.extend(_infinite(task, motion, (order, name), step, jumping))
    return found


def _jump_allowance(task: TrajectoryTask, motion: Motion, order: int) -> Array:
    if order == 0:
        return np.full(
            (len(motion.starts) - 1, motion.n), min(WAYPOINT_TOLERANCE, RATIO_TOLERANCE * motion.travel)
        )
    smallest = np.abs(task.limits.get(DERIVATIVES[order])).min(axis=1)[motion.gaps]
    limit = np.minimum(smallest[1:], smallest[:-1])
    reference = np.where(np.isfinite(limit) & (limit > 0), limit, motion.largest[order].max())
    return RATIO_TOLERANCE * reference


def _infinite(
    task: TrajectoryTask,
    motion: Motion,
    order_and_name: tuple[int, str],
    step: Array,
    jumping: NDArray[np.bool_],
) -> list[Extremum]:
    """Return the largest jump of each joint (steps (m - 1, n)) that breaks a limit on either side of it.

    Torques couple the joints: a jump of any joint breaks the torque limit of any other.
    """
    order, name = order_and_name
    smallest = np.abs(task.limits.get(name)).min(axis=1)[motion.gaps]
    limit = np.minimum(smallest[1:], smallest[:-1])
    limited = np.isfinite(limit)
    if order == 0 and name == "velocity":
        limited = np.ones_like(limited)
    coupled = limited.any(axis=1, keepdims=True) if name.startswith("torque") else limited
    found = []
    for joint in np.flatnonzero((jumping & coupled).any(axis=0)):
        index = int(np.argmax(np.where(jumping & coupled, step, -1.0)[:, joint]))
        blamed = int(joint) if limited[index, joint] else int(np.argmax(limited[index]))
        found.append(
            Extremum(
                limit=name,
                joint=blamed,
                time=float(motion.starts[index + 1]),
                ratio=np.inf,
                gap=int(motion.gaps[index + 1]),
                value=np.inf,
                bound=float(limit[index, blamed]),
                note=f"the {DERIVATIVES[order]} of joint {joint + 1} jumps by {step[index, joint]:.6g}",
            )
        )
    return found
