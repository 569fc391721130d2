"""The ``[robot]`` table of a case file: which arm, and how it stands in the cell."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.case.chains import robot_of_chain
from ocp_traj.case.section import Section
from ocp_traj.case.toml_files import MAX_BYTES
from ocp_traj.exceptions import CaseError, InputError, TaskError, did_you_mean
from ocp_traj.task import Motor

if TYPE_CHECKING:
    from ocp_traj.robot import Robot

DESCRIPTIONS = ("model", "urdf", "dh", "chain")
"""The ways to say which arm, one of which a robot has; ``chain`` is how a robot travels with a result."""

SELECTION = ("lock", "keep", "srdf", "group")
"""Keys that say which joints belong to the task."""

KEYS = (*DESCRIPTIONS, *SELECTION, "tool", "base", "payload", "gravity", "friction", "motor")
"""Keys of ``[robot]``."""

MAX_JOINTS = 100
"""Largest number of joints of a case."""


def read_robot(section: Section, folder: Path, trusted: Collection[str]) -> Robot:
    """Return the robot of a ``[robot]`` table.

    Parameters
    ----------
    section : Section
        The table.
    folder : pathlib.Path
        Where the case file lies: paths in it are relative to this and stay below it.
    trusted : collection of str
        Dotted keys the caller set by hand, whose paths may lead anywhere.

    Raises
    ------
    CaseError
        A key is unknown or wrong, the robot or a frame does not exist.
    """
    section.check_keys(KEYS)
    given = [name for name in DESCRIPTIONS if name in section]
    if len(given) != 1:
        told = " and ".join(given) or "none"
        raise section.error("", f"{told} given, expected exactly one of {', '.join(DESCRIPTIONS)}")
    kind = given[0]
    chosen = _selection(section, folder, trusted)
    if kind in ("dh", "chain") and chosen:
        raise section.error(min(chosen), f"chooses joints of a urdf or model, but the robot is given by {kind}")
    with robot_errors(section, kind):
        if kind == "model":
            robot = _named_robot(section, chosen)
        elif kind == "urdf":
            robot = _urdf_robot(section, folder, trusted, chosen)
        elif kind == "dh":
            robot = _dh_robot(section.section("dh"))
        else:
            robot = robot_of_chain(section.section("chain"))
    if robot.n > MAX_JOINTS:
        raise section.error(kind, f"has {robot.n} joints, expected at most {MAX_JOINTS}")
    return _in_the_cell(section, robot)


@contextmanager
def robot_errors(section: Section, name: str) -> Iterator[None]:
    """Turn what the robot layer refuses into an error that names file and key."""
    try:
        yield
    except CaseError:
        raise
    except InputError as error:
        raise section.error(name, str(error)) from error


def resolve_inside(section: Section, name: str, folder: Path, trusted: Collection[str]) -> Path:
    """Return the path of an entry, relative to the case's folder and below it.

    Raises
    ------
    CaseError
        The path is absolute or leads out of the folder (unless the caller set this key by hand), the file is
        missing or too large.
    """
    text = section.text(name)
    try:
        path = (folder / text).resolve()
        inside = not Path(text).is_absolute() and path.is_relative_to(folder.resolve())
        if not inside and section.path(name) not in trusted:
            raise section.error(
                name, f"{text!r} leads out of the case's folder, expected a path relative to and below it"
            )
        if not path.is_file():
            raise section.error(name, f"{text!r} does not exist beside the case, expected a file")
        if path.stat().st_size > MAX_BYTES:
            raise section.error(name, f"{text!r} is larger than {MAX_BYTES // 1_000_000} MB")
    except (OSError, RuntimeError) as error:
        raise section.error(name, f"{text[:60]!r} cannot be used as a path ({error})") from None
    return path


def _selection(section: Section, folder: Path, trusted: Collection[str]) -> dict[str, Any]:
    """Return the arguments of `robot_from_urdf` and `load_robot` that the keys of `SELECTION` give."""
    chosen: dict[str, Any] = {}
    if "lock" in section:
        if isinstance(section.data["lock"], dict):
            table = section.section("lock")
            chosen["lock"] = {name: table.number(name) for name in table.data}
        else:
            chosen["lock"] = section.texts("lock")
    if "keep" in section:
        chosen["keep"] = section.texts("keep")
    if "srdf" in section:
        chosen["srdf"] = resolve_inside(section, "srdf", folder, trusted)
    if "group" in section:
        chosen["group"] = section.text("group")
    return chosen


def _named_robot(section: Section, chosen: dict[str, Any]) -> Robot:
    from ocp_traj.robot import load_robot, robot_names

    name, known = section.text("model"), robot_names()
    if name not in known:
        expected = ", ".join(known)
        raise section.error(
            "model", f"robot {name!r} is unknown, expected one of {expected}{did_you_mean(name, known)}"
        )
    return load_robot(name, **chosen)


def _urdf_robot(section: Section, folder: Path, trusted: Collection[str], chosen: dict[str, Any]) -> Robot:
    from ocp_traj.robot import robot_from_urdf

    return robot_from_urdf(resolve_inside(section, "urdf", folder, trusted), **chosen)


def _dh_robot(table: Section) -> Robot:
    from ocp_traj.robot import robot_from_dh

    table.check_keys(("convention", "unit", "a", "alpha", "d", "theta", "joints"))
    convention = table.choice("convention", ("standard", "modified"))
    unit = table.choice("unit", ("rad", "deg"), "rad")
    rows = table.array("a").shape
    if len(rows) != 1 or not 1 <= rows[0] <= MAX_JOINTS:
        raise table.error("a", f"expected a list of 1 to {MAX_JOINTS} numbers, one a joint")
    a, alpha, d, theta = (table.array_of_shape(name, rows) for name in ("a", "alpha", "d", "theta"))
    joints = table.texts("joints") or ("revolute",) * rows[0]
    if len(joints) != rows[0] or not set(joints) <= {"revolute", "prismatic"}:
        raise table.error("joints", f"expected {rows[0]} of 'revolute' or 'prismatic'")
    return robot_from_dh(convention, a, alpha, d, theta, unit, joints)


def _in_the_cell(section: Section, robot: Robot) -> Robot:
    from ocp_traj.robot import Friction, Payload

    if "tool" in section:
        with robot_errors(section, "tool"):
            robot = robot.with_changes(tool=section.text("tool"))
    if "base" in section:
        with robot_errors(section, "base"):
            robot = robot.with_changes(base=section.text("base"))
    if "gravity" in section:
        robot = robot.with_changes(gravity=section.array_of_shape("gravity", (3,)))
    if "payload" in section:
        table = section.section("payload")
        table.check_keys(("mass", "com", "inertia"))
        com = table.array_of_shape("com", (3,)) if "com" in table else np.zeros(3)
        inertia = table.array_of_shape("inertia", (6,)) if "inertia" in table else np.zeros(6)
        with robot_errors(section, "payload"):
            robot = robot.with_changes(payload=Payload(table.number("mass"), com, inertia))
    if "friction" in section:
        table = section.section("friction")
        table.check_keys(("viscous", "coulomb"))
        with robot_errors(section, "friction"):
            robot = robot.with_changes(
                friction=Friction(
                    _per_joint(table, "viscous", robot.n), _per_joint(table, "coulomb", robot.n)
                )
            )
    return robot


def _per_joint(table: Section, name: str, n: int) -> Array:
    if name not in table:
        return np.zeros(n)
    return np.broadcast_to(table.array_of_shape(name, (), (n,)), (n,))


def read_motor(section: Section, n: int) -> Motor | None:
    """Return the motors of a ``[robot]`` table, None when it has none.

    Raises
    ------
    CaseError
        A key is unknown, a shape is wrong or a number is not positive.
    """
    if "motor" not in section:
        return None
    table = section.section("motor")
    table.check_keys(("torque_constant", "resistance", "gear_ratio"))
    values = {}
    for name in ("torque_constant", "resistance", "gear_ratio"):
        given = table.array_of_shape(name, (), (n,)) if name in table or name != "gear_ratio" else np.ones(())
        if not (given > 0).all():
            raise table.error(name, f"{given.min():g} given, expected positive numbers")
        values[name] = np.broadcast_to(given, (n,))
    return Motor(**values)


def limited_to(robot: Robot, position: Array) -> Robot:
    """Return the robot with position limits (2, n) narrowed to those of the case, for inverse kinematics.

    Raises
    ------
    TaskError
        The case's range and the robot's have nothing in common.
    """
    lower = np.maximum(robot.position_limits[0], position[0])
    upper = np.minimum(robot.position_limits[1], position[1])
    if (lower > upper).any():
        joint = int(np.argmax(lower > upper))
        raise TaskError(
            "limits.position", f"the range of joint {joint + 1} and the robot's own have nothing in common"
        )
    return replace(robot, position_limits=np.stack([lower, upper]))


def short_way(section: Section, robot: Robot | None, waypoints: Array) -> Array:
    """Return the waypoints (K, n) with every continuous joint at the turn nearest to where it was before.

    Raises
    ------
    CaseError
        There is no robot, or none of its joints is continuous.
    """
    turning = [kind == "continuous" for kind in ([] if robot is None else robot.joint_types)]
    if not any(turning):
        raise section.error("continuous", "'short' given, but the case has no robot with a continuous joint")
    turns = np.cumsum(np.round(np.diff(waypoints, axis=0) / (2.0 * np.pi)), axis=0)
    nearest = waypoints.copy()
    nearest[1:] -= np.where(turning, 2.0 * np.pi * turns, 0.0)
    return nearest
