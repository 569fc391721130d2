"""Which pairs of bodies are judged, and which are left out and why."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

from ocp_traj.collision.parts import Part
from ocp_traj.collision.scene import CollisionScene
from ocp_traj.exceptions import TaskError
from ocp_traj.robot.description.document import read_document
from ocp_traj.robot.meshes import collision_shapes

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot

Names = tuple[str, str]


@dataclass(frozen=True)
class Pair:
    """Two parts that move with respect to each other.

    Attributes
    ----------
    first, second : int
        Numbers of the parts, that nearer the base first.
    margin : float
        Distance to keep, m.
    gaps : tuple of int or None
        Gaps in which both are there, from 0; None for all.
    left_out : bool
        Judged for touching only: an SRDF says it never does.
    """

    first: int
    second: int
    margin: float
    gaps: tuple[int, ...] | None = None
    left_out: bool = False


@dataclass(frozen=True)
class LeftOut:
    """A pair that keeps no margin, and why: it shares a joint, an SRDF lists it, or the scene ignores it."""

    bodies: Names
    reason: str

    def __str__(self) -> str:
        return f"{self.bodies[0]} and {self.bodies[1]} ({self.reason})"


def pairs_of(
    robot: Robot, scene: CollisionScene, parts: tuple[Part, ...]
) -> tuple[tuple[Pair, ...], tuple[LeftOut, ...]]:
    """Return the pairs of parts that are judged, and the named pairs that are left out.

    Raises
    ------
    RobotError, TaskError
        There is no SRDF to read.
    """
    reasons = _reasons(robot, scene, parts)
    pairs, left_out = [], {}
    for first, second in combinations(range(len(parts)), 2):
        a, b = parts[first], parts[second]
        if a.joint == b.joint or not (scene.with_itself or "obstacle" in (a.kind, b.kind)):
            continue
        gaps = _common(a.gaps, b.gaps)
        if gaps == ():
            continue
        reason = reasons.get(_key(a.owner, b.owner), "")
        if reason:
            left_out[_key(a.owner, b.owner)] = LeftOut((a.owner, b.owner), reason)
        if reason in ("", SRDF):
            margin = max(a.margin, b.margin) if "obstacle" in (a.kind, b.kind) else scene.self_margin
            order = (first, second) if a.joint <= b.joint else (second, first)
            pairs.append(Pair(*order, 0.0 if reason else margin, gaps, bool(reason)))
    return tuple(pairs), tuple(left_out.values())


SHARED, SRDF, IGNORED = "they share a joint", "listed in the SRDF", "ignored"


def _reasons(robot: Robot, scene: CollisionScene, parts: tuple[Part, ...]) -> dict[Names, str]:
    reasons: dict[Names, str] = {}
    if scene.pairs == "srdf":
        reasons.update(dict.fromkeys(_disabled(srdf_file(robot)), SRDF))
    links = {part.owner for part in parts if part.kind == "link"}
    reasons.update(dict.fromkeys(_sharing_a_joint(robot, links), SHARED))
    reasons.update({_key(*pair): IGNORED for pair in scene.ignore})
    return reasons


def check_names(robot: Robot, scene: CollisionScene) -> None:
    """Raise TaskError where a scene names a body that does not exist, or gives one the name of a link."""
    links = {shape.link for shape in collision_shapes(robot)}
    own = {solid.name for solid in (*scene.tool, *scene.obstacles)}
    if links & own:
        raise TaskError("collision", f"{min(links & own)!r} is the name of a link, expected another for the body")
    named = [("ignore", pair) for pair in scene.ignore] + [("contact", entry.bodies) for entry in scene.contact]
    for key, pair in named:
        for name in pair:
            if name not in links | own:
                known = ", ".join(sorted(links | own))
                raise TaskError(f"collision.{key}", f"{name!r} is no body, those are {known}")


def _key(a: str, b: str) -> Names:
    return (a, b) if a <= b else (b, a)


def _common(a: tuple[int, ...] | None, b: tuple[int, ...] | None) -> tuple[int, ...] | None:
    if a is None or b is None:
        return b if a is None else a
    return tuple(sorted(set(a) & set(b)))


def _sharing_a_joint(robot: Robot, links: set[str]) -> list[Names]:
    """Return every link with its nearest one towards the base; links without a shape are passed over."""
    if robot.description is None:
        return []
    parents = {}
    for joint in read_document(robot.description).iterfind("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            parents[child.get("link", "")] = parent.get("link", "")
    found = []
    for link in sorted(links):
        above = parents.get(link)
        while above is not None and above not in links:
            above = parents.get(above)
        if above is not None:
            found.append(_key(link, above))
    return found


def srdf_file(robot: Robot) -> Path:
    """Return the SRDF of a robot: its own, else the one beside its description whose name is most like it.

    Raises
    ------
    TaskError
        There is none.
    """
    if robot.source is not None and robot.source.srdf is not None:
        return robot.source.srdf
    if robot.description is not None:
        stem = robot.description.stem
        known = sorted((robot.description.parent.parent / "srdf").glob("*.srdf"), key=lambda path: len(path.stem))
        shorter = [path for path in known if stem.startswith(path.stem)]
        longer = [path for path in known if path.stem.startswith(stem)]
        if shorter or longer:
            return shorter[-1] if shorter else longer[0]
    raise TaskError("collision.pairs", f"'srdf' given, but {robot.name} has none of its own; expected robot.srdf")


def _disabled(path: Path) -> list[Names]:
    """Return the pairs of links that an SRDF disables.

    Raises
    ------
    RobotError
        The file cannot be read.
    """
    root = read_document(path, "SRDF")
    return [_key(entry.get("link1", ""), entry.get("link2", "")) for entry in root.iter("disable_collisions")]
