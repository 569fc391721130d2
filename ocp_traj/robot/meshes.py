"""The visual shapes of a robot read from a URDF, for pictures; no dynamics depend on them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.arrays import Array, read_only
from ocp_traj.exceptions import RobotError

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot


@dataclass(frozen=True)
class VisualMesh:
    """One mesh of a robot.

    Attributes
    ----------
    path : pathlib.Path
        A mesh file (STL, DAE or OBJ).
    link : int
        Row of `Robot.link_placements` that carries it: 0 for the root, i for what joint i moves.
    placement : (4, 4)
        In that link.
    scale : (3,)
        Factors from the file's numbers to m.
    """

    path: Path
    link: int
    placement: Array
    scale: Array


def package_folders(description: Path) -> list[str]:
    """Return folders in which ``package://`` addresses of a URDF may be found: its ancestors and ROS's paths."""
    ancestors = [str(folder) for folder in description.resolve().parents]
    named = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    return ancestors + [folder for folder in named if folder]


def visual_meshes(robot: Robot) -> list[VisualMesh]:
    """Return the meshes of a robot; shapes that are no mesh (boxes, spheres) are left out.

    Raises
    ------
    RobotError
        The URDF or one of its meshes is not where it should be.
    """
    if robot.description is None:
        return []
    import pinocchio as pin

    from ocp_traj.robot.model import plain_model
    from ocp_traj.robot.urdf import read_urdf

    original = read_urdf(robot.description)
    kept = set(robot.joint_names)
    locked = [index for index in range(1, original.njoints) if original.names[index] not in kept]
    carriers = plain_model(original, locked).carriers
    folders = package_folders(robot.description)
    try:
        shapes = pin.buildGeomFromUrdf(
            original, str(robot.description), pin.GeometryType.VISUAL, package_dirs=folders
        )
    except (ValueError, RuntimeError) as error:
        raise RobotError(f"meshes of {robot.description} cannot be read: {error}") from error
    meshes = []
    for shape in shapes.geometryObjects:
        path = Path(shape.meshPath)
        if path.suffix.lower() not in (".stl", ".dae", ".obj"):
            continue
        link, placement = carriers[shape.parentJoint]
        meshes.append(
            VisualMesh(
                path=path,
                link=link,
                placement=read_only((placement * shape.placement).homogeneous),
                scale=read_only(np.array(shape.meshScale).ravel()),
            )
        )
    return meshes
