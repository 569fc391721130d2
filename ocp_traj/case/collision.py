"""The ``[collision]`` table of a case file: obstacles, bodies at the tool, margins, contact on purpose."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

from ocp_traj.case.robots import resolve_inside
from ocp_traj.case.section import Section, describe
from ocp_traj.collision.scene import (
    IDENTITY,
    MOST_PIECES,
    PAIRS,
    SIZES,
    CollisionScene,
    Contact,
    Shape,
    Solid,
)
from ocp_traj.exceptions import TaskError

KEYS = ("margin", "self", "self_margin", "pairs", "cover", "ignore", "tool", "obstacles", "contact")
"""Keys of ``[collision]``."""

MOST_BODIES = 10_000
"""Most obstacles of a case."""

_NUMBERED = {"cylinder": ("radius", "length"), "capsule": ("radius", "length")}


def read_collision(
    case: Section, gaps: int, folder: Path, trusted: Collection[str]
) -> CollisionScene | None:
    """Return the scene of a case file, None without ``[collision]``.

    Parameters
    ----------
    case : Section
        The whole file.
    gaps : int
        Gaps between waypoints.
    folder : pathlib.Path
        Where the case file lies: meshes are relative to it and stay below it.
    trusted : collection of str
        Dotted keys the caller set by hand, whose paths may lead anywhere.

    Raises
    ------
    CaseError
        A key is unknown or wrong, or a gap, waypoint or file does not exist.
    """
    if "collision" not in case:
        return None
    section = case.section("collision")
    section.check_keys(KEYS)
    if "robot" not in case:
        raise section.error("", "needs a robot, but the case has no [robot]")
    obstacles = [_solid(entry, gaps, folder, trusted, "margin") for entry in section.sections("obstacles")]
    if len(obstacles) > MOST_BODIES:
        raise section.error("obstacles", f"{len(obstacles)} given, expected at most {MOST_BODIES}")
    return CollisionScene(
        obstacles=tuple(obstacles),
        tool=tuple(_solid(entry, gaps, folder, trusted) for entry in section.sections("tool")),
        margin=_length(section, "margin", 0.0),
        self_margin=_length(section, "self_margin", 0.0),
        with_itself=_truth(section, "self", True),
        pairs=section.choice("pairs", PAIRS, PAIRS[0]),
        cover=_cover(section),
        ignore=_name_pairs(section, "ignore"),
        contact=tuple(_contact(entry, gaps) for entry in section.sections("contact")),
    )


def _cover(section: Section) -> int:
    cover = section.integer("cover", 16, MOST_PIECES)
    if cover < 1:
        raise section.error("cover", f"{cover} given, expected 1 to {MOST_PIECES} convex pieces")
    return cover


def _length(section: Section, name: str, default: float | None) -> float:
    value = section.number(name, default)
    if value < 0:
        raise section.error(name, f"{value:g} given, expected a length of 0 or more, m")
    return value


def _truth(section: Section, name: str, default: bool) -> bool:
    value = section.data.get(name, default)
    if not isinstance(value, bool):
        raise section.error(name, f"{describe(value)} given, expected true or false")
    return value


def _solid(entry: Section, gaps: int, folder: Path, trusted: Collection[str], *more: str) -> Solid:
    entry.check_keys(("name", *SIZES, "convex", "pose", "gaps", *more))
    kinds = [kind for kind in SIZES if kind in entry]
    if len(kinds) != 1:
        raise entry.error("", f"{' and '.join(kinds) or 'no shape'} given, expected one of {', '.join(SIZES)}")
    convex = _truth(entry, "convex", False)
    if convex and kinds != ["mesh"]:
        raise entry.error("convex", "belongs to a mesh, but another shape is given")
    pose = tuple(entry.array_of_shape("pose", (7,)).tolist()) if "pose" in entry else IDENTITY
    margin = _length(entry, "margin", None) if "margin" in entry else None
    try:
        shape = _shape(entry, kinds[0], convex, folder, trusted)
        return Solid(entry.text("name"), shape, pose, margin, _gaps(entry, gaps))
    except TaskError as error:
        raise entry.error("", error.problem) from error


def _shape(entry: Section, kind: str, convex: bool, folder: Path, trusted: Collection[str]) -> Shape:
    if kind == "mesh":
        return Shape(kind, mesh=resolve_inside(entry, kind, folder, trusted), convex=convex)
    if kind == "sphere":
        size: tuple[float, ...] = (entry.number(kind),)
    elif kind in _NUMBERED:
        table = entry.section(kind)
        table.check_keys(_NUMBERED[kind])
        size = tuple(table.number(name) for name in _NUMBERED[kind])
    else:
        size = tuple(entry.array_of_shape(kind, (SIZES[kind],)).tolist())
    return Shape(kind, size)


def _gaps(entry: Section, gaps: int) -> tuple[int, ...] | None:
    """Return the gaps that a body is there in, from 0; None for all."""
    if "gaps" not in entry:
        return None
    given = entry.data["gaps"]
    if not isinstance(given, list) or not given:
        raise entry.error("gaps", f"{describe(given)} given, expected a list of gaps from 1 to {gaps}")
    for value in given:
        if not isinstance(value, int) or isinstance(value, bool) or not 1 <= value <= gaps:
            raise entry.error("gaps", f"{describe(value)} given, expected gaps from 1 to {gaps}")
    return tuple(value - 1 for value in given)


def _name_pairs(section: Section, name: str) -> tuple[tuple[str, str], ...]:
    given = section.data.get(name, [])
    if not isinstance(given, list):
        raise section.error(name, f"{describe(given)} given, expected a list of pairs of names")
    return tuple(_two_names(section, f"{name}[{index + 1}]", pair) for index, pair in enumerate(given))


def _two_names(section: Section, name: str, value: Any) -> tuple[str, str]:
    if not isinstance(value, list) or len(value) != 2 or not all(isinstance(entry, str) for entry in value):
        raise section.error(name, f"{describe(value)} given, expected two names of bodies")
    return value[0], value[1]


def _contact(entry: Section, gaps: int) -> Contact:
    entry.check_keys(("bodies", "waypoint", "within", "depth"))
    waypoint = entry.integer("waypoint", None, gaps + 1)
    if waypoint < 1:
        raise entry.error("waypoint", f"{waypoint} given, expected 1 to {gaps + 1}")
    bodies = _two_names(entry, "bodies", entry.data.get("bodies"))
    return Contact(bodies, waypoint - 1, _length(entry, "within", None), _length(entry, "depth", None))


def collision_table(scene: CollisionScene, folder: Path) -> dict[str, Any]:
    """Return the table of a case file that states a scene; what is default is left out.

    Parameters
    ----------
    scene : CollisionScene
    folder : pathlib.Path
        Where the file will lie: meshes are named relative to it.

    Raises
    ------
    TaskError
        A mesh does not lie below the folder.
    """
    plain = CollisionScene()
    named = {"margin": "margin", "self_margin": "self_margin", "pairs": "pairs", "cover": "cover"}
    named["self"] = "with_itself"
    table: dict[str, Any] = {
        key: getattr(scene, name) for key, name in named.items() if getattr(scene, name) != getattr(plain, name)
    }
    if scene.ignore:
        table["ignore"] = [list(pair) for pair in scene.ignore]
    for key, solids in (("tool", scene.tool), ("obstacles", scene.obstacles)):
        if solids:
            table[key] = [_solid_table(solid, folder) for solid in solids]
    if scene.contact:
        table["contact"] = [
            {
                "bodies": list(contact.bodies),
                "waypoint": contact.waypoint + 1,
                "within": contact.within,
                "depth": contact.depth,
            }
            for contact in scene.contact
        ]
    return table


def _solid_table(solid: Solid, folder: Path) -> dict[str, Any]:
    shape = solid.shape
    table: dict[str, Any] = {"name": solid.name}
    if shape.mesh is not None:
        table["mesh"] = below(shape.mesh, folder, f"collision.{solid.name}.mesh")
        if shape.convex:
            table["convex"] = True
    elif shape.kind == "sphere":
        table["sphere"] = shape.size[0]
    elif shape.kind in _NUMBERED:
        table[shape.kind] = dict(zip(_NUMBERED[shape.kind], shape.size, strict=True))
    else:
        table[shape.kind] = list(shape.size)
    if solid.pose != IDENTITY:
        table["pose"] = list(solid.pose)
    if solid.margin is not None:
        table["margin"] = solid.margin
    if solid.gaps is not None:
        table["gaps"] = [gap + 1 for gap in solid.gaps]
    return table


def below(path: Path, folder: Path, key: str) -> str:
    """Return a file's path relative to the folder of a case file.

    Raises
    ------
    TaskError
        It does not lie below that folder; names the key.
    """
    try:
        return path.resolve().relative_to(folder.resolve()).as_posix()
    except ValueError:
        raise TaskError(key, f"{path.name} does not lie below the folder of the case file") from None
