"""Distances of two placed bodies and the planes between them, proposed by coal."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.collision.bodies import Body, Convex, HalfSpace


@dataclass(frozen=True)
class Nearest:
    """How far two bodies are from each other, and where.

    Attributes
    ----------
    distance : float
        m, negative where they overlap.
    normal : (3,)
        Unit vector from the first to the second.
    points : two (3,)
        The nearest (deepest) point of each, in the root's frame, m.
    """

    distance: float
    normal: Array
    points: tuple[Array, Array]


@cache
def _request() -> Any:
    import coal

    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    return request


class Measure:
    """Distances of bodies at one configuration.

    Parameters
    ----------
    places : (n + 1, 4, 4)
        Placements of the joints in the root's frame.

    Attributes
    ----------
    calls : int
        Distances measured so far.
    """

    def __init__(self, places: Array) -> None:
        self.places = places
        self.calls = 0
        self._transforms: dict[int, Any] = {}

    def _transform(self, joint: int) -> Any:
        import coal

        if joint not in self._transforms:
            place = self.places[joint]
            self._transforms[joint] = coal.Transform3s(place[:3, :3], place[:3, 3])
        return self._transforms[joint]

    def _measure(self, a: Body, joint_a: int, b: Body, joint_b: int) -> tuple[float, Any]:
        import coal

        self.calls += 1
        shape_a, own_a = a.proposer
        shape_b, own_b = b.proposer
        at_a, at_b = self._transform(joint_a), self._transform(joint_b)
        at_a, at_b = at_a if own_a is None else at_a * own_a, at_b if own_b is None else at_b * own_b
        result = coal.DistanceResult()
        return coal.distance(shape_a, at_a, shape_b, at_b, _request(), result), result

    def plane(self, a: Convex, joint_a: int, b: Body, joint_b: int) -> tuple[float, Array]:
        """Return the signed distance of two bodies, m, and a normal (3,) from the first to the second, not normalised.

        Parameters
        ----------
        a, b : Convex, Body
        joint_a, joint_b : int
            What carries them.
        """
        if isinstance(a, HalfSpace):
            nearest = self._from_half_space(a, b, joint_b)
            return nearest.distance, nearest.normal
        distance, result = self._measure(a, joint_a, b, joint_b)
        return distance, result.normal

    def nearest(self, a: Convex, joint_a: int, b: Body, joint_b: int) -> Nearest:
        """Return distance, unit normal and nearest points of two bodies; see `plane`."""
        if isinstance(a, HalfSpace):
            return self._from_half_space(a, b, joint_b)
        distance, result = self._measure(a, joint_a, b, joint_b)
        normal = np.array(result.normal)
        points = np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2())
        return Nearest(distance, normal / max(float(np.linalg.norm(normal)), 1e-300), points)

    def _from_half_space(self, a: HalfSpace, b: Body, joint_b: int) -> Nearest:
        place = self.places[joint_b]
        local = place[:3, :3].T @ a.normal
        lowest = float(b.lowest(local[None])[0] + a.normal @ place[:3, 3])
        vertex = b.vertices[int(np.argmin(b.vertices @ local))]
        point = place[:3, :3] @ vertex + place[:3, 3]
        point = point + (lowest - float(a.normal @ point)) * a.normal
        distance = lowest - a.offset
        return Nearest(distance, np.asarray(a.normal), (point - distance * a.normal, point))
