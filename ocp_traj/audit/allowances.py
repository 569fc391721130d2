"""What rounding may add up to: absolute allowances for a whole motion, one sum for every joint.

None of them depends on the length or the degree of a piece, and none is granted a second time: a motion cut into
a million pieces has no more of it than a motion of one piece.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.audit.motion import Motion
from ocp_traj.quantities import DERIVATIVES, JOINT_LIMITS
from ocp_traj.task import TrajectoryTask

AFTER_JUMP: tuple[tuple[str, ...], ...] = tuple(
    tuple(name for name, row in JOINT_LIMITS.items() if row.order > order) for order in range(3)
)
"""What is infinite where a derivative of this order jumps."""


def smaller_side(task: TrajectoryTask, motion: Motion, name: str) -> Array:
    """Return the smaller magnitude of the two sides of a limit in every piece, (m, n)."""
    magnitude: Array = np.abs(task.limits.get(name)).min(axis=1)[motion.gaps]
    return magnitude


def measures(task: TrajectoryTask, motion: Motion, order: int) -> Array:
    """Return what changes of a derivative are fractions of, (m, n), in each piece; 1 for positions.

    It is the limit, or the motion's largest value where there is no limit or it is 0.
    """
    if order == 0:
        return np.ones((len(motion.starts), motion.n))
    limit = smaller_side(task, motion, DERIVATIVES[order])
    return np.where(np.isfinite(limit) & (limit > 0), limit, motion.largest[order].max())


def fractions_of(changes: Array, measure: Array) -> Array:
    """Return changes as fractions of their measure; 0/0 is 0, and what is no number infinite."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        part = np.where(changes == 0, 0.0, changes / measure)
    return np.where(np.isnan(part), np.inf, part)


def limited_knots(task: TrajectoryTask, motion: Motion, names: Sequence[str]) -> Array:
    """Return where two pieces meet and one of `names` is limited on either side, (m - 1, n).

    Torques couple the joints: the limit of one forbids jumps of all.
    """
    limited = np.zeros((len(motion.starts) - 1, motion.n), dtype=bool)
    for name in names:
        finite = np.isfinite(smaller_side(task, motion, name))
        either = finite[1:] | finite[:-1]
        limited |= either.any(axis=1, keepdims=True) if name.startswith("torque") else either
    return limited
