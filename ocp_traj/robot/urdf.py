"""A robot from a URDF file."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import RobotError
from ocp_traj.robot.additions import Friction
from ocp_traj.robot.robot import Robot, RobotSource

_COMMENT = re.compile("<!--.*?-->", re.DOTALL)
_MASS_TAG = re.compile(r"<(mass|inertia)\b([^<>]*)>")
_ATTRIBUTE = re.compile(r"""([A-Za-z]+)\s*=\s*["']([^"']*)["']""")

MAX_BYTES = 100_000_000
"""Largest description that is read, bytes; meshes are files of their own."""

MAX_JOINTS = 200
"""Joints up to which a description is read: Pinocchio's working memory grows with their cube, 0.5 GB here."""


def read_urdf(path: Path) -> Any:
    """Return the full `pin.Model` of a URDF file with a fixed base.

    Raises
    ------
    RobotError
        The file is missing or too large, Pinocchio cannot read it, or it has too many joints, a negative mass,
        or a number that is not finite.
    """
    import pinocchio as pin

    if not path.is_file():
        raise RobotError(f"robot description {path} does not exist")
    if path.stat().st_size > MAX_BYTES:
        raise RobotError(f"robot description {path} is larger than {MAX_BYTES} bytes")
    _check_masses(path)
    try:
        model = pin.buildModelFromUrdf(str(path))
    except (ValueError, RuntimeError) as error:
        raise RobotError(f"robot description {path} is not a valid URDF: {error}") from error
    if model.njoints - 1 > MAX_JOINTS:
        raise RobotError(
            f"robot description {path} has {model.njoints - 1} joints, expected at most {MAX_JOINTS}"
        )
    _check_numbers(model, path)
    return model


def _check_masses(path: Path) -> None:
    """Refuse a mass or inertia that is no finite number: the parser would leave it out and go on."""
    try:
        text = _COMMENT.sub("", path.read_text(encoding="utf-8", errors="replace"))
    except OSError as error:
        raise RobotError(f"robot description {path} cannot be read: {error.strerror}") from None
    for tag in _MASS_TAG.finditer(text):
        for name, value in _ATTRIBUTE.findall(tag[2]):
            if not _is_finite(value):
                raise RobotError(
                    f"robot description {path}: <{tag[1]} {name}={value[:40]!r}> given, expected a finite number"
                )


def _is_finite(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _check_numbers(model: Any, path: Path) -> None:
    for index, (inertia, placement) in enumerate(zip(model.inertias, model.jointPlacements, strict=True)):
        numbers = np.concatenate([inertia.toDynamicParameters(), np.ravel(placement.homogeneous)])
        if not np.isfinite(numbers).all():
            raise RobotError(
                f"robot description {path}: joint {model.names[index]}: its link or place has a number that "
                "is not finite"
            )
        if inertia.mass < 0.0:
            raise RobotError(
                f"robot description {path}: joint {model.names[index]}: its link has a mass of "
                f"{inertia.mass:g} kg, expected 0 or more"
            )


def _limits_of(model: Any) -> tuple[Array, Array, Array]:
    position = np.array([model.lowerPositionLimit, model.upperPositionLimit])
    velocity, effort = np.array(model.velocityLimit), np.array(model.effortLimit)
    return position, np.array([-velocity, velocity]), np.array([-effort, effort])


def robot_from_urdf(
    path: str | Path,
    lock: Sequence[str] = (),
    *,
    keep: Sequence[str] | None = None,
    tool: str | None = None,
    base: str | None = None,
    name: str | None = None,
    urdf_friction: bool = False,
) -> Robot:
    """Return the robot of a URDF file.

    Parameters
    ----------
    path : path
        The URDF; meshes are looked for only when a picture is drawn.
    lock : sequence of str
        Joints to be locked at zero (at the middle of the range where that excludes zero), for instance
        fingers.
    keep : sequence of str, optional
        The joints of the robot; all others are locked.
    tool, base : str, optional
        Frames of the model; by default the last frame and the root.
    name : str, optional
        By default the one in the file.
    urdf_friction : bool
        Take ``damping`` and ``friction`` of the joints' ``dynamics`` tags. Off by default: most files carry
        values chosen to keep a simulator stable, not measured ones.

    Raises
    ------
    RobotError
        The file cannot be used: missing, invalid, an unknown joint or frame, a joint of more than one degree
        of freedom that is not locked.
    """
    from ocp_traj.robot.model import locked_joints, plain_model

    path = Path(path)
    full = read_urdf(path)
    locked = locked_joints(full, lock, keep)
    try:
        plain = plain_model(full, locked)
    except RobotError as error:
        raise RobotError(f"robot description {path}: {error}") from error
    model = plain.model
    if model.njoints < 2:
        raise RobotError(f"robot description {path} has no joint left that moves")
    position, velocity, torque = _limits_of(model)
    friction = Friction.none(model.nv)
    if urdf_friction:
        dry = np.array(getattr(full, "upperDryFrictionLimit", getattr(full, "friction", None)))
        kept = [full.idx_vs[index] for index in range(1, full.njoints) if index not in locked]
        friction = Friction(np.array(model.damping), dry[kept])
    return Robot(
        name=name or model.name,
        joint_names=tuple(model.names)[1:],
        joint_types=plain.joint_types,
        position_limits=position,
        velocity_limits=velocity,
        torque_limits=torque,
        bare_model=model,
        tool=tool or model.frames[model.nframes - 1].name,
        base=base or model.frames[0].name,
        friction=friction,
        source=RobotSource(urdf=path, lock=tuple(full.names[index] for index in sorted(locked))),
    )
