"""A URDF as a tree of links: checked, and reduced to what dynamics need before Pinocchio reads it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from ocp_traj.exceptions import RobotError
from ocp_traj.robot.description.document import read_document
from ocp_traj.robot.description.numbers import number, numbers
from ocp_traj.robot.description.urdf_joints import WITH_AXIS, UrdfJoint, urdf_joint

MAX_JOINTS = 200
"""Joints up to which a description is read: Pinocchio's working memory grows with their cube, 0.5 GB here."""

MAX_DEPTH = 300
"""Links from the root to a tip, fixed ones too: Pinocchio's reader calls itself once a link, and its stack ends."""

_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


@dataclass(frozen=True)
class UrdfTree:
    """The links and joints of a URDF.

    Attributes
    ----------
    path : pathlib.Path
    name : str
        The robot's.
    joints : mapping
        Every joint by name, in the order of the file.
    document : Element
        The root as read.
    """

    path: Path
    name: str
    joints: Mapping[str, UrdfJoint]
    document: Element

    @cached_property
    def above(self) -> dict[str, UrdfJoint]:
        """The joint above every link but the root, by the link's name."""
        return {joint.child: joint for joint in self.joints.values()}

    def reduced(self) -> str:
        """Return the text of a URDF that has inertias, joints and friction only, all angles as plain numbers.

        A continuous joint stands there as a revolute one: its axis is lost in Pinocchio's own continuous joint.
        """
        root = Element("robot", {"name": self.name})
        for link in self.document.findall("link"):
            copy = SubElement(root, "link", {"name": link.attrib["name"]})
            inertial = link.find("inertial")
            if inertial is not None:
                copy.append(_only(inertial, ("origin", "mass", "inertia")))
        for joint in self.document.findall("joint"):
            axis = ("axis",) if joint.get("type") in WITH_AXIS else ()
            copy = _only(joint, ("origin", "parent", "child", "dynamics", *axis))
            if copy.attrib["type"] == "continuous":
                copy.attrib["type"] = "revolute"
            SubElement(copy, "limit", dict.fromkeys(("lower", "upper", "effort", "velocity"), "0"))
            root.append(copy)
        return ElementTree.tostring(root, encoding="unicode")


def _only(element: Element, tags: tuple[str, ...]) -> Element:
    """Return a copy of an element with the first child of each of these tags, and nothing below."""
    copy = Element(element.tag, dict(element.attrib))
    for child in (element.find(tag) for tag in tags):
        if child is not None:
            SubElement(copy, child.tag, dict(child.attrib))
    return copy


def read_urdf_tree(path: Path) -> UrdfTree:
    """Return the checked tree of a URDF file.

    Raises
    ------
    RobotError
        The file cannot be read, or something in it cannot be: a missing tag, a number that is none, a name that is
        there twice, links that form no tree, more joints or deeper chains than are read.
    """
    root = read_document(path)
    try:
        return _checked(path, root)
    except RobotError as error:
        raise RobotError(f"robot description {path}: {error}") from None


def _checked(path: Path, root: Element) -> UrdfTree:
    links = [link.get("name", "") for link in root.findall("link")]
    if not links:
        raise RobotError("has no links, expected an arm")
    if "" in links:
        raise RobotError("a <link> has no name")
    _refuse_twice("link", links)
    for link in root.findall("link"):
        _check_inertial(link)
    found = [urdf_joint(joint) for joint in root.findall("joint")]
    _refuse_twice("joint", [joint.name for joint in found])
    moving = sum(joint.moves for joint in found)
    if moving > MAX_JOINTS:
        raise RobotError(f"has {moving} joints, expected at most {MAX_JOINTS}")
    _check_tree(links, found)
    joints = {joint.name: joint for joint in found}
    for joint in found:
        _check_mimic(joints, joint)
    return UrdfTree(path, root.get("name", "") or path.stem, joints, root)


def _refuse_twice(what: str, names: list[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise RobotError(f"{what} {name!r} is there twice")
        seen.add(name)


def _check_inertial(link: Element) -> None:
    """Refuse a mass or inertia that is no finite number: Pinocchio's parser would leave it out and go on."""
    inertial = link.find("inertial")
    if inertial is None:
        return
    where = f"link {link.get('name')!r}"
    for tag, attributes in (("mass", ("value",)), ("inertia", _MOMENTS)):
        element = inertial.find(tag)
        if element is None:
            raise RobotError(f"{where}: <inertial> has no <{tag}>")
        for attribute in attributes:
            number(element, attribute, None, where)
    origin = inertial.find("origin")
    if origin is not None:
        for attribute in ("xyz", "rpy"):
            numbers(origin, attribute, 3, where)


def _check_tree(links: list[str], joints: list[UrdfJoint]) -> None:
    above: dict[str, UrdfJoint] = {}
    known = set(links)
    for joint in joints:
        for link in (joint.parent, joint.child):
            if link not in known:
                raise RobotError(f"joint {joint.name!r} names the link {link!r}, which does not exist")
        if joint.child in above:
            raise RobotError(
                f"link {joint.child!r} hangs on two joints, {above[joint.child].name!r} and {joint.name!r}: "
                "closed chains are not supported"
            )
        above[joint.child] = joint
    roots = [link for link in links if link not in above]
    if len(roots) > 1:
        raise RobotError(f"links {', '.join(map(repr, roots[:4]))} hang on no joint, expected one root")
    depth: dict[str, int] = dict.fromkeys(roots, 1)
    for link in links:
        chain: list[str] = []
        while link not in depth:
            if len(chain) > len(links):
                raise RobotError(f"the joints above link {link!r} form a circle, expected a tree")
            chain.append(link)
            link = above[link].parent
        depth.update((below, depth[link] + place) for place, below in enumerate(reversed(chain), start=1))
    if max(depth.values()) > MAX_DEPTH:
        raise RobotError(f"has a chain of {max(depth.values())} links, expected at most {MAX_DEPTH}")


def _check_mimic(joints: Mapping[str, UrdfJoint], joint: UrdfJoint) -> None:
    passed = [joint.name]
    while joint.mimic is not None:
        name = joint.mimic.joint
        if name not in joints:
            return
        if name in passed:
            raise RobotError(f"the joints {', '.join(map(repr, passed))} mimic each other in a circle")
        passed.append(name)
        joint = joints[name]
