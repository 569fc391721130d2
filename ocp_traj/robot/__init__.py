"""Robots: limits, kinematics, dynamics. Importing this loads neither Pinocchio nor CasADi."""

from __future__ import annotations

from ocp_traj.robot.additions import Friction, Payload
from ocp_traj.robot.batch import BatchRobot
from ocp_traj.robot.dh import robot_from_dh
from ocp_traj.robot.inverse_kinematics.poses import solve_poses
from ocp_traj.robot.moveit import limits_from_moveit
from ocp_traj.robot.packaged import load_robot, robot_names
from ocp_traj.robot.robot import Robot, RobotSource
from ocp_traj.robot.symbolic import SymbolicRobot
from ocp_traj.robot.urdf import robot_from_urdf

__all__ = [
    "BatchRobot",
    "Friction",
    "Payload",
    "Robot",
    "RobotSource",
    "SymbolicRobot",
    "limits_from_moveit",
    "load_robot",
    "robot_from_dh",
    "robot_from_urdf",
    "robot_names",
    "solve_poses",
]
