"""Position, velocity, acceleration and jerk against their limits, at every time, and jumps between pieces."""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.audit.motion import ORDERS, Motion
from ocp_traj.audit.verdict import RATIO_TOLERANCE, WAYPOINT_TOLERANCE, Extremum
from ocp_traj.task import TrajectoryTask

_AFTER_JUMP = {
    0: ("velocity", "acceleration", "jerk", "torque", "torque_rate"),
    1: ("acceleration", "jerk", "torque", "torque_rate"),
    2: ("jerk", "torque_rate"),
}
"""What is infinite where a derivative of this order jumps."""


def side_ratios(values: Array, lower: Array, upper: Array, noise: Array | float = 0.0) -> Array:
    """Return value over the limit on its own side; 0/0 is 0, x/0 infinite, and what is no number infinite.

    Against a limit of 0, values up to `noise` count as 0: rounding makes them.
    """
    limit = np.where(values >= 0, upper, -lower)
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
    for order, name in enumerate(ORDERS):
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
    for order in (0, 1, 2):
        first, last = motion.ends(order)
        step = np.abs(first[1:] - last[:-1])
        noise = motion.noise(order)
        allowed = _jump_allowance(task, motion, order) + noise[1:] + noise[:-1]
        with np.errstate(divide="ignore", invalid="ignore"):
            excess = np.where(step > allowed, step / allowed, 0.0)
        for joint in np.flatnonzero((step > allowed).any(axis=0)):
            breakpoint_index = int(np.argmax(excess[:, joint]))
            found.extend(
                _infinite(
                    task,
                    motion,
                    order,
                    int(joint),
                    breakpoint_index + 1,
                    float(step[breakpoint_index, joint]),
                )
            )
    return found


def _jump_allowance(task: TrajectoryTask, motion: Motion, order: int) -> Array:
    if order == 0:
        return np.full(
            (len(motion.starts) - 1, motion.n), min(WAYPOINT_TOLERANCE, RATIO_TOLERANCE * motion.travel)
        )
    limits = task.limits.get(ORDERS[order])[motion.gaps[1:]]
    limit = np.abs(limits).min(axis=1)
    reference = np.where(np.isfinite(limit) & (limit > 0), limit, motion.largest[order].max())
    allowance: Array = RATIO_TOLERANCE * reference
    return allowance


def _infinite(
    task: TrajectoryTask, motion: Motion, order: int, joint: int, piece: int, step: float
) -> list[Extremum]:
    note = f"the {ORDERS[order]} jumps by {step:.6g}"
    found = []
    for name in _AFTER_JUMP[order]:
        limit = np.abs(task.limits.get(name)[motion.gaps[piece]]).min(axis=0)
        limited = np.flatnonzero(np.isfinite(limit))
        always = order == 0 and name == "velocity"
        if name.startswith("torque") and limited.size:
            index = joint if joint in limited else int(limited[0])
        elif joint in limited or always:
            index = joint
        else:
            continue
        found.append(
            Extremum(
                limit=name,
                joint=index,
                time=float(motion.starts[piece]),
                ratio=np.inf,
                gap=int(motion.gaps[piece]),
                value=np.inf,
                bound=float(limit[index]),
                note=note,
            )
        )
    return found
