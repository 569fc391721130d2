"""Which branch to take: whole turns within the joint limits, and paper C's weighted nearest rule."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.arrays import Array

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot

_TURN = 2.0 * np.pi
_LIMIT_SLACK = 1e-9  # rad or m: a solution this far outside of a limit is put on it


def nearest_turns(robot: Robot, q: Array, previous: Array) -> Array:
    """Return positions `q` (..., n), each angle in the turn nearest to `previous` within its limits.

    An angle that no turn brings within its limits becomes NaN.
    """
    lower, upper = robot.position_limits
    turning = np.array([kind != "prismatic" for kind in robot.joint_types])
    turn = np.where(turning, _TURN, 0.0)
    moved = q + turn * np.round((previous - q) / _TURN)
    over, under = moved > upper + _LIMIT_SLACK, moved < lower - _LIMIT_SLACK
    with np.errstate(invalid="ignore"):
        moved = np.where(over, moved - turn * np.ceil((moved - upper - _LIMIT_SLACK) / _TURN), moved)
        moved = np.where(under, moved + turn * np.ceil((lower - _LIMIT_SLACK - moved) / _TURN), moved)
    outside = (moved > upper + _LIMIT_SLACK) | (moved < lower - _LIMIT_SLACK)
    return np.where(outside, np.nan, np.clip(moved, lower, upper))


def nearest_branch(robot: Robot, branches: Array, previous: Array, weights: Array) -> int | None:
    """Return the row of `branches` (B, n) that the weighted nearest rule takes; turns are chosen before.

    The rule of paper C (its equation is lost, the words remain): argmin over branches of sum_m w_m |theta_m -
    q_m|. Rows with NaN are left out; None if there is no other.
    """
    distance = np.abs(branches - previous) @ weights
    if not np.isfinite(distance).any():
        return None
    return int(np.nanargmin(distance))
