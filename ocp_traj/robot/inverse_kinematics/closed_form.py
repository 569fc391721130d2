"""Closed-form inverse kinematics of six-joint arms, by the geometry of their axes.

Written with the axes at zero (product of exponentials) and not with a DH table, so the same lines serve every
choice of frames, zeros and turning directions. Notation: w_i unit axes, p_i points on them, all at zero; E_i
the rotation of joint i; D = T T(0)^-1 the displacement of the tool, with rotation R. Each of three equations
has two roots; the signs that choose among them are the k1, k2, k3 of paper C, and the domains they name are
separated by det J = 0.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ocp_traj.arrays import Array
from ocp_traj.exceptions import RobotError
from ocp_traj.robot.inverse_kinematics.inverse_kinematics import InverseKinematics
from ocp_traj.robot.inverse_kinematics.screws import (
    Screws,
    angle_about,
    rotate,
    screws_of,
    solve_trigonometric,
    wrap,
)

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot

SIGNS = np.array(list(product((1.0, -1.0), repeat=3)))
"""The eight sign triples (8, 3), in the order of the branches."""

SINGULAR = 1e-6
"""A branch whose margin is smaller than this is called singular."""

FACTORS = ("shoulder", "elbow", "wrist")
"""What each sign, and each factor of det J, belongs to."""


@dataclass(frozen=True)
class Branches:
    """Branches of K poses.

    Attributes
    ----------
    q : (K, B, 6)
        Angles in (-pi, pi]; NaN where the branch does not exist.
    margin : (K, B, 3)
        Distance from the singularities in the order of `FACTORS`: the sine that vanishes where two branches
        meet; NaN where the branch does not exist.
    """

    q: Array
    margin: Array

    @property
    def exists(self) -> npt.NDArray[np.bool_]:
        """Whether each branch exists, (K, B) bool."""
        return np.all(np.isfinite(self.margin), axis=-1)


class ClosedForm(InverseKinematics):
    """Closed form for a six-joint arm whose second and third axes are parallel."""

    def __init__(self, robot: Robot, screws: Screws | None = None) -> None:
        self.robot = robot
        self.screws = screws_of(robot) if screws is None else screws
        self.w = self.screws.directions
        self.p = self.screws.points
        problem = self._mismatch()
        if problem:
            raise RobotError(f"robot {robot.name!r} does not suit {type(self).__name__}: {problem}")
        self._prepare()

    def _mismatch(self) -> str:
        """Return what in the robot's geometry does not suit this closed form, empty if nothing."""
        if self.robot.n != 6 or "prismatic" in self.robot.joint_types:
            return "it needs six revolute joints"
        if not self.screws.parallel(1, 2):
            return "axes 2 and 3 are not parallel"
        if self.screws.parallel(0, 1):
            return "axes 1 and 2 are parallel"
        return ""

    @abstractmethod
    def _prepare(self) -> None:
        """Compute what depends on the robot only."""

    @abstractmethod
    def _solve(self, displacement: Array, k: tuple[Array, Array, Array]) -> tuple[list[Array], list[Array]]:
        """Return six angles and three margins for displacements (K, 4, 4) and signs that broadcast with K."""

    @abstractmethod
    def _factors(self, q: Array) -> tuple[Array, Array, Array]:
        """Return the signed factors of det J at `q` (K, 6), each (K,), in the order of `FACTORS`."""

    def branches(self, poses: Array, signs: Array | None = None) -> Branches:
        """Return all eight branches of poses (K, 4, 4), or the one of each row of `signs` (B, 3).

        Unlike the nearest rule, one row costs an eighth: that is the method of unique domains.
        """
        displacement = np.asarray(poses, dtype=np.float64) @ self.screws.home_inverse
        count = displacement.shape[0]
        if signs is None:
            sides = np.array([1.0, -1.0])
            k = (sides.reshape(2, 1, 1, 1), sides.reshape(1, 2, 1, 1), sides.reshape(1, 1, 2, 1))
        else:
            rows = np.asarray(signs, dtype=np.float64).reshape(-1, 3, 1, 1, 1)
            k = (rows[:, 0], rows[:, 1], rows[:, 2])
        angles, margins = self._solve(displacement, k)
        shape = np.broadcast_shapes(*(sign.shape for sign in k))[:3]
        q = np.stack([np.broadcast_to(angle, (*shape, count)) for angle in angles], axis=-1).reshape(
            -1, count, 6
        )
        margin = np.stack([np.broadcast_to(item, (*shape, count)) for item in margins], axis=-1).reshape(
            -1, count, 3
        )
        missing = np.isnan(margin).any(axis=-1, keepdims=True)
        q = np.where(missing, np.nan, wrap(q)).transpose(1, 0, 2)
        return Branches(q, np.where(missing, np.nan, margin).transpose(1, 0, 2))

    def solve(self, pose: Array) -> Array:
        """Return the branches (B, 6) that exist at a pose (4, 4), B <= 8, angles in (-pi, pi].

        Two branches that meet in a singularity are returned once; where a singularity leaves an angle free,
        it has an arbitrary value.
        """
        found = self.branches(np.asarray(pose)[None])
        rows = found.q[0][found.exists[0]]
        distinct: list[Array] = []
        for row in rows:
            if all(np.max(np.abs(wrap(row - other))) > 1e-7 for other in distinct):
                distinct.append(row)
        return np.array(distinct).reshape(-1, 6)

    def domain(self, q: Array) -> Array:
        """Return the signs (K, 3) of the domains that hold joint positions `q` (K, 6); 0 on a border."""
        return np.sign(self.factors(q))

    def factors(self, q: Array) -> Array:
        """Return the signed factors (K, 3) of det J at `q` (K, 6), in the order of `FACTORS`."""
        return np.stack(self._factors(np.atleast_2d(q)), axis=-1)

    # The first joint and the elbow are the same for both families.

    def _first_joint(self, point: Array, sign: Array, offset: float) -> tuple[Array, Array]:
        """Solve n(q1) . (P - p1) = offset, n = E1 w2: turning joints 2 and 3 leaves it as it is."""
        a, b, c = self._shoulder_equation(point)
        return solve_trigonometric(a, b, offset - c, sign)

    def _shoulder_equation(self, point: Array) -> tuple[Array, Array, Array]:
        lever = point - self.p[0]
        along = self.w[1] @ self.w[0]
        across = self.w[1] - along * self.w[0]
        return lever @ across, lever @ np.cross(self.w[0], across), along * (lever @ self.w[0])

    def _elbow(self, reached: Array, carried: Array, sign: Array) -> tuple[Array, Array, Array]:
        """Solve e2 e3 c = X for joints 2 and 3, c a point carried by joint 3 and X its place after both.

        Returns the angles of joints 2 and 3, both about w2, and the margin.
        """
        axis = self.w[1]
        upper, fore = self._across(self.p[2] - self.p[1]), self._across(carried - self.p[2])
        lever = self._across(reached - self.p[1])
        a, b = 2.0 * upper @ fore, 2.0 * upper @ np.cross(axis, fore)
        c = np.sum(lever * lever, axis=-1) - upper @ upper - fore @ fore
        third, margin = solve_trigonometric(np.float64(a), np.float64(b), c, sign)
        second = angle_about(axis, upper + rotate(axis, third, fore), lever)
        return second, third, margin

    def _elbow_factor(self, third: Array, carried: Array) -> Array:
        """Return the sine by which the elbow is off its stretched position; `third` is about w2."""
        axis = self.w[1]
        upper, fore = self._across(self.p[2] - self.p[1]), self._across(carried - self.p[2])
        a, b = upper @ fore, upper @ np.cross(axis, fore)
        return np.sin(third - np.arctan2(b, a))

    def _across(self, vector: Array) -> Array:
        """Return the part of vectors (..., 3) across axis 2."""
        return vector - (vector @ self.w[1])[..., None] * self.w[1]

    def _carry(self, q: Array, point: Array, last: int) -> Array:
        """Return where joints 1 to `last` carry a point (3,), (K, 3)."""
        carried = np.broadcast_to(point, (q.shape[0], 3))
        for joint in reversed(range(last)):
            carried = self.p[joint] + rotate(self.w[joint], q[:, joint], carried - self.p[joint])
        return carried
