"""Closed form for arms with a spherical wrist: axes 2 and 3 parallel, axes 4, 5, 6 meet in one point.

Most industrial arms are of this type, among them those of papers B and D.
"""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.robot.inverse_kinematics.closed_form import ClosedForm
from ocp_traj.robot.inverse_kinematics.screws import INTERSECT, angle_about, rotate, solve_trigonometric


class SphericalWrist(ClosedForm):
    """Up to eight branches of an arm whose axes 2 and 3 are parallel and whose last three axes meet.

    The method of Pieper (1968), as in Craig, *Introduction to Robotics*, section 4.6; paper B, Eqs. (4) to
    (26), and paper D, Eq. (3), are its forms for their DH tables.

    Raises
    ------
    RobotError
        The robot is of another type; the message says what differs.
    """

    def _mismatch(self) -> str:
        problem = super()._mismatch()
        if problem:
            return problem
        meeting = self.screws.intersection(3, 4)
        if meeting is None:
            return "axes 4 and 5 do not meet"
        if self.screws.parallel(4, 5):
            return "axes 5 and 6 are parallel"
        lever = meeting - self.p[5]
        if np.linalg.norm(lever - (lever @ self.w[5]) * self.w[5]) > INTERSECT:
            return "axis 6 does not pass through the meeting point of axes 4 and 5"
        return ""

    def _prepare(self) -> None:
        meeting = self.screws.intersection(3, 4)
        assert meeting is not None  # checked by _mismatch
        self.centre = meeting
        self.turn = np.sign(self.w[2] @ self.w[1])
        self.reference = np.linalg.svd(self.w[5][None])[2][1]  # any direction across w6

    def _solve(self, displacement: Array, k: tuple[Array, Array, Array]) -> tuple[list[Array], list[Array]]:
        w, p = self.w, self.p
        rotation = displacement[:, :3, :3]
        point = rotation @ self.centre + displacement[:, :3, 3]
        q1, shoulder = self._first_joint(point, k[0], w[1] @ (self.centre - p[0]))
        reached = p[0] + rotate(w[0], -q1, point - p[0])
        second, third, elbow = self._elbow(reached, self.centre, k[1])

        def before_wrist(direction: Array) -> Array:
            """Apply (E1 E2 E3)^T R, which equals E4 E5 E6."""
            return rotate(w[1], -(second + third), rotate(w[0], -q1, rotation @ direction))

        # w4 . E4 E5 E6 w6 = w4 . E5 w6 gives joint 5, then E4 and E6 follow from one direction each.
        approach = before_wrist(w[5])
        a, b, c = self._wrist_equation()
        q5, wrist = solve_trigonometric(a, b, approach @ w[3] - c, k[2])
        bent = rotate(w[4], q5, w[5])
        q4 = angle_about(w[3], bent, np.broadcast_to(approach, bent.shape))
        spun = rotate(w[4], -q5, rotate(w[3], -q4, before_wrist(self.reference)))
        q6 = angle_about(w[5], np.broadcast_to(self.reference, spun.shape), spun)
        return [q1, second, self.turn * third, q4, q5, q6], [shoulder, elbow, wrist]

    def _wrist_equation(self) -> tuple[Array, Array, Array]:
        along = self.w[5] @ self.w[4]
        across = self.w[5] - along * self.w[4]
        return self.w[3] @ across, self.w[3] @ np.cross(self.w[4], across), along * (self.w[3] @ self.w[4])

    def _factors(self, q: Array) -> tuple[Array, Array, Array]:
        a, b, _ = self._shoulder_equation(self._carry(q, self.centre, 3))
        shoulder = np.sin(q[:, 0] - np.arctan2(b, a))
        elbow = self._elbow_factor(self.turn * q[:, 2], self.centre)
        a, b, _ = self._wrist_equation()
        return shoulder, elbow, np.sin(q[:, 4] - np.arctan2(b, a))
