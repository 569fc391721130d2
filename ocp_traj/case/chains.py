"""A robot's chain as the table ``robot.chain`` of a task that travels with a result, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.case.section import Section

if TYPE_CHECKING:
    from ocp_traj.robot import Robot
    from ocp_traj.robot.chain import Chain, ChainBody

KINDS = ("revolute", "continuous", "prismatic")
"""Types of joints."""

LIMITS = ("position", "velocity", "torque", "acceleration", "jerk")
"""Limits of a joint."""

_MAX_PARENT = 10_000


def chain_table(robot: Robot) -> dict[str, Any]:
    """Return the chain of a robot as plain values: lists, texts, numbers (infinite limits are infinite)."""
    from ocp_traj.robot.chain import chain_of

    chain = chain_of(robot)
    joints = [
        {
            "name": joint.name,
            "type": joint.kind,
            "parent": joint.parent,
            "axis": joint.axis.tolist(),
            **_placed(joint.placement),
            **_body_table(joint.body),
            "armature": joint.armature,
            **({} if joint.follows is None else {"follows": _rule_table(*joint.follows)}),
            **{name: joint.limits[name].tolist() for name in LIMITS},
        }
        for joint in chain.joints
    ]
    frames = [
        {"name": frame.name, "joint": frame.joint, **_placed(frame.placement)} for frame in chain.frames
    ]
    root = _body_table(chain.root)
    return {
        "name": chain.name,
        "root": root,
        "joints": joints,
        "frames": frames,
        "tool": robot.tool,
        "base": robot.base,
    }


def _rule_table(joint: str, multiplier: float, offset: float) -> dict[str, Any]:
    return {"joint": joint, "multiplier": multiplier, "offset": offset}


def _placed(placement: Array) -> dict[str, Any]:
    return {"rotation": placement[:3, :3].tolist(), "translation": placement[:3, 3].tolist()}


def _body_table(body: ChainBody) -> dict[str, Any]:
    return {"mass": body.mass, "com": body.com.tolist(), "inertia": body.inertia.tolist()}


def robot_of_chain(section: Section) -> Robot:
    """Return the robot of the table that `chain_table` makes.

    Raises
    ------
    CaseError
        A key is unknown or missing, a number or shape is wrong.
    RobotError
        Joints, frames or limits do not fit together.
    """
    from ocp_traj.robot.chain import robot_from_chain

    section.check_keys(("name", "root", "joints", "frames", "tool", "base"))
    return robot_from_chain(_read_chain(section), section.text("tool"), section.text("base"))


def _read_chain(section: Section) -> Chain:
    from ocp_traj.robot.chain import Chain, ChainFrame, ChainJoint

    body_keys = ("mass", "com", "inertia")
    placed_keys = ("rotation", "translation")
    section.section("root").check_keys(body_keys)
    joints, frames = [], []
    for joint in section.sections("joints"):
        joint.check_keys(
            ("name", "type", "parent", "axis", "armature", "follows", *LIMITS, *body_keys, *placed_keys)
        )
        joints.append(
            ChainJoint(
                joint.text("name"),
                joint.choice("type", KINDS),
                joint.integer("parent", None, _MAX_PARENT),
                joint.array_of_shape("axis", (3,)),
                _read_placement(joint),
                _read_body(joint),
                joint.number("armature"),
                {name: joint.array_of_shape(name, (2,), finite=False) for name in LIMITS},
                _read_rule(joint.section("follows")) if "follows" in joint else None,
            )
        )
    for frame in section.sections("frames"):
        frame.check_keys(("name", "joint", *placed_keys))
        number = frame.integer("joint", None, _MAX_PARENT)
        frames.append(ChainFrame(frame.text("name"), number, _read_placement(frame)))
    return Chain(section.text("name"), _read_body(section.section("root")), tuple(joints), tuple(frames))


def _read_rule(table: Section) -> tuple[str, float, float]:
    table.check_keys(("joint", "multiplier", "offset"))
    return table.text("joint"), table.number("multiplier"), table.number("offset")


def _read_placement(table: Section) -> Array:
    placement = np.eye(4)
    placement[:3, :3] = table.array_of_shape("rotation", (3, 3))
    placement[:3, 3] = table.array_of_shape("translation", (3,))
    if np.abs(placement[:3, :3] @ placement[:3, :3].T - np.eye(3)).max() > 1e-6:
        raise table.error("rotation", "is no rotation, expected three rows of unit length at right angles")
    return placement


def _read_body(table: Section) -> ChainBody:
    from ocp_traj.robot.chain import ChainBody

    mass = table.number("mass")
    if mass < 0:
        raise table.error("mass", f"{mass:g} kg given, expected 0 or more")
    return ChainBody(mass, table.array_of_shape("com", (3,)), table.array_of_shape("inertia", (6,)))
