"""Read the triangles of mesh files and thin them out for a web page."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError

Triangles = npt.NDArray[np.int64]

FORMATS = (".stl", ".obj", ".dae")
"""Endings of the mesh files that robot descriptions name."""

_UNIT = re.compile(rb"""<unit\b[^>]*\bmeter\s*=\s*["']\s*([-+.\deE]+)""")
MAX_BYTES = 100_000_000
_KEY_BITS = 20
_MAX_VERTICES = 2**_KEY_BITS


@dataclass(frozen=True)
class Mesh:
    """Vertices (V, 3), m, and triangles (F, 3) of vertex numbers."""

    vertices: Array
    triangles: Triangles


def read_mesh(path: Path) -> Mesh:
    """Return the triangles of an STL, OBJ or Collada file, in the file's own frame and in metres.

    Read in single precision by Assimp, which comes with Pinocchio: equal corners are joined, triangles without
    area are left out, a Collada file's unit and nodes count and its up axis does not, as robot descriptions expect.

    Raises
    ------
    InputError
        The format is another one, or the file cannot be read as what its ending says.
    """
    import coal

    if path.suffix.lower() not in FORMATS:
        raise InputError(f"{path.name}: meshes of this format are not read, expected {', '.join(FORMATS)}")
    try:
        if path.stat().st_size > MAX_BYTES:
            raise InputError(f"{path.name}: is larger than {MAX_BYTES} bytes")
        unit = _collada_unit(path) if path.suffix.lower() == ".dae" else 1.0
        shape = coal.MeshLoader(coal.NODE_TYPE.BV_AABB).load(str(path), np.full(3, unit))
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = str(error).split("message: ")[-1].replace("\n", " ")
        raise InputError(f"{path.name}: cannot be read as a mesh ({reason})") from None
    if shape.num_vertices > _MAX_VERTICES:
        raise InputError(f"{path.name}: has more than {_MAX_VERTICES} vertices")
    vertices = np.array(shape.vertices(), dtype=np.float64).reshape(-1, 3)
    if not np.isfinite(vertices).all():
        raise InputError(f"{path.name}: has a vertex that is not finite")
    faces = map(shape.tri_indices, range(shape.num_tris))
    corners = [(face[0], face[1], face[2]) for face in faces]
    return Mesh(vertices, np.array(corners, dtype=np.int64).reshape(-1, 3))


def _collada_unit(path: Path) -> float:
    """Return a Collada file's unit in metres, which the loader leaves out of account."""
    unit = _UNIT.search(path.read_bytes())
    return float(unit[1]) if unit else 1.0


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
