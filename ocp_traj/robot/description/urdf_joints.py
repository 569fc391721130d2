"""The joints of a URDF: checked, with the limits that the file gives and those that it does not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from ocp_traj.exceptions import RobotError
from ocp_traj.robot.description.numbers import number, numbers

MOVING = ("revolute", "continuous", "prismatic")
"""Joint types of one degree of freedom."""

WITH_AXIS = (*MOVING, "planar")
"""Joint types whose axis has a meaning."""

TYPES = (*MOVING, "fixed", "planar", "floating")
"""Joint types of URDF."""

_SMALLEST_AXIS = 1e-6
"""Norm below which an axis has no direction."""

_SYMMETRIC = {"velocity": "velocity", "acceleration": "acceleration", "jerk": "jerk", "effort": "torque"}
"""Attributes of ``limit`` that bound both directions alike, and our words for them."""

Interval = tuple[float, float]
UNLIMITED: Interval = (-math.inf, math.inf)


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: its position is ``multiplier * position of joint + offset``."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class UrdfJoint:
    """One joint of a URDF.

    Attributes
    ----------
    name, kind : str
        `kind` is one of `TYPES`.
    parent, child : str
        Names of links.
    limits : mapping
        Lower and upper limit by quantity ("position", "velocity", "acceleration", "jerk", "torque"), SI; only those
        that the file gives: 0, and lower = upper = 0, mean that it does not.
    mimic : Mimic or None
    damping, dry_friction : float
        Of the tag ``dynamics``: N m s/rad and N m (N s/m and N for prismatic joints).
    """

    name: str
    kind: str
    parent: str
    child: str
    limits: Mapping[str, Interval]
    mimic: Mimic | None = None
    damping: float = 0.0
    dry_friction: float = 0.0

    @property
    def moves(self) -> bool:
        """Whether the joint has a degree of freedom."""
        return self.kind != "fixed"


def urdf_joint(element: Element) -> UrdfJoint:
    """Return a joint of a URDF, checked by itself.

    Raises
    ------
    RobotError
        A name, a tag or an attribute is missing, a number is none, the axis has no direction, or the lower limit is
        above the upper; names the joint.
    """
    name = element.get("name", "")
    if not name:
        raise RobotError("a <joint> has no name")
    where = f"joint {name!r}"
    kind = element.get("type", "")
    if kind not in TYPES:
        raise RobotError(f"{where} has the type {kind!r}, expected one of {', '.join(TYPES)}")
    parent, child = (_link_of(element, tag, where) for tag in ("parent", "child"))
    origin = element.find("origin")
    if origin is not None:
        for attribute in ("xyz", "rpy"):
            numbers(origin, attribute, 3, where)
    tag = element.find("dynamics")
    damping, friction = (
        0.0 if tag is None else number(tag, key, 0.0, where) for key in ("damping", "friction")
    )
    axis = element.find("axis")
    if axis is not None and kind in WITH_AXIS:
        given = numbers(axis, "xyz", 3, where)
        if given is None or math.hypot(*given) < _SMALLEST_AXIS:
            raise RobotError(f"{where} has the axis {axis.get('xyz')!r}, expected a direction")
    if kind not in MOVING:
        return UrdfJoint(name, kind, parent, child, {})
    limits = _limits(element, kind, where)
    return UrdfJoint(name, kind, parent, child, limits, _mimic(element, where), damping, friction)


def _link_of(element: Element, tag: str, where: str) -> str:
    end = element.find(tag)
    link = "" if end is None else end.get("link", "")
    if not link:
        raise RobotError(f'{where} has no <{tag} link="...">')
    return link


def _limits(element: Element, kind: str, where: str) -> dict[str, Interval]:
    tag = element.find("limit")
    if tag is None:
        return {}
    limits: dict[str, Interval] = {}
    if kind != "continuous":
        lower, upper = (number(tag, side, 0.0, where, finite=False) for side in ("lower", "upper"))
        if lower > upper:
            raise RobotError(f"{where} has the lower limit {lower:g} above its upper limit {upper:g}")
        if (lower, upper) not in ((0.0, 0.0), UNLIMITED):
            limits["position"] = (lower, upper)
    for attribute, quantity in _SYMMETRIC.items():
        value = number(tag, attribute, 0.0, where, finite=False)
        if attribute == "acceleration":
            braking = number(tag, "deceleration", 0.0, where, finite=False)
            value = min(value, braking) if value > 0.0 and braking > 0.0 else value
        if 0.0 < value < math.inf:
            limits[quantity] = (-value, value)
    return limits


def _mimic(element: Element, where: str) -> Mimic | None:
    tag = element.find("mimic")
    if tag is None:
        return None
    joint = tag.get("joint", "")
    if not joint:
        raise RobotError(f'{where} has <mimic> without joint="..."')
    return Mimic(joint, number(tag, "multiplier", 1.0, where), number(tag, "offset", 0.0, where))
