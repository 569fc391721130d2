"""What a person says about collision: obstacles, bodies at the tool, margins, and what may touch."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import TaskError

SIZES = {"box": 3, "sphere": 1, "cylinder": 2, "capsule": 2, "halfspace": 4, "mesh": 0}
"""How many numbers say how large a shape of each kind is."""

PAIRS = ("adjacent", "srdf")
"""Which pairs of links are left out: those that share a joint, or those that an SRDF lists."""

MOST_PIECES = 256
"""Most convex pieces of a link's mesh."""

IDENTITY = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
"""The pose that moves nothing: x, y, z in m, and a unit quaternion qx, qy, qz, qw."""


@dataclass(frozen=True)
class Shape:
    """One solid.

    Parameters
    ----------
    kind : str
        A key of `SIZES`.
    size : tuple of float
        Full sizes of a box along x, y, z; the radius of a sphere; radius and length along z of a cylinder or capsule
        (of the latter between the centres of its half-spheres); normal and offset of a half-space, all points with
        normal . p <= offset; m. Empty for a mesh.
    mesh : pathlib.Path, optional
        STL, DAE or OBJ, m.
    convex : bool
        Take a mesh as its hull.
    """

    kind: str
    size: tuple[float, ...] = ()
    mesh: Path | None = None
    convex: bool = False

    def __post_init__(self) -> None:
        if self.kind not in SIZES:
            raise TaskError("collision", f"shape {self.kind!r} given, expected one of {', '.join(SIZES)}")
        size = tuple(float(value) for value in self.size)
        object.__setattr__(self, "size", size)
        if len(size) != SIZES[self.kind] or not all(math.isfinite(value) for value in size):
            raise TaskError("collision", f"{self.kind} of {size} given, expected {SIZES[self.kind]} finite numbers")
        if self.kind == "halfspace":
            if not any(size[:3]):
                raise TaskError("collision", "a halfspace with normal 0 given, expected a direction")
        elif not all(value > 0 for value in size):
            raise TaskError("collision", f"{self.kind} of {size} given, expected sizes above 0, m")
        if (self.kind == "mesh") != (self.mesh is not None):
            raise TaskError("collision", "expected a mesh file for a mesh, and none for another shape")


@dataclass(frozen=True)
class Solid:
    """A named solid: an obstacle at rest in the base frame, or a body fixed to the tool frame.

    Parameters
    ----------
    name : str
    shape : Shape
    pose : tuple of 7 float
        x, y, z in m and a unit quaternion qx, qy, qz, qw, in the base frame or in the tool frame.
    margin : float, optional
        Distance that is kept to an obstacle, m; default that of the scene.
    gaps : tuple of int, optional
        Gaps between waypoints, from 0, in which it is there; default all.
    """

    name: str
    shape: Shape
    pose: tuple[float, ...] = IDENTITY
    margin: float | None = None
    gaps: tuple[int, ...] | None = None

    def __post_init__(self) -> None:
        pose = tuple(float(value) for value in self.pose)
        if len(pose) != 7 or not all(math.isfinite(value) for value in pose):
            raise TaskError("collision", f"pose of {self.name} is {pose}, expected x, y, z, qx, qy, qz, qw")
        if abs(math.sqrt(sum(value * value for value in pose[3:])) - 1.0) > 1e-3:
            raise TaskError("collision", f"quaternion of {self.name} is {pose[3:]}, expected one of length 1")
        object.__setattr__(self, "pose", pose)
        if self.gaps is not None:
            object.__setattr__(self, "gaps", tuple(sorted(set(self.gaps))))

    @property
    def placement(self) -> Array:
        """The pose as a placement (4, 4)."""
        x, y, z, w = np.array(self.pose[3:]) / np.linalg.norm(self.pose[3:])
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        place = np.eye(4)
        place[:3, :3] += 2.0 * (w * cross + cross @ cross)
        place[:3, 3] = self.pose[:3]
        return place


@dataclass(frozen=True)
class Contact:
    """Two bodies that may overlap a little around a waypoint.

    Parameters
    ----------
    bodies : two str
    waypoint : int
        From 0.
    within : float
        s before and after the waypoint.
    depth : float
        How far they may overlap then, m.
    """

    bodies: tuple[str, str]
    waypoint: int
    within: float
    depth: float


@dataclass(frozen=True)
class CollisionScene:
    """Everything that a motion must not touch, and how near it may come.

    Parameters
    ----------
    obstacles, tool : tuple of Solid
        At rest in the cell, and fixed to the tool.
    margin, self_margin : float
        Distance to keep from obstacles, and of the robot's own bodies from each other, m.
    with_itself : bool
        Whether the robot's own bodies are judged against each other.
    pairs : str
        Pairs of links that are left out, one of `PAIRS`.
    cover : int
        Most convex pieces of a link's mesh.
    ignore : tuple of pairs of str
        More pairs that are left out.
    contact : tuple of Contact

    Raises
    ------
    TaskError
        A number or name is impossible.
    """

    obstacles: tuple[Solid, ...] = ()
    tool: tuple[Solid, ...] = ()
    margin: float = 0.0
    self_margin: float = 0.0
    with_itself: bool = True
    pairs: str = "adjacent"
    cover: int = 16
    ignore: tuple[tuple[str, str], ...] = ()
    contact: tuple[Contact, ...] = ()

    def __post_init__(self) -> None:
        for name in ("margin", "self_margin"):
            _check_length(f"collision.{name}", getattr(self, name))
        if self.pairs not in PAIRS:
            raise TaskError("collision.pairs", f"{self.pairs!r} given, expected one of {', '.join(PAIRS)}")
        if not 1 <= self.cover <= MOST_PIECES:
            raise TaskError("collision.cover", f"{self.cover} given, expected 1 to {MOST_PIECES} pieces")
        names = [solid.name for solid in (*self.tool, *self.obstacles)]
        twice = [name for name in names if names.count(name) > 1]
        if twice:
            raise TaskError("collision", f"two bodies are called {twice[0]!r}, expected names of their own")
        for solid in self.obstacles:
            if solid.margin is not None:
                _check_length(f"collision.obstacles.{solid.name}.margin", solid.margin)
        for solid in self.tool:
            if solid.shape.kind == "halfspace":
                raise TaskError("collision.tool", f"{solid.name} is a halfspace, expected a body of finite size")
        for contact in self.contact:
            _check_length("collision.contact.within", contact.within)
            _check_length("collision.contact.depth", contact.depth)

    def check_gaps(self, gaps: int) -> None:
        """Raise TaskError where a gap or waypoint is named that a task of so many gaps does not have."""
        for key, solids in (("tool", self.tool), ("obstacles", self.obstacles)):
            for solid in solids:
                beyond = [gap + 1 for gap in solid.gaps or () if not 0 <= gap < gaps]
                if beyond:
                    raise TaskError(
                        f"collision.{key}.{solid.name}.gaps", f"{beyond[0]} given, expected gaps 1 to {gaps}"
                    )
        for contact in self.contact:
            if not 0 <= contact.waypoint <= gaps:
                raise TaskError(
                    "collision.contact.waypoint",
                    f"{contact.waypoint + 1} given, expected waypoints 1 to {gaps + 1}",
                )


def _check_length(key: str, value: Any) -> None:
    if not (math.isfinite(value) and value >= 0):
        raise TaskError(key, f"{value:g} given, expected a finite number of 0 or more")
