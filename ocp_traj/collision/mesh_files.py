"""Triangles of mesh files: STL, OBJ and Collada."""

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
"""Largest mesh file that is read, bytes."""

MAX_VERTICES = 2**20
"""Most vertices of a mesh."""


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
    if shape.num_vertices > MAX_VERTICES:
        raise InputError(f"{path.name}: has more than {MAX_VERTICES} vertices")
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
