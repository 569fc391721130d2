"""FANUC M-10iD/8L with inertia, for the outlook of Zhu and Wang (paper D) on energy.

Facts retyped from FANUC's own robot description: repository FANUC-CORPORATION/fanuc_description, package
fanuc_m10_description 2.1.1, file urdf/m10_8_20d_urdf_macro.xacro ("URDF for M-10/8-20D(M-10iD/8L)"), Apache-2.0,
copyright FANUC America Corporation and FANUC CORPORATION. Its effort limits are round numbers and are not used;
rotor inertias, friction and gravity balancing are not in it.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.arrays import Array

if TYPE_CHECKING:
    from ocp_traj.robot import Robot
    from ocp_traj.task import TrajectoryTask

SOURCE = "FANUC-CORPORATION/fanuc_description, fanuc_m10_description 2.1.1, m10_8_20d_urdf_macro.xacro"

JOINTS = (
    ("0 0 0.45", "0 0 1"),
    ("0.075 0 0", "0 1 0"),
    ("0 0 0.84", "0 -1 0"),
    ("0 0 0.195", "-1 0 0"),
    ("1.1 0 0", "0 -1 0"),
    ("0 0 0", "-1 0 0"),
)
"""Place in the link before (m) and axis of J1 to J6."""

LINKS = (
    (25.1, "0.0385 -0.0176 -0.0359", (0.285, -0.0106, -0.0157, 0.242, -0.00898, 0.336)),
    (33.5, "-0.0227 -0.151 0.402", (2.3, -0.0223, 0.0191, 2.33, -0.0412, 0.152)),
    (54.5, "0.242 0.0064 0.116", (0.693, -0.0249, -0.368, 2.13, -0.035, 2.1)),
    (17.5, "0.678 -0.0311 -0.000832", (0.0509, 0.0696, 0.000437, 0.9, -0.000433, 0.915)),
    (1.16, "0.0214 -0.015 4.94e-11", (0.00173, -0.000392, 1.55e-12, 0.00191, 1.41e-12, 0.00189)),
    (0.224, "0.0537 4.57e-7 5.41e-6", (0.000131, -1.16e-10, -7.99e-9, 0.000102, -3.98e-12, 0.000102)),
)
"""Mass (kg), centre of mass (m) and ixx, ixy, ixz, iyy, iyz, izz about it (kg m^2) of the links after J1 to J6."""

SIGNS = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
OFFSETS = np.array([0.0, 0.5 * np.pi, 0.0, 0.0, 0.0, 0.0])
"""FANUC's joint = offset + sign * paper D's DH joint: J2 = 90 deg - theta_2, J4 and J6 turn the other way."""


def fanuc_robot() -> Robot:
    """Return the arm with the links' inertia; no torque limits, the flange as tool."""
    from ocp_traj.robot import robot_from_urdf

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "m10id8l.urdf"
        path.write_text(_urdf(), encoding="utf-8")
        robot = robot_from_urdf(path, tool="flange", name="fanuc-m10id8l")
    return replace(robot, torque_limits=np.array([[-np.inf] * 6, [np.inf] * 6]), source=None)


def to_fanuc(q: Array) -> Array:
    """Return FANUC's joint positions (..., 6) from paper D's DH angles (..., 6), rad."""
    return OFFSETS + SIGNS * q


def with_inertia(task: TrajectoryTask) -> TrajectoryTask:
    """Return paper D's task in FANUC's joint directions, on the arm with inertia: same durations, same limits."""
    from ocp_traj.task import Limits

    position = task.limits.get("position")
    limits = Limits(
        position=np.sort(OFFSETS + SIGNS * position, axis=1),
        velocity=task.limits.get("velocity"),
        acceleration=task.limits.get("acceleration"),
    )
    return replace(
        task,
        robot=fanuc_robot(),
        waypoints=to_fanuc(task.waypoints),
        limits=limits,
        name=f"{task.name}-with-inertia",
    )


def _urdf() -> str:
    parts = ['<robot name="m10_8_20d">', '<link name="base_link"/>']
    before = "base_link"
    for index, ((origin, axis), (mass, centre, inertia)) in enumerate(zip(JOINTS, LINKS, strict=True), 1):
        names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        moments = " ".join(f'{name}="{value}"' for name, value in zip(names, inertia, strict=True))
        parts.append(
            f'<link name="J{index}_link"><inertial><mass value="{mass}"/><origin xyz="{centre}"/>'
            f"<inertia {moments}/></inertial></link>"
            f'<joint name="J{index}" type="revolute"><origin xyz="{origin}"/><parent link="{before}"/>'
            f'<child link="J{index}_link"/><axis xyz="{axis}"/>'
            '<limit lower="-10" upper="10" effort="0" velocity="100"/></joint>'
        )
        before = f"J{index}_link"
    parts.append(
        '<link name="flange"/><joint name="J6-flange" type="fixed"><origin xyz="0.075 0 0"/>'
        f'<parent link="{before}"/><child link="flange"/></joint></robot>'
    )
    return "".join(parts)
