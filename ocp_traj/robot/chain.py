"""A robot as its chain of joints and frames in plain numbers, so that it can travel without its description."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import RobotError
from ocp_traj.robot.additions import Coupling
from ocp_traj.robot.robot import Robot

LIMITS = ("position", "velocity", "torque", "acceleration", "jerk")
"""Limits of a joint that belong to the robot."""


@dataclass(frozen=True)
class ChainBody:
    """Mass, centre of mass and inertia of what a joint moves.

    Attributes
    ----------
    mass : float
        kg.
    com : (3,)
        In the axes of the joint, m.
    inertia : (6,)
        ixx, iyy, izz, ixy, ixz, iyz about the centre of mass, in the axes of the joint, kg m^2.
    """

    mass: float
    com: Array
    inertia: Array


@dataclass(frozen=True)
class ChainJoint:
    """One joint and the body it moves.

    Attributes
    ----------
    name : str
    kind : str
        ``"revolute"``, ``"continuous"`` or ``"prismatic"``.
    parent : int
        Number of the joint it hangs on, from 1; 0 for the root.
    axis : (3,)
        In the joint's own axes.
    placement : (4, 4)
        Of the joint at rest in its parent, m.
    body : ChainBody
    armature : float
        kg m^2 or kg.
    limits : mapping of str to (2,)
        Lower and upper limit of each of `LIMITS`, in SI; infinite where there is none.
    follows : (str, float, float) or None
        The joint that this one follows, its multiplier and its offset; such a joint has no limits of its own.
    """

    name: str
    kind: str
    parent: int
    axis: Array
    placement: Array
    body: ChainBody
    armature: float
    limits: Mapping[str, Array]
    follows: tuple[str, float, float] | None = None


@dataclass(frozen=True)
class ChainFrame:
    """A named frame: the joint (from 1, 0 for the root) that carries it, and its placement (4, 4) there."""

    name: str
    joint: int
    placement: Array


@dataclass(frozen=True)
class Chain:
    """A robot without payload, friction and gravity of its own.

    Attributes
    ----------
    name : str
    root : ChainBody
        What does not move.
    joints : tuple of ChainJoint
        Parents first.
    frames : tuple of ChainFrame
        Of different names.
    """

    name: str
    root: ChainBody
    joints: tuple[ChainJoint, ...]
    frames: tuple[ChainFrame, ...]


def chain_of(robot: Robot) -> Chain:
    """Return the chain of a robot; `robot_from_chain` makes the same arm of it, with the same digest."""
    from ocp_traj.robot.links import joint_kind
    from ocp_traj.robot.model import frame_index

    model, followers = robot.bare_model, robot.followers
    joints = []
    for index in range(1, model.njoints):
        name = model.names[index]
        kind, axis = joint_kind(model.joints[index])
        limits = dict.fromkeys(LIMITS, np.array([-np.inf, np.inf]))
        if name in robot.joint_names:
            own = robot.joint_names.index(name)
            kind = robot.joint_types[own]
            limits = {limit: getattr(robot, f"{limit}_limits")[:, own] for limit in LIMITS}
        joints.append(
            ChainJoint(
                name,
                kind,
                int(model.parents[index]),
                np.array(axis),
                np.array(model.jointPlacements[index].homogeneous),
                _body(model.inertias[index]),
                float(model.armature[index - 1]),
                limits,
                followers.get(name),
            )
        )
    frames = []
    root = model.frames[0].name  # every model has this frame
    for name in dict.fromkeys(frame.name for frame in model.frames if frame.name != root):
        frame = model.frames[frame_index(model, name)]
        frames.append(ChainFrame(name, int(frame.parentJoint), np.array(frame.placement.homogeneous)))
    return Chain(robot.name, _body(model.inertias[0]), tuple(joints), tuple(frames))


def _body(inertia: Any) -> ChainBody:
    tensor = np.array(inertia.inertia)
    return ChainBody(
        float(inertia.mass), np.array(inertia.lever), tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    )


def robot_from_chain(chain: Chain, tool: str, base: str) -> Robot:
    """Return the robot of a chain, with nothing at its tool and standard gravity.

    Parameters
    ----------
    chain : Chain
    tool, base : str
        Names of frames of the chain.

    Raises
    ------
    RobotError
        There is no joint, a joint or frame hangs on one that does not come before it, or a frame does not exist.
    """
    import pinocchio as pin

    from ocp_traj.robot.model import plain_joint

    if all(joint.follows is not None for joint in chain.joints):
        raise RobotError("a chain needs at least one joint")
    model = pin.Model()
    model.name = chain.name
    model.inertias[0] = _inertia(chain.root)
    for number, joint in enumerate(chain.joints, start=1):
        if not 0 <= joint.parent < number:
            raise RobotError(f"joint {joint.name!r} hangs on joint {joint.parent}, expected one before it")
        axis = (float(joint.axis[0]), float(joint.axis[1]), float(joint.axis[2]))
        placement = pin.SE3(joint.placement)
        model.addJoint(joint.parent, plain_joint(joint.kind, axis), placement, joint.name)
        model.inertias[number] = _inertia(joint.body)
    model.armature = np.array([joint.armature for joint in chain.joints])
    for frame in chain.frames:
        if not 0 <= frame.joint <= len(chain.joints):
            raise RobotError(f"frame {frame.name!r} is carried by joint {frame.joint}, which does not exist")
        kind = pin.FrameType.BODY
        model.addFrame(pin.Frame(frame.name, frame.joint, 0, pin.SE3(frame.placement), kind), False)
    leading = [joint for joint in chain.joints if joint.follows is None]
    names = tuple(joint.name for joint in leading)
    rules = {joint.name: joint.follows for joint in chain.joints if joint.follows is not None}
    limits = {name: np.stack([joint.limits[name] for joint in leading], axis=1) for name in LIMITS}
    return Robot(
        name=chain.name,
        joint_names=names,
        joint_types=tuple(joint.kind for joint in leading),
        position_limits=limits["position"],
        velocity_limits=limits["velocity"],
        torque_limits=limits["torque"],
        acceleration_limits=limits["acceleration"],
        jerk_limits=limits["jerk"],
        bare_model=model,
        tool=tool,
        base=base,
        coupling=Coupling.of([joint.name for joint in chain.joints], names, rules) if rules else None,
    )


def _inertia(body: ChainBody) -> Any:
    import pinocchio as pin

    ixx, iyy, izz, ixy, ixz, iyz = body.inertia
    tensor = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    return pin.Inertia(body.mass, np.array(body.com), tensor)
