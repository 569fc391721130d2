"""The bodies of a cell: links, what hangs at the tool, obstacles, each as a cover of convex pieces."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.collision.bodies import box, capsule, cylinder, half_space, hull, sphere, transformed
from ocp_traj.collision.covers import ROUNDING, Piece, cover
from ocp_traj.collision.mesh_files import read_mesh
from ocp_traj.collision.scene import CollisionScene, Solid
from ocp_traj.exceptions import InputError, TaskError
from ocp_traj.robot.meshes import LinkShape, collision_shapes

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class Part:
    """One shape in the cell.

    Attributes
    ----------
    owner : str
        Name of the link, body or obstacle it belongs to.
    kind : str
        "link", "tool" or "obstacle".
    joint : int
        What carries it: 0 for the root, i for what joint i moves.
    piece : Piece
        Its cover, in the frame of that joint.
    margin : float
        To an obstacle, m; 0 for others.
    gaps : tuple of int or None
        Gaps in which it is there, from 0; None for all.
    """

    owner: str
    kind: str
    joint: int
    piece: Piece
    margin: float = 0.0
    gaps: tuple[int, ...] | None = None


def parts_of(robot: Robot, scene: CollisionScene) -> tuple[Part, ...]:
    """Return all parts of a cell: links, bodies at the tool, obstacles.

    Raises
    ------
    RobotError
        A mesh of the robot is missing or cannot be read.
    TaskError
        A mesh of the scene cannot be read.
    """
    links = _link_parts(robot, robot.description, scene.cover)
    joint, place = robot.frame_placement()
    tool = [
        Part(solid.name, "tool", joint, _solid(solid, place, scene.cover), gaps=solid.gaps) for solid in scene.tool
    ]
    obstacles = [
        Part(
            solid.name,
            "obstacle",
            0,
            _solid(solid, robot.base_placement, scene.cover),
            scene.margin if solid.margin is None else solid.margin,
            solid.gaps,
        )
        for solid in scene.obstacles
    ]
    return (*links, *tool, *obstacles)


@lru_cache(maxsize=16)  # two robots with the same dynamics are equal, yet may look different
def _link_parts(robot: Robot, description: Path | None, most: int) -> tuple[Part, ...]:
    return tuple(
        Part(shape.link, "link", shape.joint, _link_piece(shape, most))
        for shape in collision_shapes(robot)
    )


def _link_piece(shape: LinkShape, most: int) -> Piece:
    if shape.path is None:
        return _exact(shape.kind, shape.size, shape.placement)
    mesh = read_mesh(shape.path)
    if not len(mesh.triangles):
        raise InputError(f"{shape.path.name}: has no triangles, expected the shape of link {shape.link}")
    return cover(transformed(shape.placement, mesh.vertices * shape.size), mesh.triangles, most)


def _exact(kind: str, size: tuple[float, ...], place: Array) -> Piece:
    if kind == "box":
        return Piece(box(np.array(size), place))
    if kind == "sphere":
        return Piece(sphere(size[0], place))
    if kind == "halfspace":
        return Piece(half_space(np.array(size[:3]), size[3], place))
    return Piece({"cylinder": cylinder, "capsule": capsule}[kind](size[0], size[1], place))


def _solid(solid: Solid, frame: Array, most: int) -> Piece:
    """Return the cover of a solid whose pose refers to a frame, placed (4, 4) on its joint."""
    shape, place = solid.shape, frame @ solid.placement
    if shape.mesh is None:
        return _exact(shape.kind, shape.size, place)
    try:
        mesh = read_mesh(shape.mesh)
    except InputError as error:
        raise TaskError(f"collision.{solid.name}.mesh", str(error)) from error
    if not len(mesh.triangles):
        raise TaskError(f"collision.{solid.name}.mesh", f"{shape.mesh.name} has no triangles")
    vertices = transformed(place, mesh.vertices)
    return Piece(hull(vertices, ROUNDING)) if shape.convex else cover(vertices, mesh.triangles, most)
