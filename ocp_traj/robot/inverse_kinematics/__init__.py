"""Inverse kinematics: from poses of the tool to joint positions."""

from __future__ import annotations

from ocp_traj.robot.inverse_kinematics.closed_form import SIGNS, Branches, ClosedForm
from ocp_traj.robot.inverse_kinematics.crossings import Crossing, find_crossings
from ocp_traj.robot.inverse_kinematics.damped_least_squares import DampedLeastSquares
from ocp_traj.robot.inverse_kinematics.inverse_kinematics import InverseKinematics
from ocp_traj.robot.inverse_kinematics.poses import (
    inverse_kinematics_of,
    poses_to_matrices,
    solve_poses,
)
from ocp_traj.robot.inverse_kinematics.spherical_wrist import SphericalWrist
from ocp_traj.robot.inverse_kinematics.three_parallel_axes import ThreeParallelAxes
from ocp_traj.robot.inverse_kinematics.unique_domain import domain_of, follow_domain

__all__ = [
    "SIGNS",
    "Branches",
    "ClosedForm",
    "Crossing",
    "DampedLeastSquares",
    "InverseKinematics",
    "SphericalWrist",
    "ThreeParallelAxes",
    "domain_of",
    "find_crossings",
    "follow_domain",
    "inverse_kinematics_of",
    "poses_to_matrices",
    "solve_poses",
]
