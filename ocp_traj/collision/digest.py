"""One hash for all shapes of a cell."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.collision.pairs import srdf_file
from ocp_traj.collision.scene import CollisionScene, Shape, Solid
from ocp_traj.robot.meshes import collision_shapes

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot


def geometry_digest(robot: Robot, scene: CollisionScene) -> str:
    """Return a hash of all shapes of a cell: what is said of the scene, and the contents of the files it names."""
    text = hashlib.sha256()
    for shape in collision_shapes(robot):
        numbers = " ".join(f"{value + 0.0:.11e}" for value in (*np.round(shape.placement, 12).ravel(), *shape.size))
        text.update(f"{shape.link} {shape.joint} {shape.kind} {numbers}\n".encode())
        text.update(_content(shape.path))
    if scene.pairs == "srdf":
        text.update(_content(srdf_file(robot)))
    for solid in (*scene.tool, *scene.obstacles):
        text.update(_in_words(solid).encode())
        text.update(_content(solid.shape.mesh))
    return text.hexdigest()


def _in_words(solid: Solid) -> str:
    shape: Shape = solid.shape
    numbers = " ".join(f"{value + 0.0:.11e}" for value in (*solid.pose, *shape.size))
    return f"{solid.name} {shape.kind} {shape.convex} {numbers} {solid.margin} {solid.gaps}\n"


def _content(path: Path | None) -> bytes:
    return b"" if path is None else hashlib.sha256(path.read_bytes()).digest()
