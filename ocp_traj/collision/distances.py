"""Distances of two placed bodies and the planes between them, proposed by coal."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.collision.bodies import Body, Convex, HalfSpace


@cache
def _request() -> Any:
    import coal

    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    return request


def signed_distance(a: Convex, place_a: Array, b: Body, place_b: Array) -> tuple[float, Array, Array, Array]:
    """Return how far two bodies are from each other, and where.

    Parameters
    ----------
    a, b : Convex, Body
    place_a, place_b : (4, 4)
        Of the joints that carry them.

    Returns
    -------
    float
        m, negative where they overlap.
    (3,), (3,), (3,)
        Unit normal from a to b, and the nearest (deepest) point of each.
    """
    if isinstance(a, HalfSpace):
        return _from_half_space(a, b, place_b)
    import coal

    shape_a, own_a = a.proposer
    shape_b, own_b = b.proposer
    in_a, in_b = place_a @ own_a, place_b @ own_b
    result = coal.DistanceResult()
    distance = coal.distance(
        shape_a,
        coal.Transform3s(in_a[:3, :3], in_a[:3, 3]),
        shape_b,
        coal.Transform3s(in_b[:3, :3], in_b[:3, 3]),
        _request(),
        result,
    )
    normal = np.array(result.normal)
    return (
        float(distance),
        normal / max(float(np.linalg.norm(normal)), 1e-300),
        np.array(result.getNearestPoint1()),
        np.array(result.getNearestPoint2()),
    )


def _from_half_space(a: HalfSpace, b: Body, place_b: Array) -> tuple[float, Array, Array, Array]:
    local = (place_b[:3, :3].T @ a.normal)[None]
    height = float(b.lowest(local)[0] + a.normal @ place_b[:3, 3])
    along = b.vertices @ local[0]
    point = place_b[:3, :3] @ b.vertices[int(np.argmin(along))] + place_b[:3, 3]
    point = point + (height - float(a.normal @ point)) * a.normal
    return height - a.offset, np.asarray(a.normal), point - (height - a.offset) * a.normal, point
