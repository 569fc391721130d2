"""Read the triangles of mesh files (STL, OBJ, Collada) and thin them out for a web page."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError

Triangles = npt.NDArray[np.int64]

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

    Raises
    ------
    InputError
        The format is another one, or the file cannot be read as what its ending says.
    """
    readers = {".stl": _read_stl, ".obj": _read_obj, ".dae": _read_collada}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{path.name}: meshes of this format are not read, expected {', '.join(readers)}")
    try:
        if path.stat().st_size > MAX_BYTES:
            raise InputError(f"{path.name}: is larger than {MAX_BYTES} bytes")
        mesh = reader(path.read_bytes())
    except (OSError, ValueError, IndexError, KeyError, ElementTree.ParseError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path.name}: cannot be read as a mesh ({error})") from None
    if len(mesh.vertices) > _MAX_VERTICES:
        raise InputError(f"{path.name}: has more than {_MAX_VERTICES} vertices")
    if mesh.triangles.size and not (mesh.triangles.min() >= 0 and mesh.triangles.max() < len(mesh.vertices)):
        raise InputError(f"{path.name}: a triangle refers to a vertex that is not there")
    return mesh


def _read_stl(data: bytes) -> Mesh:
    count = int.from_bytes(data[80:84], "little")
    if len(data) == 84 + 50 * count:
        layout = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
        corners = np.frombuffer(data, layout, count, 84)["corners"].reshape(-1, 3)
    else:
        words = data.decode("ascii", errors="replace").split()
        places = [place for place, word in enumerate(words) if word == "vertex"]
        corners = np.array([[float(value) for value in words[place + 1 : place + 4]] for place in places])
    return merge_corners(np.asarray(corners, dtype=np.float64).reshape(-1, 3))


def merge_corners(corners: Array) -> Mesh:
    """Return a mesh of triangles given corner by corner (3 F, 3), equal corners joined."""
    vertices, inverse = np.unique(corners, axis=0, return_inverse=True)
    return Mesh(vertices, np.asarray(inverse, dtype=np.int64).reshape(-1, 3))


def _read_obj(data: bytes) -> Mesh:
    vertices: list[list[float]] = []
    triangles: list[list[int]] = []
    for line in data.decode(errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(value) for value in words[1:4]])
        elif words[:1] == ["f"]:
            numbers = [int(word.split("/")[0]) for word in words[1:]]
            corners = [number - 1 if number > 0 else len(vertices) + number for number in numbers]
            triangles += [[corners[0], corners[k], corners[k + 1]] for k in range(1, len(corners) - 1)]
    return Mesh(np.array(vertices).reshape(-1, 3), np.array(triangles, dtype=np.int64).reshape(-1, 3))


def _read_collada(data: bytes) -> Mesh:
    """Return all geometry instances of the scene, placed by their nodes."""
    if b"<!ENTITY" in data:
        raise ValueError("entities are not allowed")
    root = ElementTree.fromstring(data)
    space = root.tag.partition("}")[0] + "}" if root.tag.startswith("{") else ""
    geometries = {
        entry.get("id", ""): _collada_geometry(entry, space) for entry in root.iter(f"{space}geometry")
    }
    vertices: list[Array] = []
    triangles: list[Triangles] = []
    placement = _collada_unit(root, space)
    for scene in root.iter(f"{space}visual_scene"):
        for node in scene.findall(f"{space}node"):
            _place_node(node, placement, space, geometries, vertices, triangles)
    if not vertices:
        raise ValueError("no triangles in its scene")
    return Mesh(np.concatenate(vertices), np.concatenate(triangles))


def _collada_unit(root: ElementTree.Element, space: str) -> Array:
    """Return the placement that turns the file's unit into metres.

    The file's up axis is ignored, as robot descriptions expect and their other readers do.
    """
    unit = root.find(f"{space}asset/{space}unit")
    scale = float(unit.get("meter", "1")) if unit is not None else 1.0
    return np.diag([scale, scale, scale, 1.0])


def _place_node(
    node: ElementTree.Element,
    parent: Array,
    space: str,
    geometries: dict[str, Mesh],
    vertices: list[Array],
    triangles: list[Triangles],
) -> None:
    placement = parent @ _node_transform(node, space)
    for instance in node.findall(f"{space}instance_geometry"):
        mesh = geometries.get(instance.get("url", "").lstrip("#"))
        if mesh is not None and mesh.triangles.size:
            triangles.append(mesh.triangles + sum(len(block) for block in vertices))
            vertices.append(mesh.vertices @ placement[:3, :3].T + placement[:3, 3])
    for child in node.findall(f"{space}node"):
        _place_node(child, placement, space, geometries, vertices, triangles)


def _node_transform(node: ElementTree.Element, space: str) -> Array:
    transform = np.eye(4)
    for entry in node:
        values = np.array((entry.text or "").split(), dtype=np.float64) if len(entry) == 0 else np.empty(0)
        step = np.eye(4)
        kind = entry.tag.removeprefix(space)
        if kind == "matrix":
            step = values.reshape(4, 4)
        elif kind == "translate":
            step[:3, 3] = values
        elif kind == "scale":
            step[:3, :3] = np.diag(values)
        elif kind == "rotate":
            step[:3, :3] = rotation(values[:3], np.deg2rad(values[3]))
        transform = transform @ step
    return transform


def rotation(axis: Array, angle: float) -> Array:
    """Return the matrix (3, 3) of a turn about an axis, by Rodrigues' formula."""
    x, y, z = np.asarray(axis, dtype=np.float64) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)


def _collada_geometry(geometry: ElementTree.Element, space: str) -> Mesh:
    mesh = geometry.find(f"{space}mesh")
    if mesh is None:
        return Mesh(np.empty((0, 3)), np.empty((0, 3), dtype=np.int64))
    sources = {entry.get("id", ""): entry for entry in mesh.findall(f"{space}source")}
    positions = {}
    for entry in mesh.findall(f"{space}vertices"):
        for given in entry.findall(f"{space}input"):
            if given.get("semantic") == "POSITION":
                positions[entry.get("id", "")] = given.get("source", "").lstrip("#")
    vertices: list[Array] = []
    triangles: list[Triangles] = []
    for kind in ("triangles", "polylist"):
        for block in mesh.findall(f"{space}{kind}"):
            found = _collada_block(block, kind, space, positions)
            if found is None:
                continue
            source, corners = found
            array = sources[source].find(f"{space}float_array")
            points = np.array((array.text or "").split() if array is not None else [], dtype=np.float64)
            triangles.append(corners + sum(len(entry) for entry in vertices))
            vertices.append(points.reshape(-1, 3))
    if not vertices:
        return Mesh(np.empty((0, 3)), np.empty((0, 3), dtype=np.int64))
    return Mesh(np.concatenate(vertices), np.concatenate(triangles))


def _collada_block(
    block: ElementTree.Element, kind: str, space: str, positions: dict[str, str]
) -> tuple[str, Triangles] | None:
    """Return the source of the positions and the triangles (F, 3) of a block of polygons."""
    inputs = block.findall(f"{space}input")
    indices = block.find(f"{space}p")
    if indices is None or not inputs:
        return None
    stride = 1 + max(int(entry.get("offset", "0")) for entry in inputs)
    vertex = next(entry for entry in inputs if entry.get("semantic") == "VERTEX")
    numbers = np.array((indices.text or "").split(), dtype=np.int64).reshape(-1, stride)
    corners = numbers[:, int(vertex.get("offset", "0"))]
    source = positions[vertex.get("source", "").lstrip("#")]
    if kind == "triangles":
        return source, corners.reshape(-1, 3)
    counts = block.find(f"{space}vcount")
    fans = []
    start = 0
    for count in map(int, (counts.text or "").split() if counts is not None else []):
        fans += [[corners[start], corners[start + k], corners[start + k + 1]] for k in range(1, count - 1)]
        start += count
    return source, np.array(fans, dtype=np.int64).reshape(-1, 3)


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
