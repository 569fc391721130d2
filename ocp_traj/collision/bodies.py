"""Convex bodies with exact support functions: what separates two of them is proved by these alone."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ocp_traj.arrays import Array, read_only

_THINNEST = 1e-6
"""Half the thickness that a flat set of points is given, m."""

SIGNS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
"""Corners of a box of half sizes 1, (8, 3)."""


@dataclass(frozen=True, eq=False)
class Body:
    """The hull of points, thickened by a ball and by a disc, in the frame of the joint that carries it.

    A sphere is one thickened point, a capsule two, a cylinder two with a disc across, a box has eight corners.

    Attributes
    ----------
    vertices : (V, 3)
        m.
    radius : float
        Of the ball, m.
    disc : float
        Radius of the disc, m.
    axis : (3,) or None
        Unit normal of the disc; None without one.
    """

    vertices: Array
    radius: float = 0.0
    disc: float = 0.0
    axis: Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", read_only(self.vertices))

    @cached_property
    def centre(self) -> Array:
        """Middle of the box around the vertices, (3,), m."""
        return 0.5 * (self.vertices.max(axis=0) + self.vertices.min(axis=0))

    @cached_property
    def ball(self) -> float:
        """Radius of a ball about the centre that holds the body, m."""
        return float(np.linalg.norm(self.vertices - self.centre, axis=1).max()) + self.radius + self.disc

    def lowest(self, directions: Array) -> Array:
        """Return the smallest of direction . p over the points p of the body, for directions (k, 3) of any length."""
        lowest = (directions @ self.vertices.T).min(axis=1)
        if self.radius:
            lowest = lowest - self.radius * np.sqrt((directions * directions).sum(axis=1))
        if self.axis is not None:
            lowest = lowest - self.disc * np.linalg.norm(np.cross(directions, self.axis), axis=1)
        return np.asarray(lowest)

    @cached_property
    def proposer(self) -> tuple[Any, Any]:
        """The body as a shape of coal, and its transform (None: the identity): proposes planes, proves nothing."""
        import coal

        ends = self.vertices
        if len(ends) == 1:
            return coal.Sphere(self.radius), coal.Transform3s(np.eye(3), ends[0])
        if len(ends) == 2:
            axis = ends[1] - ends[0]
            length = float(np.linalg.norm(axis))
            place = coal.Transform3s(_frame_along(axis / length), self.centre)
            shape = coal.Capsule(self.radius, length) if self.axis is None else coal.Cylinder(self.disc, length)
            return shape, place
        points = coal.StdVec_Vec3s()
        points.extend(list(self.vertices))
        return coal.Convex.convexHull(points, True, "Qt"), None


@dataclass(frozen=True, eq=False)
class HalfSpace:
    """All points with normal . p <= offset, in the root's frame; it stands still.

    Attributes
    ----------
    normal : (3,)
        Unit vector that leads out of it.
    offset : float
        m.
    """

    normal: Array
    offset: float

    @property
    def centre(self) -> Array:
        """A point of its boundary, (3,), m."""
        return self.offset * self.normal

    @property
    def ball(self) -> float:
        """Infinite: no ball holds a half-space."""
        return np.inf

    def lowest(self, directions: Array) -> Array:
        """Return the smallest of direction . p, (k,): minus infinity but in the direction against its normal."""
        against = (directions == -self.normal).all(axis=1)
        return np.where(against, -self.offset, -np.inf)


Convex = Body | HalfSpace


def _frame_along(axis: Array) -> Array:
    """Return a rotation whose third column is a unit vector."""
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(axis)))], axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


def transformed(place: Array, points: Array) -> Array:
    """Return points (k, 3) moved by a placement (4, 4)."""
    return np.asarray(points @ place[:3, :3].T + place[:3, 3])


def box(size: Array, place: Array) -> Body:
    """Return a box of full sizes (3,), m, at a placement (4, 4)."""
    return Body(transformed(place, 0.5 * np.asarray(size) * SIGNS))


def sphere(radius: float, place: Array) -> Body:
    """Return a sphere about the origin of a placement."""
    return Body(place[None, :3, 3], radius=radius)


def capsule(radius: float, length: float, place: Array) -> Body:
    """Return a capsule along z; the length is that between the centres of its half-spheres."""
    return Body(transformed(place, 0.5 * length * np.array([[0, 0, -1.0], [0, 0, 1.0]])), radius=radius)


def cylinder(radius: float, length: float, place: Array) -> Body:
    """Return a cylinder along z."""
    ends = 0.5 * length * np.array([[0, 0, -1.0], [0, 0, 1.0]])
    return Body(transformed(place, ends), disc=radius, axis=read_only(place[:3, 2]))


def half_space(normal: Array, offset: float, place: Array) -> HalfSpace:
    """Return the half-space normal . p <= offset of a placed frame; the normal may have any length."""
    length = float(np.linalg.norm(normal))
    direction = place[:3, :3] @ (np.asarray(normal) / length)
    return HalfSpace(read_only(direction), offset / length + float(direction @ place[:3, 3]))


def hull(points: Array, thickness: float = 0.0) -> Body:
    """Return the hull of points (k, 3), thickened by a ball; flat sets become a box a little thicker than they are."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return Body(points[np.unique(ConvexHull(points).vertices)], radius=thickness)
    except (QhullError, ValueError):
        centre = points.mean(axis=0)
        axes = np.linalg.svd(points - centre, full_matrices=True)[2] if len(points) > 1 else np.eye(3)
        along = (points - centre) @ axes.T
        low, high = along.min(axis=0) - _THINNEST, along.max(axis=0) + _THINNEST
        corners = 0.5 * (low + high) + 0.5 * (high - low) * SIGNS
        return Body(centre + corners @ axes, radius=thickness)
