"""Robots known by name: the URDF files of the package `example-robot-data`, found on this machine."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import metadata
from pathlib import Path

import numpy as np

from ocp_traj.exceptions import RobotError, UnknownNameError, did_you_mean
from ocp_traj.robot.description.selection import Lock
from ocp_traj.robot.robot import Robot

DATA_VARIABLE = "OCP_TRAJ_ROBOT_DATA"
"""Environment variable that names a folder to be used instead of the installed robot data."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class PackagedRobot:
    """Where a named robot is, which of its joints move, and what is put right.

    Attributes
    ----------
    urdf : str
        Path below the data's ``robots`` folder.
    tool : str
    keep : tuple of str
        Joints that move; all when empty.
    lock : tuple of str
        Joints that do not move.
    torque : mapping of str to float
        Rated torques by joint, N m, that replace the file's.
    """

    urdf: str
    tool: str
    keep: tuple[str, ...] = ()
    lock: tuple[str, ...] = ()
    torque: Mapping[str, float] = field(default_factory=dict)


def _numbered(pattern: str, count: int) -> tuple[str, ...]:
    return tuple(pattern.format(index) for index in range(1, count + 1))


_BAXTER = ("{0}_s0", "{0}_s1", "{0}_e0", "{0}_e1", "{0}_w0", "{0}_w1", "{0}_w2")
_PR2 = (
    "{0}_shoulder_pan_joint",
    "{0}_shoulder_lift_joint",
    "{0}_upper_arm_roll_joint",
    "{0}_elbow_flex_joint",
    "{0}_forearm_roll_joint",
    "{0}_wrist_flex_joint",
    "{0}_wrist_roll_joint",
)


def _side(names: tuple[str, ...], side: str) -> tuple[str, ...]:
    return tuple(name.format(side) for name in names)


PACKAGED_ROBOTS = {
    "baxter-left": PackagedRobot(
        "baxter_description/urdf/baxter.urdf", "left_gripper", _side(_BAXTER, "left")
    ),
    "baxter-right": PackagedRobot(
        "baxter_description/urdf/baxter.urdf", "right_gripper", _side(_BAXTER, "right")
    ),
    "kinova": PackagedRobot("kinova_description/robots/kinova.urdf", "j2s6s200_end_effector"),
    "panda": PackagedRobot(
        "panda_description/urdf/panda.urdf",
        "panda_hand_tcp",
        lock=("panda_finger_joint1", "panda_finger_joint2"),
    ),
    "pr2-left": PackagedRobot("pr2_description/urdf/pr2.urdf", "l_gripper_tool_frame", _side(_PR2, "l")),
    "pr2-right": PackagedRobot("pr2_description/urdf/pr2.urdf", "r_gripper_tool_frame", _side(_PR2, "r")),
    "so100": PackagedRobot("so_arm_description/urdf/so100.urdf", "gripper", lock=("gripper",)),
    "so101": PackagedRobot("so_arm_description/urdf/so101.urdf", "gripper_frame_link", lock=("gripper",)),
    "talos-arm": PackagedRobot(
        "talos_data/robots/talos_left_arm.urdf", "gripper_left_base_link", lock=("gripper_left_joint",)
    ),
    "talos-left-arm": PackagedRobot(
        "talos_data/robots/talos_reduced.urdf", "gripper_left_base_link", _numbered("arm_left_{}_joint", 7)
    ),
    "talos-right-arm": PackagedRobot(
        "talos_data/robots/talos_reduced.urdf", "gripper_right_base_link", _numbered("arm_right_{}_joint", 7)
    ),
    "tiago": PackagedRobot(
        "tiago_description/robots/tiago_no_hand.urdf", "arm_tool_link", _numbered("arm_{}_joint", 7)
    ),
    "tiago-pro-left": PackagedRobot(
        "tiago_pro_description/robots/tiago_pro.urdf", "arm_left_tool_link", _numbered("arm_left_{}_joint", 7)
    ),
    "tiago-pro-right": PackagedRobot(
        "tiago_pro_description/robots/tiago_pro.urdf",
        "arm_right_tool_link",
        _numbered("arm_right_{}_joint", 7),
    ),
    "two-dof": PackagedRobot("asr_twodof_description/urdf/TwoDofs.urdf", "Tip"),
    "ur10": PackagedRobot("ur_description/urdf/ur10_robot.urdf", "tool0"),
    # The file's efforts are a copy of the UR10's (330 330 150 54 54 54 N m). These are Universal Robots' own:
    # support article "Max. joint torques" (2020-06-09), for the UR3 of the CB series. The file's velocities,
    # UR10's as well, are below the UR3's rated ones and stay.
    "ur3": PackagedRobot(
        "ur_description/urdf/ur3_robot.urdf",
        "tool0",
        torque={
            "shoulder_pan_joint": 56.0,
            "shoulder_lift_joint": 56.0,
            "elbow_joint": 28.0,
            "wrist_1_joint": 12.0,
            "wrist_2_joint": 12.0,
            "wrist_3_joint": 12.0,
        },
    ),
    "ur5": PackagedRobot("ur_description/urdf/ur5_robot.urdf", "tool0"),
    "xarm7": PackagedRobot("xarm_description/urdf/xarm7.urdf", "link_eef"),
    "z1": PackagedRobot("z1_description/urdf/z1.urdf", "gripperStator", lock=("jointGripper",)),
}


def robot_names() -> list[str]:
    """Return the names `load_robot` knows; needs neither Pinocchio nor the robot data."""
    return sorted(PACKAGED_ROBOTS)


def load_robot(
    name: str,
    lock: Lock = (),
    *,
    keep: Sequence[str] | None = None,
    srdf: str | Path | None = None,
    group: str | None = None,
) -> Robot:
    """Return a robot by name.

    Parameters
    ----------
    name : str
        One of `robot_names`.
    lock : sequence of str, or mapping of str to float
        Joints held still beside those that are by default, at zero or at these positions.
    keep : sequence of str, optional
        The joints of the robot in place of the default ones; all others are held.
    srdf : path, optional
        Names groups of joints; by default the robot's own.
    group : str, optional
        The group whose joints are the robot's, in place of the default ones.

    Raises
    ------
    UnknownNameError
        There is no such name; the message lists those there are.
    RobotError
        The robot data is not installed, or there is no such joint or group.

    Examples
    --------
    >>> load_robot("ur5").n
    6
    """
    if name not in PACKAGED_ROBOTS:
        known = robot_names()
        raise UnknownNameError(
            f"robot {name!r} is unknown, expected one of {', '.join(known)}{did_you_mean(str(name), known)}"
        )
    if not (lock or keep is not None or srdf is not None or group is not None):
        return _load(name, data_folder())
    return _build(name, data_folder(), lock, keep, srdf, group)


@cache
def _load(name: str, folder: Path) -> Robot:
    return _build(name, folder, (), None, None, None)


def _build(
    name: str,
    folder: Path,
    lock: Lock,
    keep: Sequence[str] | None,
    srdf: str | Path | None,
    group: str | None,
) -> Robot:
    from ocp_traj.robot.urdf import robot_from_urdf

    entry = PACKAGED_ROBOTS[name]
    own = keep is None and group is None
    positions = dict(lock) if isinstance(lock, Mapping) else dict.fromkeys(lock)
    if own and entry.keep:
        keep = [joint for joint in entry.keep if joint not in positions]
    if own:
        positions = {**dict.fromkeys(entry.lock), **positions}
    robot = robot_from_urdf(folder / entry.urdf, positions, keep=keep, srdf=srdf, group=group, name=name)
    if robot.frame_placement(entry.tool)[0]:
        robot = robot.with_changes(tool=entry.tool)
    assert robot.source is not None  # read from a URDF
    robot = replace(robot, source=replace(robot.source, name=name))
    if entry.torque:
        names, given = robot.joint_names, robot.torque_limits[1]
        torque = np.array([entry.torque.get(joint, limit) for joint, limit in zip(names, given, strict=True)])
        robot = replace(robot, torque_limits=np.array([-torque, torque]))
        logger.debug("robot %s: rated torques %s replace those of its URDF", name, entry.torque)
    return robot


def data_folder() -> Path:
    """Return the folder ``robots`` of `example-robot-data`.

    Looked for in this order: the folder named by the environment variable ``OCP_TRAJ_ROBOT_DATA``, the
    installed wheel's files, the share folders below the interpreter's prefix and conda's, and ROS's ament
    prefixes.

    Raises
    ------
    RobotError
        It is nowhere; the message says what to install.
    """
    candidates = list(_candidates())
    for folder in candidates:
        if folder.is_dir():
            return folder
    looked = ", ".join(str(folder) for folder in candidates)
    raise RobotError(
        f"the robot data is in none of {looked}; install it with `pip install example-robot-data` or from "
        f"conda-forge, or set {DATA_VARIABLE} to its folder 'robots'"
    )


def _candidates() -> Iterator[Path]:
    chosen = os.environ.get(DATA_VARIABLE)
    if chosen:
        yield Path(chosen)
        return
    below = Path("share") / "example-robot-data" / "robots"
    try:
        root = Path(str(metadata.distribution("example-robot-data").locate_file("cmeel.prefix")))
        yield root / below
    except metadata.PackageNotFoundError:
        logger.debug("no distribution example-robot-data, looking in the share folders")
    for entry in sys.path:
        if entry:
            yield Path(entry) / "cmeel.prefix" / below
    yield Path(sys.prefix) / below
    for variable in ("CONDA_PREFIX", "AMENT_PREFIX_PATH"):
        for prefix in filter(None, os.environ.get(variable, "").split(os.pathsep)):
            yield Path(prefix) / below
