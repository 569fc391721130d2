"""Work on pin.Model: plain one-degree-of-freedom joints, locking, adding a payload."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from ocp_traj.arrays import Array
from ocp_traj.exceptions import RobotError
from ocp_traj.robot.additions import Coupling, Payload
from ocp_traj.robot.description.selection import Selection
from ocp_traj.robot.links import joint_kind


def frame_index(model: Any, name: str) -> int:
    """Return the index of a named frame, bodies before joints of the same name.

    Raises
    ------
    RobotError
        There is no such frame; the message lists the bodies.
    """
    matches = [index for index, frame in enumerate(model.frames) if frame.name == name]
    if not matches:
        bodies = ", ".join(frame.name for frame in model.frames if frame.type == pin.FrameType.BODY)
        raise RobotError(f"frame {name!r} does not exist in robot {model.name!r}, its bodies are {bodies}")
    return next((i for i in matches if model.frames[i].type == pin.FrameType.BODY), matches[0])


def root_placement(model: Any, base: str) -> Array:
    """Return the placement (4, 4) of the base frame in the model's root.

    Raises
    ------
    RobotError
        The frame does not exist, or a joint moves it.
    """
    frame = model.frames[frame_index(model, base)]
    if frame.parentJoint != 0:
        raise RobotError(f"base frame {base!r} is moved by joint {model.names[frame.parentJoint]!r}")
    return np.array(frame.placement.homogeneous)


def plain_joint(kind: str, axis: tuple[float, float, float]) -> Any:
    """Return a joint model with nq = nv = 1."""
    letters = {(1.0, 0.0, 0.0): "X", (0.0, 1.0, 0.0): "Y", (0.0, 0.0, 1.0): "Z"}
    letter = letters.get(axis)
    if kind == "prismatic":
        if letter is None:
            return pin.JointModelPrismaticUnaligned(np.array(axis))
        return getattr(pin, f"JointModelP{letter}")()
    if letter is None:
        return pin.JointModelRevoluteUnaligned(np.array(axis))
    return getattr(pin, f"JointModelR{letter}")()


def plain_model(original: Any, selection: Selection) -> Any:
    """Rebuild a model so that nq = nv and the joints that a selection holds are part of their links."""
    data = original.createData()
    pin.forwardKinematics(original, data, _held_configuration(original, selection.held))
    plain = pin.Model()
    plain.name = original.name
    plain.gravity = original.gravity
    plain.inertias[0] = original.inertias[0]
    carriers: list[tuple[int, Any]] = [(0, pin.SE3.Identity())]
    kept: list[int] = []
    for index in range(1, original.njoints):
        carrier, placement = carriers[original.parents[index]]
        name = original.names[index]
        if name in selection.held:
            placement = placement * data.liMi[index]
            plain.inertias[carrier] = plain.inertias[carrier] + placement.act(original.inertias[index])
            carriers.append((carrier, placement))
            continue
        kind, axis = joint_kind(original.joints[index])
        placement = placement * original.jointPlacements[index]
        number = plain.addJoint(carrier, plain_joint(kind, axis), placement, name)
        plain.inertias[number] = original.inertias[index]
        carriers.append((number, pin.SE3.Identity()))
        kept.append(int(original.idx_vs[index]))
    plain.armature = np.array(original.armature)[kept]
    plain.damping = np.array(original.damping)[kept]
    for frame in list(original.frames)[1:]:
        carrier, placement = carriers[frame.parentJoint]
        moved = pin.Frame(frame.name, carrier, frame.parentFrame, placement * frame.placement, frame.type)
        plain.addFrame(moved, False)
    return plain


def _held_configuration(model: Any, held: Mapping[str, float]) -> Array:
    """Return the configuration in which held joints are, all others at zero."""
    q: Array = pin.neutral(model)
    for index in range(1, model.njoints):
        if model.nqs[index] == 1:
            q[int(model.idx_qs[index])] = held.get(model.names[index], 0.0)
    return q


def completed_model(bare: Any, payload: Payload | None, tool: str, base: str, gravity: Array) -> Any:
    """Return a copy of the bare model with payload at the tool and gravity as given in the base frame."""
    model = bare.copy()
    model.gravity = pin.Motion(root_placement(bare, base)[:3, :3] @ gravity, np.zeros(3))
    if payload is not None and payload.mass > 0.0:
        frame = model.frames[frame_index(model, tool)]
        inertia = pin.Inertia(payload.mass, np.array(payload.com), payload.tensor)
        joint = frame.parentJoint
        model.inertias[joint] = model.inertias[joint] + frame.placement.act(inertia)
    return model


def moves_mass(model: Any, coupling: Coupling | None = None) -> npt.NDArray[np.bool_]:
    """Return for every joint (n,) whether it, or one of those that follow it, moves some mass or has an armature."""
    moved = np.array([inertia.mass for inertia in model.inertias])
    for index in reversed(range(1, model.njoints)):
        moved[model.parents[index]] += moved[index]
    heavy = (moved[1:] > 0.0) | (np.array(model.armature) > 0.0)
    if coupling is not None:
        heavy = np.any(heavy[:, None] & (coupling.matrix != 0.0), axis=0)
    return heavy
