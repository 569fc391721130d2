"""Position, velocity, acceleration and jerk against their limits, at every time, and jumps between pieces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ocp_traj.arrays import Array
from ocp_traj.audit.allowances import (
    AFTER_JUMP,
    fractions_of,
    limited_knots,
    measures,
    smaller_side,
)
from ocp_traj.audit.motion import Motion
from ocp_traj.audit.tolerances import JUMPS, POSITION_JUMPS, RATIO_TOLERANCE
from ocp_traj.audit.verdict import Extremum
from ocp_traj.quantities import DERIVATIVES
from ocp_traj.task import TrajectoryTask


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


def kinematic_ratios(task: TrajectoryTask, motion: Motion, order: int) -> Array:
    """Return the ratios of one quantity at the candidates of its extrema, (m, n, C)."""
    limits = task.limits.get(DERIVATIVES[order])[motion.gaps]
    lower, upper = limits[:, 0, :, None], limits[:, 1, :, None]
    values = motion.extrema[order]
    if order > 0:
        return side_ratios(values, lower, upper)
    width = position_width(task)[motion.gaps][:, 0, :, None]
    narrow = np.where(RATIO_TOLERANCE * width < POSITION_JUMPS, POSITION_JUMPS, 0.0)
    return range_ratios(values, lower, upper, width, narrow)


def kinematic_peaks(task: TrajectoryTask, motion: Motion, changes: Changes) -> list[Extremum]:
    """Return the largest ratio of every limited joint and kinematic limit.

    Pieces whose excess is too short to matter count as at their limit, and as still where it is 0.
    """
    peaks: list[Extremum] = []
    for order, name in enumerate(DERIVATIVES):
        if not task.limited(name):
            continue
        limits = task.limits.get(name)[motion.gaps]
        values, ratios = motion.extrema[order], kinematic_ratios(task, motion, order)
        if order > 0:
            limit = _side_limits(values, limits)
            kept = np.where(limit == 0, 0.0, np.minimum(ratios, 1.0))
            ratios = np.where(changes.forgiven[order - 1][:, :, None], kept, ratios)
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


@dataclass(frozen=True)
class Changes:
    """How much position, velocity and acceleration change in no time, or faster than their derivative's limit.

    Attributes
    ----------
    steps : tuple of 3 (m - 1, n) arrays
        Jumps between pieces, SI.
    fractions : tuple of 3 (m - 1, n) arrays
        The same as fractions of the limit, rad or m for positions; 0 where nothing limited follows.
    jumps : (3, n) array
        Sums of `fractions` over the motion.
    totals : (3, n) array
        The same with what pieces above a limit of the next derivative change beyond it: excess times duration.
    forgiven : tuple of 3 (m, n) bool arrays
        Pieces above a limit of velocity, acceleration, jerk by no more than rounding the positions can make, or
        above a limit of 0, where the changes, summed over the motion with all jumps, are within the allowance.
    """

    steps: tuple[Array, ...]
    fractions: tuple[Array, ...]
    jumps: Array
    totals: Array
    forgiven: tuple[NDArray[np.bool_], ...]

    @property
    def slowing(self) -> float:
        """Smallest slowing, at most 1, that keeps the sums within their allowances."""
        with np.errstate(invalid="ignore"):
            needed = (self.totals / np.array(JUMPS)[:, None])[1:] ** np.array([[1.0], [0.5]])
        return float(min(needed.max(), 1.0))


def changes_of(task: TrajectoryTask, motion: Motion) -> Changes:
    """Return what a motion changes in no time or beyond what limits let it, added up for every joint."""
    steps, parts, forgiven = [], [], []
    jumps, totals = np.zeros((len(JUMPS), motion.n)), np.zeros((len(JUMPS), motion.n))
    for order, allowed in enumerate(JUMPS):
        measure = measures(task, motion, order)
        step = motion.steps(order)
        counted = limited_knots(task, motion, AFTER_JUMP[order]) if order else np.ones(step.shape, dtype=bool)
        part = fractions_of(np.where(counted, step, 0.0), np.minimum(measure[1:], measure[:-1]))
        excess, still = _excess(task, motion, order + 1)
        jumps[order] = part.sum(axis=0)
        beyond = fractions_of(excess * motion.durations[:, None], measure).sum(axis=0)
        totals[order] = jumps[order] + beyond
        steps.append(step)
        parts.append(part)
        rounded = still | (excess <= motion.noise(order + 1))
        forgiven.append((excess > 0) & rounded & (totals[order] <= allowed))
    return Changes(tuple(steps), tuple(parts), jumps, totals, tuple(forgiven))


def _side_limits(values: Array, limits: Array) -> Array:
    """Return the limit on the side of each value (m, n, C), as a magnitude; limits are (m, 2, n)."""
    return np.where(values >= 0, limits[:, 1, :, None], -limits[:, 0, :, None])


def _excess(task: TrajectoryTask, motion: Motion, order: int) -> tuple[Array, NDArray[np.bool_]]:
    """Return by how much each piece exceeds the limit of a derivative, SI, and where that limit is 0, each (m, n).

    Up to 1 + 1e-6 of a limit is no excess.
    """
    if not task.limited(DERIVATIVES[order]):
        shape = len(motion.starts), motion.n
        return np.zeros(shape), np.zeros(shape, dtype=bool)
    values, ratios = motion.extrema[order], kinematic_ratios(task, motion, order)
    limit = _side_limits(values, task.limits.get(DERIVATIVES[order])[motion.gaps])
    broken = ~(ratios <= 1.0 + RATIO_TOLERANCE)
    over = np.where(broken, np.abs(values) - limit, 0.0)
    return np.where(np.isnan(over), np.inf, over).max(axis=2), ~(broken & (limit != 0)).any(axis=2)


def jump_peaks(task: TrajectoryTask, motion: Motion, changes: Changes) -> list[Extremum]:
    """Return an infinite ratio for everything that jumps between pieces make infinite.

    A jump of a position is always wrong; one of the velocity where acceleration, jerk, torque or torque rate are
    limited; one of the acceleration where jerk or torque rate are. All jumps of a joint count together.
    """
    found: list[Extremum] = []
    for order, allowed in enumerate(JUMPS):
        jumping = ~(changes.jumps[order] <= allowed)
        if not jumping.any():
            continue
        for name in AFTER_JUMP[order]:
            limited = limited_knots(task, motion, (name,))
            if order == 0 and name == "velocity":
                limited = np.ones_like(limited)
            share = np.where(limited, changes.fractions[order], 0.0)
            large = ~(share.sum(axis=0) < changes.jumps[order] / len(AFTER_JUMP[order]))
            for joint in np.flatnonzero(jumping & large):
                found.append(_infinite(task, motion, changes, (order, name), (int(joint), share[:, joint])))
    return found


def _infinite(
    task: TrajectoryTask,
    motion: Motion,
    changes: Changes,
    order_and_name: tuple[int, str],
    joint_and_share: tuple[int, Array],
) -> Extremum:
    """Return the extremum at a joint's largest jump; the joint blamed is one that has the limit."""
    order, name = order_and_name
    joint, share = joint_and_share
    smallest = smaller_side(task, motion, name)
    index = int(np.argmax(share))
    limit = np.minimum(smallest[1:], smallest[:-1])[index]
    blamed = joint if np.isfinite(limit[joint]) or np.isinf(limit).all() else int(np.argmin(np.isinf(limit)))
    steps = changes.steps[order][:, joint]
    note = f"the {DERIVATIVES[order]} of joint {joint + 1} jumps by {steps[index]:.6g}"
    if share[index] <= JUMPS[order]:
        note += f" and, all jumps together, by {steps[share > 0].sum():.6g}"
    return Extremum(
        limit=name,
        joint=blamed,
        time=float(motion.starts[index + 1]),
        ratio=np.inf,
        gap=int(motion.gaps[index + 1]),
        value=np.inf,
        bound=float(limit[blamed]),
        note=note,
    )
