"""Which joints of a description belong to the task, which stand still and where, and which follow others."""

from __future__ import annotations

import difflib
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from ocp_traj.exceptions import RobotError
from ocp_traj.robot.description.urdf_joints import MOVING, UNLIMITED, UrdfJoint
from ocp_traj.robot.description.urdf_tree import UrdfTree

Lock = Sequence[str] | Mapping[str, float] | Mapping[str, float | None]
"""Joints to be held at rest, or the positions where they are held (None: at rest)."""


@dataclass(frozen=True)
class Follower:
    """A joint that moves with a joint of the task: at ``multiplier * position + offset`` of `driver`."""

    driver: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Selection:
    """What becomes of every joint that can move.

    Attributes
    ----------
    free : frozenset of str
        Joints of the task.
    held : mapping
        Position of every joint that stands still, rad or m.
    followers : mapping
        Joints that move with one of the task.
    """

    free: frozenset[str]
    held: Mapping[str, float]
    followers: Mapping[str, Follower]


def select_joints(
    tree: UrdfTree, lock: Lock = (), keep: Collection[str] | None = None, group: Collection[str] | None = None
) -> Selection:
    """Return which joints of a URDF are free, held and following.

    Parameters
    ----------
    tree : UrdfTree
    lock : sequence of str, or mapping of str to float
        Joints held at rest (0; the middle of the range where that excludes 0), or at these positions.
    keep : collection of str, optional
        The joints of the task; all others are held.
    group : collection of str, optional
        Likewise, but fixed and following joints in it do not count.

    Raises
    ------
    RobotError
        A name is no joint that moves, is both kept and locked, a position is outside of the joint's range, or a
        joint to be kept follows another.
    """
    movable = [name for name, joint in tree.joints.items() if joint.moves]
    positions: dict[str, float | None] = dict(lock) if isinstance(lock, Mapping) else dict.fromkeys(lock)
    for name in (*positions, *(keep or ())):
        _check_name(tree, name, movable)
    both = sorted(set(positions) & set(keep or ()))
    if both:
        raise RobotError(f"joint {both[0]!r} is both kept and locked, expected one of them")
    for name in keep or ():
        mimic = tree.joints[name].mimic
        if mimic is not None and mimic.joint in tree.joints:
            raise RobotError(f"joint {name!r} cannot be kept, it follows {mimic.joint!r}: keep that one")
    chosen = keep if keep is not None else group if group is not None else movable
    free = {name for name in chosen if tree.joints[name].moves and tree.joints[name].mimic is None}
    free = (free | set(keep or ())) - set(positions)
    held = {name: _held_position(tree.joints[name], value) for name, value in positions.items()}
    followers: dict[str, Follower] = {}
    for name in movable:
        if name not in free and name not in held:
            _settle(tree, name, free, held, followers)
    for name in sorted(free):
        if tree.joints[name].kind not in MOVING:
            raise RobotError(
                f"joint {name!r}: type {tree.joints[name].kind} is not supported, expected {', '.join(MOVING)} joints; "
                "lock the others"
            )
    for name in sorted(held):
        if held[name] and tree.joints[name].kind in ("planar", "floating"):
            raise RobotError(f"joint {name!r} is {tree.joints[name].kind}, it can be locked at 0 only")
    return Selection(frozenset(free), {name: held[name] for name in movable if name in held}, followers)


def _settle(
    tree: UrdfTree, name: str, free: set[str], held: dict[str, float], followers: dict[str, Follower]
) -> None:
    """Hold a joint at rest, or let it follow the joint it mimics, which may follow another.

    Descriptions name joints to follow that are not there, in other files or with another prefix: such a joint is held.
    """
    passed: list[UrdfJoint] = []
    while name not in free and name not in held and name not in followers:
        joint = tree.joints[name]
        if joint.mimic is None or joint.mimic.joint not in tree.joints:
            held[name] = _held_position(joint, None)
            break
        passed.append(joint)
        name = joint.mimic.joint
    for joint in reversed(passed):
        mimic = joint.mimic
        assert mimic is not None  # only such were passed
        above = followers.get(mimic.joint)
        if mimic.joint in held:
            held[joint.name] = mimic.multiplier * held[mimic.joint] + mimic.offset
        elif above is not None:
            followers[joint.name] = Follower(
                above.driver,
                mimic.multiplier * above.multiplier,
                mimic.multiplier * above.offset + mimic.offset,
            )
        else:
            followers[joint.name] = Follower(mimic.joint, mimic.multiplier, mimic.offset)


def _check_name(tree: UrdfTree, name: str, movable: Sequence[str]) -> None:
    if name in movable:
        return
    close = difflib.get_close_matches(name, movable, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    problem = "does not move" if name in tree.joints else "does not exist"
    raise RobotError(f"joint {name!r} {problem} in {tree.name!r}, its joints are {', '.join(movable)}{hint}")


def _held_position(joint: UrdfJoint, given: float | None) -> float:
    lower, upper = joint.limits.get("position", UNLIMITED)
    if given is None:
        return 0.0 if lower <= 0.0 <= upper else _middle(lower, upper)
    within = lower <= given <= upper or joint.mimic is not None  # where a joint follows, it may leave its range
    if not (math.isfinite(given) and within):
        raise RobotError(
            f"joint {joint.name!r} is locked at {given:g}, expected a position in its range [{lower:g}, {upper:g}]"
        )
    return float(given)


def _middle(lower: float, upper: float) -> float:
    """Return the middle of a range, its finite end where it has one only."""
    if math.isinf(lower):
        return upper
    return lower if math.isinf(upper) else 0.5 * (lower + upper)
