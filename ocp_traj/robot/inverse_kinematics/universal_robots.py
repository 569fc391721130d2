"""The UR closed form in plain Python, one pose at a time, as paper C programs it with its signs k1, k2, k3.

`ThreeParallelAxes` solves the same arms, and others, for many poses at once; this one exists because paper
C's claim about computing time is a claim about such a program. Paper C's Eqs. (4) and (5) are lost; these are
the usual formulas for the UR's standard DH table (Hawkins, "Analytic inverse kinematics for the Universal
Robots UR-5/UR-10 arms", 2013).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import acos, atan2, ceil, cos, hypot, pi, sin, sqrt
from typing import TYPE_CHECKING, TypeAlias

from ocp_traj.exceptions import RobotError

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot

Pose: TypeAlias = Sequence[Sequence[float]]
Angles: TypeAlias = tuple[float, ...]

ALL_SIGNS = tuple((k1, k2, k3) for k1 in (1, -1) for k2 in (1, -1) for k3 in (1, -1))
"""The eight sign triples: shoulder, wrist, elbow."""


@dataclass(frozen=True)
class UniversalRobotsTable:
    """Standard DH parameters of a UR arm, in m; alpha = pi/2, 0, 0, pi/2, -pi/2, 0.

    Poses go from the frame "base" to the frame "tool0" of the UR descriptions.
    """

    d1: float
    a2: float
    a3: float
    d4: float
    d5: float
    d6: float

    def solve(self, pose: Pose, k: tuple[int, int, int]) -> Angles | None:
        """Return the branch `k` = (k1, k2, k3) at a pose (4 rows of 4), None where it does not exist.

        k1 chooses the shoulder, k2 the wrist, k3 the elbow.
        """
        t1 = self._shoulder(pose, k[0])
        wrist = None if t1 is None else self._wrist(pose, t1, k[1])
        return None if t1 is None or wrist is None else self._elbow(pose, t1, wrist, k[2])

    def solve_all(self, pose: Pose) -> list[Angles]:
        """Return all branches that exist; what branches have in common is computed once."""
        branches = []
        for k1 in (1, -1):
            t1 = self._shoulder(pose, k1)
            if t1 is None:
                continue
            for k2 in (1, -1):
                wrist = self._wrist(pose, t1, k2)
                if wrist is None:
                    continue
                branches += [q for k3 in (1, -1) if (q := self._elbow(pose, t1, wrist, k3)) is not None]
        return branches

    def nearest(self, pose: Pose, previous: Sequence[float], weights: Sequence[float]) -> Angles | None:
        """Return the branch that the weighted nearest rule takes among all, None if none exists."""
        best, least = None, float("inf")
        for q in self.solve_all(pose):
            distance = sum(w * abs(_wrapped(a - b)) for w, a, b in zip(weights, q, previous, strict=True))
            if distance < least:
                best, least = q, distance
        return best

    def _shoulder(self, pose: Pose, k1: int) -> float | None:
        m, n = self.d6 * pose[1][2] - pose[1][3], self.d6 * pose[0][2] - pose[0][3]
        root = m * m + n * n - self.d4 * self.d4
        return None if root < 0.0 else atan2(m, n) - atan2(self.d4, k1 * sqrt(root))

    def _wrist(self, pose: Pose, t1: float, k2: int) -> tuple[float, float] | None:
        """Return joints 5 and 6."""
        c1, s1 = cos(t1), sin(t1)
        c5 = pose[0][2] * s1 - pose[1][2] * c1
        if abs(c5) > 1.0:
            return None
        t5 = k2 * acos(c5)
        t6 = atan2(pose[0][0] * s1 - pose[1][0] * c1, pose[0][1] * s1 - pose[1][1] * c1)
        return t5, t6 - atan2(sin(t5), 0.0)

    def _elbow(self, pose: Pose, t1: float, wrist: tuple[float, float], k3: int) -> Angles | None:
        (nx, ox, ax, px), (ny, oy, ay, py), (nz, oz, az, pz) = pose[0], pose[1], pose[2]
        c1, s1, c6, s6 = cos(t1), sin(t1), cos(wrist[1]), sin(wrist[1])
        out = s6 * (nx * c1 + ny * s1) + c6 * (ox * c1 + oy * s1)
        up = oz * c6 + nz * s6
        m = self.d5 * out - self.d6 * (ax * c1 + ay * s1) + px * c1 + py * s1
        n = pz - self.d1 - az * self.d6 + self.d5 * up
        c3 = (m * m + n * n - self.a2**2 - self.a3**2) / (2.0 * self.a2 * self.a3)
        if abs(c3) > 1.0:
            return None
        t3 = k3 * acos(c3)
        t2 = atan2(n, m) - atan2(self.a3 * sin(t3), self.a2 + self.a3 * c3)
        t4 = atan2(-out, up) - t2 - t3
        return tuple(_wrapped(angle) for angle in (t1, t2, t3, t4, *wrist))


def _wrapped(angle: float) -> float:
    """Return the angle in (-pi, pi]."""
    return angle - 2.0 * pi * ceil((angle - pi) / (2.0 * pi))


def universal_robots_table(robot: Robot) -> UniversalRobotsTable:
    """Return the DH parameters of a UR robot.

    Raises
    ------
    RobotError
        The robot is no UR arm in its usual frames.
    """
    import numpy as np

    try:
        usual = robot.with_changes(base="base", tool="tool0")
    except RobotError as error:
        raise RobotError(f"robot {robot.name!r} is no UR arm: {error}") from error
    # At zero the arm is stretched along -x of "base": x holds a2 + a3, y holds -(d4 + d6), z holds d1 - d5.
    origin = {name: usual.pose(np.zeros(usual.n), name)[:3, 3] for name in ("upper_arm_link", "forearm_link")}
    wrist = usual.pose(np.zeros(usual.n), "wrist_3_link")[:3, 3]
    tool = usual.pose(np.zeros(usual.n))[:3, 3]
    d6 = float(np.linalg.norm(tool - wrist))
    upper, fore = origin["upper_arm_link"], origin["forearm_link"]
    table = UniversalRobotsTable(
        d1=float(upper[2]),
        a2=-float(hypot(fore[0] - upper[0], fore[2] - upper[2])),
        a3=float(tool[0]) - float(fore[0]),
        d4=-float(tool[1]) - d6,
        d5=float(upper[2] - tool[2]),
        d6=d6,
    )
    check = np.array([0.3, -1.1, 1.3, -0.7, 0.9, 0.4])
    if not any(
        q is not None and np.allclose(q, check, atol=1e-6)
        for q in (table.solve(usual.pose(check).tolist(), k) for k in ALL_SIGNS)
    ):
        raise RobotError(f"robot {robot.name!r} is no UR arm: the UR formulas do not give back its positions")
    return table
