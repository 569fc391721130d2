"""Closed form for arms of the UR type: axes 2, 3, 4 parallel, axes 5 and 6 meet.

The UR3, UR5, UR10 are of this type, and so is Unitree's Z1.
"""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.robot.inverse_kinematics.closed_form import ClosedForm
from ocp_traj.robot.inverse_kinematics.screws import angle_about, rotate, solve_trigonometric


class ThreeParallelAxes(ClosedForm):
    """Up to eight branches of an arm whose axes 2, 3, 4 are parallel and whose axes 5 and 6 meet.

    Paper C, Eqs. (4) and (5) (their print is lost), solve the UR5's DH table; this solves any arm of the
    type.

    Raises
    ------
    RobotError
        The robot is of another type; the message says what differs.
    """

    def _mismatch(self) -> str:
        problem = super()._mismatch()
        if problem:
            return problem
        if not self.screws.parallel(2, 3):
            return "axes 3 and 4 are not parallel"
        if self.screws.parallel(3, 4):
            return "axes 4 and 5 are parallel"
        if self.screws.intersection(4, 5) is None:
            return "axes 5 and 6 do not meet"
        return ""

    def _prepare(self) -> None:
        meeting = self.screws.intersection(4, 5)
        assert meeting is not None  # checked by _mismatch
        self.centre = meeting
        # Joints 3 and 4 turn about w2 or against it.
        self.turn = np.sign(self.w[2:4] @ self.w[1])
        self.reference = np.linalg.svd(self.w[1][None])[2][1]  # any direction across w2

    def _solve(self, displacement: Array, k: tuple[Array, Array, Array]) -> tuple[list[Array], list[Array]]:
        w, p = self.w, self.p
        rotation = displacement[:, :3, :3]
        point = rotation @ self.centre + displacement[:, :3, 3]
        q1, shoulder = self._first_joint(point, k[0], w[1] @ (self.centre - p[0]))
        normal = rotate(w[0], q1, w[1])
        # n . R w6 = w2 . E5 w6, as joints 2, 3, 4 keep what lies along w2.
        a, b, c = self._wrist_equation()
        q5, wrist = solve_trigonometric(a, b, np.sum(normal * (rotation @ w[5]), axis=-1) - c, k[2])
        # R^T n = E6^T E5^T w2 gives joint 6.
        bent = rotate(w[4], -q5, w[1])
        turned = np.einsum("kij,...ki->...kj", rotation, normal)
        q6 = angle_about(w[5], turned, np.broadcast_to(bent, np.broadcast_shapes(bent.shape, turned.shape)))
        # What is left, e2 e3 e4 = e1^-1 D e6^-1 e5^-1, moves in a plane.
        fourth = self._before_arm(displacement, q1, q5, q6, p[3]) + p[0]
        end = self._before_arm(displacement, q1, q5, q6, p[3] + self.reference) + p[0] - fourth
        second, third, elbow = self._elbow(fourth, p[3], k[1])
        whole = angle_about(w[1], np.broadcast_to(self.reference, end.shape), end)
        q4 = self.turn[1] * (whole - second - third)
        return [q1, second, self.turn[0] * third, q4, q5, q6], [shoulder, elbow, wrist]

    def _wrist_equation(self) -> tuple[Array, Array, Array]:
        along = self.w[5] @ self.w[4]
        across = self.w[5] - along * self.w[4]
        return self.w[1] @ across, self.w[1] @ np.cross(self.w[4], across), along * (self.w[1] @ self.w[4])

    def _before_arm(self, displacement: Array, q1: Array, q5: Array, q6: Array, point: Array) -> Array:
        """Return e1^-1 D e6^-1 e5^-1 applied to `point`, relative to p1."""
        w, p = self.w, self.p
        carried = p[4] + rotate(w[4], -q5, point - p[4])
        carried = p[5] + rotate(w[5], -q6, carried - p[5])
        carried = np.einsum("kij,...kj->...ki", displacement[:, :3, :3], carried) + displacement[:, :3, 3]
        return rotate(w[0], -q1, carried - p[0])

    def _factors(self, q: Array) -> tuple[Array, Array, Array]:
        a, b, _ = self._shoulder_equation(self._carry(q, self.centre, 6))
        shoulder = np.sin(q[:, 0] - np.arctan2(b, a))
        elbow = self._elbow_factor(self.turn[0] * q[:, 2], self.p[3])
        a, b, _ = self._wrist_equation()
        return shoulder, elbow, np.sin(q[:, 4] - np.arctan2(b, a))
