"""Where joints are at many configurations at once: the judge's own kinematics, from Pinocchio's model."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ocp_traj.arrays import Array
from ocp_traj.robot import Robot
from ocp_traj.robot.links import joint_kind


class Placements:
    """Placements of a robot's joints in the root's frame, batched; joint 0 is the root, joint i moves link i.

    Parameters
    ----------
    robot : Robot
    """

    def __init__(self, robot: Robot) -> None:
        model = robot.bare_model
        kinds = [joint_kind(model.joints[number]) for number in range(1, model.njoints)]
        self.n = len(kinds)
        self.parents: list[int] = [int(parent) for parent in model.parents]
        self.at_rest: Array = np.array([placement.homogeneous for placement in model.jointPlacements])
        self.axes: Array = np.array([np.array(axis) / np.linalg.norm(axis) for _, axis in kinds])
        self.sliding: list[bool] = [kind == "prismatic" for kind, _ in kinds]

    @cached_property
    def movers(self) -> NDArray[np.bool_]:
        """Which joints move what a joint carries, (n + 1, n)."""
        movers = np.zeros((self.n + 1, self.n), dtype=bool)
        for number in range(1, self.n + 1):
            movers[number] = movers[self.parents[number]]
            movers[number, number - 1] = True
        return movers

    def at(self, q: Array) -> Array:
        """Return the placements (m, n + 1, 4, 4) at configurations (m, n)."""
        placements = np.zeros((len(q), self.n + 1, 4, 4))
        placements[:, 0] = np.eye(4)
        local = np.zeros((len(q), 4, 4))
        local[:, 3, 3] = 1.0
        for number in range(1, self.n + 1):
            axis, angle = self.axes[number - 1], q[:, number - 1]
            if self.sliding[number - 1]:
                local[:, :3, :3], local[:, :3, 3] = np.eye(3), angle[:, None] * axis
            else:
                local[:, :3, :3], local[:, :3, 3] = _turns(axis, angle), 0.0
            placements[:, number] = placements[:, self.parents[number]] @ self.at_rest[number] @ local
        return placements


def _turns(axis: Array, angle: Array) -> Array:
    """Return the rotations (m, 3, 3) about an axis by angles (m,) (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, versine = np.sin(angle)[:, None, None], (1.0 - np.cos(angle))[:, None, None]
    return np.asarray(np.eye(3) + sine * cross + versine * (cross @ cross))
