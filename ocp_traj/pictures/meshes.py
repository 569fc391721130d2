"""Thin out the triangles of meshes for a web page."""

from __future__ import annotations

import numpy as np

from ocp_traj.collision.mesh_files import Mesh, Triangles

_KEY_BITS = 20


def thin_out(mesh: Mesh, most: int) -> Mesh:
    """Return a mesh of at most `most` triangles: vertices of one cell of a grid become their mean.

    Source: Rossignac and Borrel, Multi-resolution 3D approximations (1993). The finest grid that suffices is
    found by bisection.
    """
    mesh = _clustered(mesh, float(2**_KEY_BITS - 2))
    if len(mesh.triangles) <= most:
        return mesh
    low, high = 2.0, 512.0
    best = _clustered(mesh, low)
    for _ in range(12):
        middle = float(np.sqrt(low * high))
        candidate = _clustered(mesh, middle)
        if len(candidate.triangles) <= most:
            low, best = middle, candidate
        else:
            high = middle
    return best


def _clustered(mesh: Mesh, cells: float) -> Mesh:
    """Join the vertices in each cell of a grid to their mean; drop triangles that lost a corner or are double."""
    if not mesh.triangles.size:
        return mesh
    lower = mesh.vertices.min(axis=0)
    size = float((mesh.vertices.max(axis=0) - lower).max()) / cells
    cell = np.floor((mesh.vertices - lower) / max(size, 1e-12)).astype(np.int64)
    _, inverse, counts = np.unique(_code(cell), return_inverse=True, return_counts=True)
    inverse = np.asarray(inverse).reshape(-1)
    means = np.zeros((counts.size, 3))
    np.add.at(means, inverse, mesh.vertices)
    means /= counts[:, None]
    corners = inverse[mesh.triangles]
    whole = (
        (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2]) & (corners[:, 2] != corners[:, 0])
    )
    corners = corners[whole]
    _, first = np.unique(_code(np.sort(corners, axis=1)), return_index=True)
    corners = corners[np.sort(first)]
    used, renumbered = np.unique(corners, return_inverse=True)
    return Mesh(means[used], np.asarray(renumbered, dtype=np.int64).reshape(-1, 3))


def _code(rows: Triangles) -> Triangles:
    """Return one number for every row of three numbers below 2^20: sorting numbers is fast."""
    return np.asarray((rows[:, 0] << 2 * _KEY_BITS) | (rows[:, 1] << _KEY_BITS) | rows[:, 2])
