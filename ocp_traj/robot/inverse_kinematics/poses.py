"""From Cartesian waypoints to joint waypoints."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from ocp_traj.arrays import Array, ArrayLike
from ocp_traj.exceptions import InputError, RobotError, UnreachablePoseError
from ocp_traj.robot.additions import vector
from ocp_traj.robot.inverse_kinematics.branch_choice import nearest_branch, nearest_turns
from ocp_traj.robot.inverse_kinematics.closed_form import FACTORS, SINGULAR, ClosedForm
from ocp_traj.robot.inverse_kinematics.crossings import find_crossings
from ocp_traj.robot.inverse_kinematics.damped_least_squares import DampedLeastSquares
from ocp_traj.robot.inverse_kinematics.inverse_kinematics import InverseKinematics
from ocp_traj.robot.inverse_kinematics.screws import screws_of
from ocp_traj.robot.inverse_kinematics.spherical_wrist import SphericalWrist
from ocp_traj.robot.inverse_kinematics.three_parallel_axes import ThreeParallelAxes
from ocp_traj.robot.inverse_kinematics.unique_domain import follow_domain

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot

Method = Literal["nearest", "unique-domain"]


def inverse_kinematics_of(robot: Robot) -> InverseKinematics:
    """Return the closed form that suits a robot's axes, else damped least squares.

    Parameters
    ----------
    robot : Robot
    """
    if robot.n == 6 and "prismatic" not in robot.joint_types and robot.coupling is None:
        screws = screws_of(robot)
        for closed_form in (ThreeParallelAxes, SphericalWrist):
            try:
                return closed_form(robot, screws)
            except RobotError:
                continue  # the axes are of another type
    return DampedLeastSquares(robot)


def poses_to_matrices(poses: ArrayLike) -> Array:
    """Return transforms (K, 4, 4) of poses (K, 7): x, y, z in m and a unit quaternion qx, qy, qz, qw.

    Parameters
    ----------
    poses : (K, 7) array

    Raises
    ------
    InputError
        The shape is wrong, a number is not finite, or a quaternion's norm differs from 1 by more than 1e-3.
    """
    import pinocchio as pin

    rows = np.array(poses, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != 7 or not len(rows):
        raise InputError(f"poses have shape {rows.shape}, expected (K, 7): x, y, z, qx, qy, qz, qw")
    for index, row in enumerate(rows):
        if not np.all(np.isfinite(row)):
            raise InputError(f"pose of waypoint {index + 1} is {row.tolist()}, expected finite numbers")
        norm = float(np.linalg.norm(row[3:]))
        if abs(norm - 1.0) > 1e-3:
            raise InputError(
                f"quaternion of waypoint {index + 1} has norm {norm:g}, expected 1 (order x, y, z, w)"
            )
        rows[index, 3:] /= norm
    return np.array([pin.XYZQUATToSE3(row).homogeneous for row in rows])


def solve_poses(
    robot: Robot,
    poses: ArrayLike,
    start: ArrayLike,
    weights: ArrayLike | None = None,
    method: Method = "nearest",
) -> Array:
    """Return joint waypoints (K, n) that reach poses, each near the one before.

    Parameters
    ----------
    robot : Robot
        Poses are those of its tool in its base frame.
    poses : (K, 7)
        x, y, z in m, unit quaternion qx, qy, qz, qw.
    start : (n,)
        Names the branch: the first waypoint is the solution nearest to it, rad.
    weights : (n,), optional
        Of the nearest rule, larger for joints that should move less; default ones.
    method : {"nearest", "unique-domain"}
        Paper C's weighted nearest rule over all branches, or only the branch of the domain `start` is in. The
        second needs a closed form.

    Raises
    ------
    UnreachablePoseError
        A pose is out of reach, reachable only outside of the joint limits, or singular, or the path leaves
        its domain (second method); names the waypoint, counted from 1.
    InputError
        A shape or a number is wrong, or the method does not suit the robot.
    """
    matrices = poses_to_matrices(poses)
    first = vector(start, robot.n, "start")
    scale = np.ones(robot.n) if weights is None else vector(weights, robot.n, "weights")
    if np.any(scale <= 0.0):
        raise InputError(f"weights are {scale.tolist()}, expected positive numbers")
    inverse = inverse_kinematics_of(robot)
    if method == "unique-domain":
        if not isinstance(inverse, ClosedForm):
            raise InputError(f"method 'unique-domain' needs a closed form, robot {robot.name!r} has none")
        return _in_one_domain(inverse, matrices, first)
    if method != "nearest":
        raise InputError(f"method {method!r} is unknown, expected 'nearest' or 'unique-domain'")
    if isinstance(inverse, ClosedForm):
        return _nearest_closed_form(inverse, matrices, first, scale)
    assert isinstance(inverse, DampedLeastSquares)
    return _nearest_iterative(inverse, matrices, first, scale)


def _place(pose: Array) -> str:
    return "({:.4g}, {:.4g}, {:.4g}) m".format(*pose[:3, 3])


def _out_of_reach(waypoint: int, pose: Array, in_reach: bool) -> UnreachablePoseError:
    reason = "is reached only outside of the joint limits" if in_reach else "is out of reach"
    return UnreachablePoseError(f"waypoint {waypoint} at {_place(pose)} {reason}, expected one within reach")


def _singular(waypoint: int, pose: Array, what: str) -> UnreachablePoseError:
    return UnreachablePoseError(
        f"waypoint {waypoint} at {_place(pose)} is singular ({what}: det J = 0), expected one that is not"
    )


def _nearest_closed_form(inverse: ClosedForm, poses: Array, start: Array, weights: Array) -> Array:
    found = inverse.branches(poses)
    waypoints = np.empty((len(poses), inverse.robot.n))
    previous = start
    for index, branches in enumerate(found.q):
        candidates = nearest_turns(inverse.robot, branches, previous)
        chosen = nearest_branch(inverse.robot, candidates, previous, weights)
        if chosen is None:
            raise _out_of_reach(index + 1, poses[index], in_reach=bool(found.exists[index].any()))
        margin = found.margin[index, chosen]
        if np.min(margin) < SINGULAR:
            raise _singular(index + 1, poses[index], FACTORS[int(np.argmin(margin))])
        previous = waypoints[index] = candidates[chosen]
    return waypoints


def _in_one_domain(inverse: ClosedForm, poses: Array, start: Array) -> Array:
    waypoints = follow_domain(inverse, poses, start)
    factors = inverse.factors(waypoints)
    for index, pose in enumerate(poses):
        if np.isnan(waypoints[index]).any():
            raise _out_of_reach(index + 1, pose, in_reach=bool(inverse.branches(pose[None]).exists.any()))
        weakest = int(np.argmin(np.abs(factors[index])))
        if abs(factors[index, weakest]) < SINGULAR:
            raise _singular(index + 1, pose, FACTORS[weakest])
    crossings = find_crossings(inverse, poses, start)
    if crossings:
        raise UnreachablePoseError(f"{crossings[0]}, expected a path within one domain")
    return waypoints


def _nearest_iterative(inverse: DampedLeastSquares, poses: Array, start: Array, weights: Array) -> Array:
    robot = inverse.robot
    waypoints = np.empty((len(poses), robot.n))
    previous = start
    for index, pose in enumerate(poses):
        ends = [inverse.descend(pose, previous, weights)]
        # From the position before, a redundant arm finds the nearest of its infinitely many solutions.
        if robot.n <= 6 or not ends[0].converged:
            ends += [
                inverse.descend(pose, item, weights) for item in inverse.start_positions(inverse.starts // 2)
            ]
        reached = np.array([end.q for end in ends if end.converged]).reshape(-1, robot.n)
        candidates = nearest_turns(robot, reached, previous)
        chosen = nearest_branch(robot, candidates, previous, weights) if len(candidates) else None
        if chosen is None:
            best = min(end.error for end in ends)
            raise UnreachablePoseError(
                f"waypoint {index + 1} at {_place(pose)} is out of reach within the joint limits: the "
                f"nearest pose found is off by {best:.3g} (m and rad), expected one within reach"
            )
        if inverse.manipulability(candidates[chosen]) < SINGULAR:
            raise _singular(index + 1, pose, "the tool cannot move in every direction")
        previous = waypoints[index] = candidates[chosen]
    return waypoints
