"""A pin.Model of one-degree-of-freedom joints as plain numbers, every joint axis turned onto its link's z."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import RobotError

_AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
# Columns are the new x, y, z axes: cyclic permutations keep placements of right angles free of rounding.
_ALIGNMENTS = {
    (1.0, 0.0, 0.0): np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    (0.0, 1.0, 0.0): np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
    (0.0, 0.0, 1.0): np.eye(3),
    (-1.0, 0.0, 0.0): np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]),
    (0.0, -1.0, 0.0): np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]),
    (0.0, 0.0, -1.0): np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]),
}


@dataclass(frozen=True)
class Link:
    """One joint and the body it moves, in link axes whose z is the joint axis.

    Attributes
    ----------
    parent : int
        Index of the parent link, -1 for the root.
    prismatic : bool
        The joint slides along z; otherwise it turns about z.
    rotation : (3, 3)
        Axes of the link at q = 0 in those of its parent.
    translation : (3,)
        Origin of the link at q = 0 in its parent, m.
    alignment : (3, 3)
        Link axes in the axes of Pinocchio's joint frame; both share their origin.
    mass : float
        kg.
    first_moment : (3,)
        Mass times centre of mass, kg m.
    second_moment : (3, 3)
        Integral of r r^T dm about the link's origin, kg m^2: half the trace of the inertia minus the inertia.
    armature : float
        Inertia of rotor and gear seen at the joint, kg m^2 or kg.
    """

    parent: int
    prismatic: bool
    rotation: Array
    translation: Array
    alignment: Array
    mass: float
    first_moment: Array
    second_moment: Array
    armature: float


def joint_kind(joint: Any) -> tuple[str, tuple[float, float, float]]:
    """Return the type ("revolute", "continuous" or "prismatic") and the axis of a Pinocchio joint.

    Raises
    ------
    RobotError
        The joint has more than one degree of freedom or is of an unsupported type.
    """
    short = joint.shortname().replace("JointModel", "")
    families = {"R": "revolute", "P": "prismatic", "RUB": "continuous"}
    for prefix, kind in families.items():
        if short[: len(prefix)] == prefix and short[len(prefix) :] in _AXES:
            return kind, _AXES[short[len(prefix) :]]
    unaligned = {
        "RevoluteUnaligned": "revolute",
        "RevoluteUnboundedUnaligned": "continuous",
        "PrismaticUnaligned": "prismatic",
    }
    if short not in unaligned:
        raise RobotError(
            f"joint type {short} is not supported, expected revolute, continuous or prismatic joints; "
            "lock the others"
        )
    x, y, z = (float(value) for value in joint.extract().axis)
    return unaligned[short], (x, y, z)


def _alignment(axis: tuple[float, float, float]) -> Array:
    """Return a rotation whose third column is `axis`."""
    known = _ALIGNMENTS.get(axis)
    if known is not None:
        return known
    z = np.array(axis) / np.linalg.norm(axis)
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def links_of(model: Any) -> tuple[Link, ...]:
    """Return the links of a `pin.Model` of one-degree-of-freedom joints, parents first."""
    links: list[Link] = []
    for index in range(1, model.njoints):
        kind, axis = joint_kind(model.joints[index])
        alignment = _alignment(axis)
        parent = int(model.parents[index]) - 1
        parent_alignment = links[parent].alignment if parent >= 0 else np.eye(3)
        placement = model.jointPlacements[index]
        inertia = model.inertias[index]
        lever = np.array(inertia.lever)
        tensor = np.array(inertia.inertia)
        about_com = 0.5 * np.trace(tensor) * np.eye(3) - tensor
        second = about_com + inertia.mass * np.outer(lever, lever)
        links.append(
            Link(
                parent=parent,
                prismatic=kind == "prismatic",
                rotation=parent_alignment.T @ placement.rotation @ alignment,
                translation=parent_alignment.T @ placement.translation,
                alignment=alignment,
                mass=float(inertia.mass),
                first_moment=inertia.mass * (alignment.T @ lever),
                second_moment=alignment.T @ second @ alignment,
                armature=float(model.armature[index - 1]),
            )
        )
    return tuple(links)
