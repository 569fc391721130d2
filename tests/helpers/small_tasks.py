"""Small tasks for the tests of solvers, and a small arm as a URDF."""

from __future__ import annotations

from typing import Any

import numpy as np

from ocp_traj.robot import load_robot
from ocp_traj.task import Limits, TrajectoryTask

POINTS = [[0.0, 0.0], [1.0, 0.5], [0.5, 1.0]]

ARM_POINTS = np.deg2rad(
    [
        [0, -90, 90, -90, -90, 0],
        [45, -70, 80, -100, -90, 45],
        [60, -10, 20, -90, -90, 60],
        [90, -90, 90, -90, -90, 90],
    ]
)
"""In the third the arm is nearly stretched out."""


def plain_task(**changes: Any) -> TrajectoryTask:
    """Return a task of two joints without a robot, and without virtual knots unless they are given."""
    return TrajectoryTask(POINTS, Limits(velocity=2.0, acceleration=4.0), **{"virtual_knots": 0, **changes})


def arm_task(points: Any = ARM_POINTS, **changes: Any) -> TrajectoryTask:
    """Return a task of the UR5; `limits` are added to those of velocity and acceleration."""
    limits = {"velocity": 2.1, "acceleration": 5.2, **changes.pop("limits", {})}
    return TrajectoryTask(points, Limits(**limits), **{"robot": load_robot("ur5"), "virtual_knots": 0, **changes})


ARM = """<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.1 0 0.2" rpy="0.1 0.2 0.3"/><mass value="2.5"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.025" ixy="0.001" ixz="0.002" iyz="0.003"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0 0.1 0"/><mass value="1.5"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="slide"><inertial><mass value="0.5"/>
    <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tip"/>
  <joint name="swing" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.3" rpy="0.3 0 0"/><axis xyz="1 2 0"/>
    <limit lower="-2" upper="2.5" effort="30" velocity="3"/></joint>
  <joint name="turn" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.4 0 0" rpy="0 0.7 0"/><axis xyz="0 0 1"/><limit effort="20" velocity="4"/></joint>
  <joint name="push" type="prismatic"><parent link="lower"/><child link="slide"/>
    <origin xyz="0 0 0.2" rpy="0 0 0.2"/><axis xyz="0 1 0"/>
    <limit lower="-0.2" upper="0.4" effort="50" velocity="0.5"/></joint>
  <joint name="end" type="fixed"><parent link="slide"/><child link="tip"/><origin xyz="0 0 0.1" rpy="0 0 1"/></joint>
</robot>"""
"""A revolute joint about an odd axis, a continuous one and a sliding one, all with masses."""
