"""Groups of joints by name, from an SRDF (MoveIt's semantic robot description)."""

from __future__ import annotations

import difflib
from pathlib import Path
from xml.etree.ElementTree import Element

from ocp_traj.exceptions import RobotError
from ocp_traj.robot.description.document import read_document
from ocp_traj.robot.description.urdf_tree import UrdfTree


def srdf_beside(urdf: Path) -> Path | None:
    """Return the SRDF that belongs to a URDF: beside it or in ``../srdf``, of its name or the longest beginning of it.

    In ``../srdf`` it may have another name where it is the only one.
    """
    own = urdf.with_suffix(".srdf")
    if own.is_file():
        return own
    others = sorted((urdf.parent.parent / "srdf").glob("*.srdf"), key=lambda path: len(path.stem))
    alike = [path for path in others if urdf.stem.startswith(path.stem)]
    if alike:
        return alike[-1]
    return others[0] if len(others) == 1 else None


def group_joints(tree: UrdfTree, srdf: Path, group: str) -> list[str]:
    """Return the names of the joints of a group, fixed ones too.

    A group is made of joints, links (the joint above each), chains from a base link to a tip link, and other groups.

    Parameters
    ----------
    tree : UrdfTree
    srdf : pathlib.Path
    group : str

    Raises
    ------
    RobotError
        The file cannot be read, there is no such group, or the group names what the robot has not.
    """
    groups = {element.get("name", ""): element for element in read_document(srdf, "SRDF").findall("group")}
    try:
        return list(dict.fromkeys(_joints_of(tree, groups, group, ())))
    except RobotError as error:
        raise RobotError(f"robot description {srdf}: {error}") from None


def _joints_of(tree: UrdfTree, groups: dict[str, Element], group: str, within: tuple[str, ...]) -> list[str]:
    if group not in groups:
        close = difflib.get_close_matches(group, groups, n=1)
        hint = f"; did you mean {close[0]!r}?" if close else ""
        raise RobotError(f"group {group!r} does not exist, its groups are {', '.join(groups) or 'none'}{hint}")
    if group in within:
        raise RobotError(f"the groups {', '.join(map(repr, within))} hold each other in a circle")
    names: list[str] = []
    for part in groups[group]:
        if part.tag == "joint":
            names.append(_known(tree, part.get("name", ""), group))
        elif part.tag == "link":
            names += _above(tree, part.get("name", ""), group)
        elif part.tag == "chain":
            names += _chain(tree, part.get("base_link", ""), part.get("tip_link", ""), group)
        elif part.tag == "group":
            names += _joints_of(tree, groups, part.get("name", ""), (*within, group))
    return names


def _known(tree: UrdfTree, joint: str, group: str) -> str:
    if joint not in tree.joints:
        raise RobotError(f"group {group!r} names the joint {joint!r}, which {tree.path.name} has not")
    return joint


def _above(tree: UrdfTree, link: str, group: str) -> list[str]:
    """Return the name of the joint above a link, none for the root."""
    if link in tree.above:
        return [tree.above[link].name]
    if all(joint.parent != link for joint in tree.joints.values()):
        raise RobotError(f"group {group!r} names the link {link!r}, which {tree.path.name} has not")
    return []


def _chain(tree: UrdfTree, base: str, tip: str, group: str) -> list[str]:
    names: list[str] = []
    link = tip
    while link != base:
        if link not in tree.above:
            raise RobotError(f"group {group!r} has a chain from {base!r} to {tip!r}, which {tree.path.name} has not")
        names.append(tree.above[link].name)
        link = tree.above[link].parent
    return names[::-1]
