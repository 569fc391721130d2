"""The visual shapes of a robot read from a URDF, for pictures; no dynamics depend on them."""

from __future__ import annotations

import logging
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from ocp_traj.arrays import Array, read_only
from ocp_traj.exceptions import RobotError
from ocp_traj.robot.description.document import read_document

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot

_LOGGER = logging.getLogger(__name__)


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
    colour : tuple of 3 float or None
        Red, green and blue from 0 to 1, None where the description gives no colour.
    """

    path: Path
    link: int
    placement: Array
    scale: Array
    colour: tuple[float, float, float] | None = None


def visual_meshes(robot: Robot) -> list[VisualMesh]:
    """Return the meshes of a robot; shapes that are no mesh (boxes, spheres) are left out.

    A mesh that is not where it should be is left out, too, and said so in the log. The URDF is read here and not
    through Pinocchio's geometry model, which would load every mesh.

    Raises
    ------
    RobotError
        The description cannot be read any more.
    """
    if robot.description is None:
        return []
    from ocp_traj.robot.model import frame_index

    meshes = []
    root = read_document(robot.description)
    colours = {material.get("name"): _colour(material) for material in root.findall("material")}
    for link in root.iter("link"):
        shapes = [shape for shape in link.iter("visual") if shape.find("geometry/mesh") is not None]
        if not shapes:
            continue
        frame = robot.bare_model.frames[frame_index(robot.bare_model, link.attrib["name"])]
        for shape in shapes:
            mesh = shape.find("geometry/mesh")
            assert mesh is not None  # only such shapes were kept
            try:
                path = _mesh_path(mesh.get("filename", ""), robot.description)
            except RobotError as error:
                _LOGGER.warning("%s; it is left out of the picture", error)
                continue
            material = shape.find("material")
            placement = frame.placement.homogeneous @ _origin(shape.find("origin"))
            meshes.append(
                VisualMesh(
                    path=path,
                    link=int(frame.parentJoint),
                    placement=read_only(placement),
                    scale=read_only(_numbers(mesh.get("scale", "1 1 1"))),
                    colour=None if material is None else _colour(material) or colours.get(material.get("name")),
                )
            )
    return meshes


def _colour(material: ElementTree.Element) -> tuple[float, float, float] | None:
    """Return the colour that a material states itself, None where it states none or no valid one."""
    element = material.find("color")
    if element is None:
        return None
    try:
        red, green, blue, *_ = [min(max(value, 0.0), 1.0) for value in _numbers(element.get("rgba", ""))]
    except ValueError:
        return None
    return red, green, blue


def _numbers(text: str) -> list[float]:
    return [float(word) for word in text.split()]


def _origin(element: ElementTree.Element | None) -> Array:
    """Return the transform (4, 4) of a URDF ``origin``, the identity without one."""
    import pinocchio as pin

    if element is None:
        return np.eye(4)
    rotation = pin.rpy.rpyToMatrix(np.array(_numbers(element.get("rpy", "0 0 0"))))
    return pin.SE3(rotation, np.array(_numbers(element.get("xyz", "0 0 0")))).homogeneous


def _mesh_path(address: str, description: Path) -> Path:
    """Return the file of a mesh address: ``package://``, ``file://`` or relative to the URDF.

    Packages are looked for among the URDF's ancestors and on ROS's package path.
    """
    if address.startswith("package://"):
        named = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
        folders = [*description.resolve().parents, *(Path(folder) for folder in named if folder)]
        candidates = [folder / address.removeprefix("package://") for folder in folders]
    else:
        candidates = [description.parent / address.removeprefix("file://")]
    for path in candidates:
        if path.is_file():
            return path
    raise RobotError(f"mesh {address} of {description} is not there")
