"""A robot from a URDF file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import RobotError
from ocp_traj.robot.additions import Coupling, Friction
from ocp_traj.robot.description.selection import Lock, Selection, select_joints
from ocp_traj.robot.description.srdf import group_joints, srdf_beside
from ocp_traj.robot.description.tool import default_tool
from ocp_traj.robot.description.urdf_joints import UNLIMITED
from ocp_traj.robot.description.urdf_tree import UrdfTree, read_urdf_tree
from ocp_traj.robot.robot import Robot, RobotSource


def robot_from_urdf(
    path: str | Path,
    lock: Lock = (),
    *,
    keep: Sequence[str] | None = None,
    srdf: str | Path | None = None,
    group: str | None = None,
    tool: str | None = None,
    base: str | None = None,
    name: str | None = None,
    urdf_friction: bool = False,
) -> Robot:
    """Return the robot of a URDF file.

    Joints that mimic another follow it: they are no joints of the robot, but their links move, and their limits
    narrow those of the joint they follow. They stand still where that one does.

    Parameters
    ----------
    path : path
        The URDF, or xacro where the extra ``xacro`` is installed; meshes are looked for only when a picture is drawn.
    lock : sequence of str, or mapping of str to float
        Joints held at zero (at the middle of the range where that excludes zero), or at these positions, rad
        or m; fingers for instance.
    keep : sequence of str, optional
        The joints of the robot; all others are held.
    srdf : path, optional
        Names groups of joints; by default the one beside the URDF or in ``../srdf``.
    group : str, optional
        The group of the SRDF whose joints are the robot's; all others are held.
    tool, base : str, optional
        Frames of the model. The default tool is the flange that the last joint carries: tool0, flange, ..._tcp or
        ee_link, in that order and with any prefix, else the joint's own link; the default base is the root.
    name : str, optional
        By default the one in the file.
    urdf_friction : bool
        Take ``damping`` and ``friction`` of the joints' ``dynamics`` tags. Off by default: most files carry
        values chosen to keep a simulator stable, not measured ones.

    Raises
    ------
    RobotError
        The file cannot be used: missing, invalid, an unknown joint, group or frame, a joint of more than one degree
        of freedom that is not held.
    """
    from ocp_traj.robot.model import plain_model

    path = Path(path)
    tree = read_urdf_tree(path)
    chosen_srdf = Path(srdf) if srdf is not None else srdf_beside(path)
    try:
        selection = select_joints(tree, lock, keep, _members(tree, chosen_srdf, group, keep))
        model = plain_model(_full_model(tree), selection)
        joints = tuple(joint for joint in list(model.names)[1:] if joint in selection.free)
        if not joints:
            raise RobotError("has no joint left that moves")
        rules = {name: (rule.driver, rule.multiplier, rule.offset) for name, rule in selection.followers.items()}
        coupling = Coupling.of(list(model.names)[1:], joints, rules) if rules else None
        limits = _limits(tree, joints, selection)
    except RobotError as error:
        if str(error).startswith("robot description "):
            raise
        raise RobotError(f"robot description {path}: {error}") from error
    friction = Friction.none(len(joints))
    if urdf_friction:
        rubbing = np.array([[tree.joints[joint].damping, tree.joints[joint].dry_friction] for joint in joints])
        friction = Friction(rubbing[:, 0], rubbing[:, 1])
    return Robot(
        name=name or tree.name,
        joint_names=joints,
        joint_types=tuple(tree.joints[joint].kind for joint in joints),
        position_limits=limits["position"],
        velocity_limits=limits["velocity"],
        torque_limits=limits["torque"],
        acceleration_limits=limits["acceleration"],
        jerk_limits=limits["jerk"],
        bare_model=model,
        tool=tool or _default_tool(model, tree, joints[-1]),
        base=base or model.frames[0].name,
        friction=friction,
        source=RobotSource(urdf=path, lock=selection.held, srdf=chosen_srdf),
        coupling=coupling,
    )


def _members(
    tree: UrdfTree, srdf: Path | None, group: str | None, keep: Sequence[str] | None
) -> list[str] | None:
    if group is None:
        return None
    if keep is not None:
        raise RobotError("keep and group are both given, expected one of them")
    if srdf is None:
        raise RobotError(f"group {group!r} needs an SRDF, and none lies beside {tree.path.name} or in ../srdf")
    return group_joints(tree, srdf, group)


def _full_model(tree: UrdfTree) -> Any:
    """Return the `pin.Model` of all joints of a URDF, its base fixed."""
    import pinocchio as pin

    try:
        model = pin.buildModelFromXML(tree.reduced())
    except (ValueError, RuntimeError) as error:
        raise RobotError(f"is not a valid URDF: {error}") from error
    for index, (inertia, placement) in enumerate(zip(model.inertias, model.jointPlacements, strict=True)):
        numbers = np.concatenate([inertia.toDynamicParameters(), np.ravel(placement.homogeneous)])
        if not np.isfinite(numbers).all():
            raise RobotError(f"joint {model.names[index]}: its link or place has a number that is not finite")
        if inertia.mass < 0.0:
            raise RobotError(
                f"joint {model.names[index]}: its link has a mass of {inertia.mass:g} kg, expected 0 or more"
            )
    return model


def _limits(tree: UrdfTree, joints: tuple[str, ...], selection: Selection) -> dict[str, Array]:
    """Return the limits (2, n) by quantity, infinite where the file gives none; those of followers narrow them."""
    limits: dict[str, Array] = {}
    for quantity in ("position", "velocity", "torque", "acceleration", "jerk"):
        rows = [tree.joints[name].limits.get(quantity, UNLIMITED) for name in joints]
        limits[quantity] = np.array(rows, dtype=np.float64).T
    for name, follower in selection.followers.items():
        column = joints.index(follower.driver)
        for quantity in ("position", "velocity", "acceleration", "jerk"):
            given = tree.joints[name].limits.get(quantity)
            if given is None or follower.multiplier == 0.0:
                continue
            offset = follower.offset if quantity == "position" else 0.0
            bounds = sorted((bound - offset) / follower.multiplier for bound in given)
            narrowed = limits[quantity][:, column]
            narrowed[:] = max(narrowed[0], bounds[0]), min(narrowed[1], bounds[1])
            if narrowed[0] > narrowed[1]:
                raise RobotError(f"joint {name!r} leaves no range to {follower.driver!r}, which it follows")
    return limits


def _default_tool(model: Any, tree: UrdfTree, joint: str) -> str:
    import pinocchio as pin

    number = model.getJointId(joint)
    bodies = [
        frame.name
        for frame in model.frames
        if frame.parentJoint == number and frame.type == pin.FrameType.BODY
    ]
    return default_tool(bodies, tree.joints[joint].child)
