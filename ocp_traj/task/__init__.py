"""What a person asks for: waypoints, limits, a curve family, boundary conditions and an objective.

A task is readable and frozen and knows no decision variables; `ocp_traj.transcription` turns it into a
numerical problem. All values are SI; arrays are read-only copies.
"""

from __future__ import annotations

from ocp_traj.task.boundary import Boundary
from ocp_traj.task.custom import CustomConstraint, CustomObjective
from ocp_traj.task.limits import Limits
from ocp_traj.task.objective import Motor, Objective
from ocp_traj.task.search import Search
from ocp_traj.task.task import TrajectoryTask

__all__ = [
    "Boundary",
    "CustomConstraint",
    "CustomObjective",
    "Limits",
    "Motor",
    "Objective",
    "Search",
    "TrajectoryTask",
]
