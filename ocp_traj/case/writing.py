"""From a trajectory task back to a case file, in SI units; reading it again gives the same task."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np
import tomli_w

from ocp_traj.arrays import Array
from ocp_traj.exceptions import CaseError, TaskError
from ocp_traj.files import write_atomically
from ocp_traj.task import LIMIT_NAMES, Objective, TrajectoryTask

if TYPE_CHECKING:
    from ocp_traj.robot import Robot


def dumps(task: TrajectoryTask, folder: Path | None = None) -> str:
    """Return the text of the case file that states a task.

    Parameters
    ----------
    task : TrajectoryTask
        The task.
    folder : pathlib.Path, optional
        Where the file will lie: a URDF is named relative to it. Default: the current folder.

    Raises
    ------
    TaskError
        The task holds what no case file can: functions of one's own, or a robot that came neither by name nor
        from a URDF below `folder` nor from a DH table.
    """
    if task.constraints or task.objective.custom:
        key = "constraints" if task.constraints else "objective"
        raise TaskError(key, "a function of one's own cannot be written to a case file")
    tables: dict[str, Any] = {"schema": 1, "name": task.name}
    tables.update({name: getattr(task, name) for name in ("title", "source") if getattr(task, name)})
    if task.robot is not None:
        tables["robot"] = _robot_table(task.robot, folder or Path.cwd())
        if task.objective.motor is not None:
            motor = task.objective.motor
            tables["robot"]["motor"] = {
                name: np.broadcast_to(getattr(motor, name), (task.n,)).tolist()
                for name in ("torque_constant", "resistance", "gear_ratio")
            }
    tables["waypoints"] = {"joints": task.waypoints.tolist()}
    if np.any(task.tolerance):
        tables["waypoints"]["tolerance"] = np.asarray(task.tolerance).tolist()
    tables["limits"] = _limits_table(task)
    tables["spline"] = {"family": task.family, "virtual_knots": task.virtual_knots}
    tables["boundary"] = _boundary_table(task)
    tables["objective"] = _objective_table(task)
    tables["search"] = {
        "duration": np.asarray(task.search.duration).tolist(),
        "protocol": task.search.protocol,
    }
    return tomli_w.dumps(tables)


def write_case(task: TrajectoryTask, path: str | Path) -> None:
    """Write a task as a case file; see `dumps` for what cannot be written.

    Parameters
    ----------
    task : TrajectoryTask
    path : path
        The TOML file; overwritten when there is one.

    Raises
    ------
    TaskError
        The task holds what no case file can.
    CaseError
        The file cannot be written.
    """
    path = Path(path)
    text = dumps(task, path.parent)
    try:
        write_atomically(path, text)
    except OSError as error:
        raise CaseError(str(path), "", f"cannot be written ({error.strerror or error})") from None


def _limits_table(task: TrajectoryTask) -> dict[str, Any]:
    table: dict[str, Any] = {}
    gaps: list[dict[str, Any]] = [{"gap": index + 1} for index in range(task.gaps)]
    for name in LIMIT_NAMES:
        values = task.limits.get(name)
        if not np.array_equal(values[0], _default(task.robot, name, task.n)):
            table[name] = values[0].tolist()
        for index in range(1, task.gaps):
            if not np.array_equal(values[index], values[0]):
                gaps[index][name] = values[index].tolist()
    changed = [entry for entry in gaps if len(entry) > 1]
    if changed:
        table["gaps"] = changed
    if task.limits.cartesian_speed:
        table["cartesian_speed"] = [
            {"frame": frame, "speed": speed} for frame, speed in task.limits.cartesian_speed
        ]
    return table


def _default(robot: Robot | None, name: str, n: int) -> Array:
    if robot is not None and name in ("position", "velocity", "torque"):
        return np.asarray(getattr(robot, f"{name}_limits"))
    return np.array([[-np.inf] * n, [np.inf] * n])


def _boundary_table(task: TrajectoryTask) -> dict[str, Any]:
    table: dict[str, Any] = {}
    for name in ("velocity", "acceleration", "jerk"):
        value = getattr(task.boundary, name)
        if value is None:
            table[name] = "free"
        else:
            table[name] = np.asarray(value).tolist() if np.any(value) else "zero"
    return table


def _objective_table(task: TrajectoryTask) -> dict[str, Any]:
    objective = task.objective
    table: dict[str, Any] = {
        name: getattr(objective, name) for name in Objective.WEIGHTS if getattr(objective, name)
    }
    duration, gap_durations = np.asarray(objective.duration), np.asarray(objective.gap_durations)
    bounds: dict[str, Any] = {}
    if not np.array_equal(duration, [0.0, np.inf]):
        bounds["duration"] = duration.tolist()
    if not np.array_equal(gap_durations, np.tile([0.0, np.inf], (task.gaps, 1))):
        bounds["gap_durations"] = gap_durations.tolist()
    if bounds:
        table["bounds"] = bounds
    return table


def _robot_table(robot: Robot, folder: Path) -> dict[str, Any]:
    table, reference = _description(robot, folder)
    for name in ("tool", "base"):
        if getattr(robot, name) != getattr(reference, name):
            table[name] = getattr(robot, name)
    if not np.array_equal(robot.gravity, reference.gravity):
        table["gravity"] = robot.gravity.tolist()
    if robot.payload is not None:
        payload = robot.payload
        table["payload"] = {
            "mass": payload.mass,
            "com": payload.com.tolist(),
            "inertia": payload.inertia.tolist(),
        }
    if not robot.friction.is_zero:
        table["friction"] = {
            "viscous": robot.friction.viscous.tolist(),
            "coulomb": robot.friction.coulomb.tolist(),
        }
    return table


def _description(robot: Robot, folder: Path) -> tuple[dict[str, Any], Robot]:
    """Return what names the arm, and the arm as reading that gives it.

    Raises
    ------
    TaskError
        No key of a case file leads back to this robot.
    """
    from ocp_traj.robot import load_robot, robot_from_dh, robot_from_urdf, robot_names

    if robot.name in robot_names():
        named = load_robot(robot.name)
        if named.description == robot.description and named.joint_names == robot.joint_names:
            return {"model": robot.name}, named
    if robot.description is not None:
        relative = Path(os.path.relpath(robot.description.resolve(), folder.resolve()))
        if ".." in relative.parts:
            raise TaskError(
                "robot.urdf", f"{robot.description.name} does not lie below the folder of the case file"
            )
        return _urdf_table(robot, relative), robot_from_urdf(robot.description, lock=_locked(robot))
    if robot.has_inertia:
        raise TaskError("robot", f"{robot.name!r} came neither by name nor from a URDF nor from a DH table")
    table = dh_table(robot)
    return {"dh": table}, robot_from_dh(**table)


def _urdf_table(robot: Robot, relative: Path) -> dict[str, Any]:
    table: dict[str, Any] = {"urdf": relative.as_posix()}
    locked = _locked(robot)
    if locked:
        table["lock"] = locked
    return table


def _locked(robot: Robot) -> list[str]:
    """Return the joints of the robot's URDF that are not joints of the robot, in the order of the file."""
    assert robot.description is not None  # the caller looked
    everything = ElementTree.parse(robot.description).getroot().findall("joint")
    moving = [joint.get("name", "") for joint in everything if joint.get("type") != "fixed"]
    return [name for name in moving if name not in robot.joint_names]


def dh_table(robot: Robot) -> dict[str, Any]:
    """Return the table of a robot made by `robot_from_dh`, modified or standard, as it stands in a case file.

    A link stands in its parent at Trans(x, a) Rot(x, alpha) Rot(z, theta) Trans(z, d) (Craig, Eq. 3.6); the
    tool's own Trans(x, a) Rot(x, alpha) belongs to the last row of a standard table.

    Raises
    ------
    TaskError
        The robot is no serial chain of such links.
    """
    rows = []
    for index, link in enumerate(robot.links):
        rotation, translation = np.asarray(link.rotation), np.asarray(link.translation)
        alpha = _angle(-rotation[1, 2], rotation[2, 2])
        theta = _angle(-rotation[0, 1], rotation[0, 0])
        d = float(math.cos(alpha) * translation[2] - math.sin(alpha) * translation[1])
        if link.parent != index - 1 or abs(rotation[0, 2]) > 1e-12:
            raise TaskError("robot", f"link {index + 1} of {robot.name!r} has no row in a DH table")
        rows.append((float(translation[0]), alpha, d, theta))
    a, alphas, d_column, thetas = (list(column) for column in zip(*rows))
    tool = _tool_in_last_link(robot)
    convention = "modified"
    if not np.allclose(tool, np.eye(4), rtol=0.0, atol=1e-12):
        convention = "standard"
        a, alphas = [*a[1:], float(tool[0, 3])], [*alphas[1:], _angle(tool[2, 1], tool[2, 2])]
    return {
        "convention": convention,
        "a": a,
        "alpha": alphas,
        "d": d_column,
        "theta": thetas,
        "joints": ["prismatic" if link.prismatic else "revolute" for link in robot.links],
    }


def _tool_in_last_link(robot: Robot) -> Array:
    """Return the tool's placement (4, 4) in the last link."""
    link = np.eye(4)
    for entry in robot.links:
        step = np.eye(4)
        step[:3, :3], step[:3, 3] = entry.rotation, entry.translation
        link = link @ step
    placement = np.linalg.solve(link, robot.pose(np.zeros(robot.n)))
    return np.asarray(placement, dtype=np.float64)


def _angle(sine: float, cosine: float) -> float:
    """Return the angle of a sine and a cosine, rad, rounding errors below 1e-15 taken for zero."""
    return math.atan2(0.0 if abs(sine) < 1e-15 else sine, 0.0 if abs(cosine) < 1e-15 else cosine)
