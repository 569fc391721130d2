"""Work on pin.Model: plain one-degree-of-freedom joints, locking, adding a payload."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from ocp_traj.arrays import Array
from ocp_traj.exceptions import RobotError
from ocp_traj.robot.additions import Payload
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


def locked_joints(model: Any, lock: Sequence[str], keep: Sequence[str] | None) -> list[int]:
    """Return the indices of the joints to be locked: those in `lock`, or all that are not in `keep`.

    Raises
    ------
    RobotError
        A name is no joint of the model.
    """
    names = list(model.names)[1:]
    for name in [*lock, *(keep or ())]:
        if name not in names:
            raise RobotError(
                f"joint {name!r} does not exist in {model.name!r}, its joints are {', '.join(names)}"
            )
    chosen = set(lock) if keep is None else set(lock) | (set(names) - set(keep))
    return [index for index in range(1, model.njoints) if model.names[index] in chosen]


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


def _chosen_limits(model: Any, joint: int, kind: str) -> tuple[float, float, float, float]:
    """Return effort, velocity, lower and upper position limit of a joint; infinite where the model has none.

    URDF writes an absent effort or velocity as zero, and an absent range as lower = upper.
    """
    index_v, index_q = int(model.idx_vs[joint]), int(model.idx_qs[joint])
    effort, velocity = float(model.effortLimit[index_v]), float(model.velocityLimit[index_v])
    lower, upper = -np.inf, np.inf
    if kind != "continuous":
        lower = float(model.lowerPositionLimit[index_q])
        upper = float(model.upperPositionLimit[index_q])
    if not lower < upper:
        lower, upper = -np.inf, np.inf

    def absent(value: float) -> bool:
        return value <= 0.0 or value > 1e100

    return (
        np.inf if absent(effort) else effort,
        np.inf if absent(velocity) else velocity,
        -np.inf if lower < -1e100 else lower,
        np.inf if upper > 1e100 else upper,
    )


@dataclass(frozen=True)
class PlainModel:
    """A model in which every joint has nq = nv = 1, and where the joints of its original went.

    Attributes
    ----------
    model : pin.Model
    joint_types : tuple of n str
    carriers : tuple of (int, pin.SE3)
        For every joint of the original (0: the root) the joint that now carries its frame, and where there.
    """

    model: Any
    joint_types: tuple[str, ...]
    carriers: tuple[tuple[int, Any], ...]


def plain_model(original: Any, locked: Sequence[int] = ()) -> PlainModel:
    """Rebuild a model so that nq = nv = n and the joints numbered in `locked` stand still.

    Continuous joints, which Pinocchio keeps as (cos q, sin q), become plain revolute ones without a range.
    Locked joints stand at zero, or at the middle of their range where that excludes zero.

    Raises
    ------
    RobotError
        A joint that is not locked has more than one degree of freedom.
    """
    data = original.createData()
    pin.forwardKinematics(original, data, _resting_configuration(original))
    plain = pin.Model()
    plain.name = original.name
    plain.gravity = original.gravity
    plain.inertias[0] = original.inertias[0]
    carriers: list[tuple[int, Any]] = [(0, pin.SE3.Identity())]
    kinds: list[str] = []
    kept: list[int] = []
    for index in range(1, original.njoints):
        carrier, placement = carriers[original.parents[index]]
        if index in locked:
            placement = placement * data.liMi[index]
            plain.inertias[carrier] = plain.inertias[carrier] + placement.act(original.inertias[index])
            carriers.append((carrier, placement))
            continue
        kind, axis = joint_kind(original.joints[index])
        limits = [np.array([value]) for value in _chosen_limits(original, index, kind)]
        placement = placement * original.jointPlacements[index]
        number = plain.addJoint(carrier, plain_joint(kind, axis), placement, original.names[index], *limits)
        plain.inertias[number] = original.inertias[index]
        carriers.append((number, pin.SE3.Identity()))
        kinds.append(kind)
        kept.append(int(original.idx_vs[index]))
    plain.armature = np.array(original.armature)[kept]
    plain.damping = np.array(original.damping)[kept]
    for frame in list(original.frames)[1:]:
        carrier, placement = carriers[frame.parentJoint]
        moved = pin.Frame(frame.name, carrier, frame.parentFrame, placement * frame.placement, frame.type)
        plain.addFrame(moved, False)
    return PlainModel(plain, tuple(kinds), tuple(carriers))


def _resting_configuration(model: Any) -> Array:
    """Return the configuration in which joints are locked: zero, or mid-range where zero is out of range."""
    q: Array = pin.neutral(model)
    for index in range(1, model.njoints):
        if model.nqs[index] == 1:
            at = int(model.idx_qs[index])
            lower, upper = model.lowerPositionLimit[at], model.upperPositionLimit[at]
            if lower < upper and not lower <= q[at] <= upper:
                q[at] = 0.5 * (lower + upper)
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


def has_link_inertia(model: Any) -> bool:
    """Return whether every joint of the model moves some mass or has an armature."""
    moved = np.array([inertia.mass for inertia in model.inertias])
    for index in reversed(range(1, model.njoints)):
        moved[model.parents[index]] += moved[index]
    return bool(np.all((moved[1:] > 0.0) | (np.array(model.armature) > 0.0)))
