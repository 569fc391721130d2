"""What every inverse kinematics offers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from ocp_traj.arrays import Array

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot


class InverseKinematics(ABC):
    """From a pose of the tool to the joint positions that reach it.

    Attributes
    ----------
    robot : Robot
        Poses go from its base to its tool.
    """

    robot: Robot

    @abstractmethod
    def solve(self, pose: Array) -> Array:
        """Return all joint positions (B, n) found for a pose (4, 4); none gives (0, n)."""
