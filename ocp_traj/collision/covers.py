"""Covers of meshes by convex pieces: one hull, and finer ones where that is too coarse.

The surface is cut by parallel planes, exactly, and each piece is the hull of what lies between two of them. The pieces
hold the surface by construction, and the solid inside a closed one, too: through a point of the solid runs a line along
the cutting planes; where it leaves the solid on either side it meets the surface between the same planes. That
holds for cuts along two directions, hence no piece is cut along a third.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.collision.bodies import Body, Convex, hull
from ocp_traj.collision.mesh_files import Triangles

ROUNDING = 1e-9
"""Thickness added to every hull, m: more than rounding of the cuts and of the hulls' corners."""

BRANCHES = 4
"""Pieces that a piece is cut into at most."""


@dataclass(frozen=True, eq=False)
class Piece:
    """A convex body, and the finer pieces that cover the same matter.

    Attributes
    ----------
    body : Convex
    patch : (F, 3, 3) or None
        Corners of the triangles that the body covers, m; None for an exact shape.
    axes : (A, 3) or None
        Directions along which it may be cut.
    budget : int
        Most pieces that may take its place.
    """

    body: Convex
    patch: Array | None = None
    axes: Array | None = None
    budget: int = 1

    @property
    def divisible(self) -> bool:
        """Whether there are finer pieces."""
        return self.patch is not None and self.axes is not None and self.budget >= 2 and len(self.patch) > 0

    @cached_property
    def finer(self) -> tuple[Piece, ...]:
        """Pieces that cover the same and are smaller; none where the body is exact or the budget is used up."""
        if not self.divisible:
            return ()
        assert self.patch is not None and self.axes is not None
        count = min(BRANCHES, self.budget)
        cuts = [(axis, _slabs(self.patch, axis, count)) for axis in self.axes]
        options = [(axis, patches, [hull(_corners(p), ROUNDING) for p in patches]) for axis, patches in cuts]
        least = min(range(len(options)), key=lambda number: _volume(options[number][2]))
        axis, patches, bodies = options[least]
        later = np.array(self.axes) if len(self.axes) < 3 else np.array([axis, *self._second(least)])
        return tuple(
            Piece(body, patch, later, self.budget // count)
            for body, patch in zip(bodies, patches, strict=True)
        )

    def _second(self, first: int) -> Array:
        """Return the one further direction along which pieces of this one may be cut: the longest left."""
        assert self.axes is not None and self.patch is not None  # only a cover is cut
        others = np.delete(self.axes, first, axis=0)
        lengths = np.ptp(_corners(self.patch) @ others.T, axis=0)
        return others[[int(np.argmax(lengths))]]

    def finest(self) -> list[Piece]:
        """Return the pieces at the end of all cuts."""
        return [last for piece in self.finer for last in piece.finest()] or [self]


def cover(vertices: Array, triangles: Triangles, most: int) -> Piece:
    """Return the cover of a mesh.

    Parameters
    ----------
    vertices : (V, 3)
        m, in the frame of the joint that carries the mesh.
    triangles : (F, 3)
        Vertex numbers.
    most : int
        Most convex pieces.
    """
    patch = vertices[triangles]
    axes = np.linalg.svd(vertices - vertices.mean(axis=0), full_matrices=False)[2]
    return Piece(hull(_corners(patch), ROUNDING), patch, axes, most)


def _corners(patch: Array) -> Array:
    return np.unique(patch.reshape(-1, 3), axis=0)


def _slabs(patch: Array, axis: Array, count: int) -> list[Array]:
    """Cut triangles (F, 3, 3) by parallel planes into `count` patches of even thickness; empty ones are left out."""
    along = patch @ axis
    levels = np.linspace(along.min(), along.max(), count + 1)
    patches = []
    for low, high in zip(levels[:-1], levels[1:], strict=True):
        part = patch
        if low > levels[0]:
            part = _clipped(part, -axis, -low)
        if high < levels[-1]:
            part = _clipped(part, axis, high)
        if len(part):
            patches.append(part)
    return patches


def _clipped(patch: Array, axis: Array, level: float) -> Array:
    """Return what of triangles (F, 3, 3) lies where axis . p <= level, as triangles."""
    beyond = patch @ axis - level
    inside = (beyond <= 0.0).sum(axis=1)
    one, two = inside == 1, inside == 2
    tips, tip_beyond = _rolled(patch[one], beyond[one] <= 0.0, beyond[one])
    first, second = (_crossing(tips, tip_beyond, end) for end in (1, 2))
    lost, lost_beyond = _rolled(patch[two], beyond[two] > 0.0, beyond[two])
    third, fourth = (_crossing(lost, lost_beyond, end) for end in (1, 2))
    return np.concatenate(
        [
            patch[inside == 3],
            np.stack([tips[:, 0], first, second], axis=1),
            np.stack([lost[:, 1], lost[:, 2], third], axis=1),
            np.stack([lost[:, 2], fourth, third], axis=1),
        ]
    )


def _rolled(patch: Array, alone: Array, beyond: Array) -> tuple[Array, Array]:
    """Renumber corners so that the one that is alone on its side comes first."""
    order = (np.argmax(alone, axis=1)[:, None] + np.arange(3)) % 3 if len(patch) else np.zeros((0, 3), int)
    rows = np.arange(len(patch))[:, None]
    return patch[rows, order], beyond[rows, order]


def _crossing(patch: Array, beyond: Array, end: int) -> Array:
    """Return where the edges from corner 0 to another cross the plane, (F, 3)."""
    fraction = (beyond[:, 0] / (beyond[:, 0] - beyond[:, end]))[:, None]
    return np.asarray(patch[:, 0] * (1.0 - fraction) + patch[:, end] * fraction)


def _volume(bodies: list[Body]) -> float:
    from scipy.spatial import ConvexHull

    return float(sum(ConvexHull(body.vertices).volume for body in bodies))


def holds(pieces: list[Piece], vertices: Array, triangles: Triangles) -> bool:
    """Return whether convex pieces contain every triangle of a mesh, proved piece by piece.

    Every triangle is cut as the pieces were; the corners of what is left of it in a piece have to lie in the hull of
    that piece's corners, and the areas of all that is left have to add up to the triangle's.

    Parameters
    ----------
    pieces : list of Piece
        `Piece.finest` of a cover.
    vertices, triangles : (V, 3), (F, 3)
        The mesh.
    """
    from scipy.spatial import ConvexHull

    area = 0.0
    for piece in pieces:
        assert piece.patch is not None and isinstance(piece.body, Body)
        equations = ConvexHull(piece.body.vertices).equations
        beyond = _corners(piece.patch) @ equations[:, :3].T + equations[:, 3]
        if beyond.max() > 0.1 * ROUNDING:
            return False
        area += float(_areas(piece.patch).sum())
    whole = float(_areas(vertices[triangles]).sum())
    return abs(area - whole) <= 1e-9 * whole


def _areas(patch: Array) -> Array:
    sides = np.cross(patch[:, 1] - patch[:, 0], patch[:, 2] - patch[:, 0])
    return np.asarray(0.5 * np.linalg.norm(sides, axis=1))
