"""From a trajectory task back to a case file, in SI units; reading it again gives the same task."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import tomli_w

from ocp_traj.case.collision import below, collision_table
from ocp_traj.exceptions import CaseError, TaskError
from ocp_traj.files import write_atomically
from ocp_traj.quantities import RATES
from ocp_traj.task import TrajectoryTask
from ocp_traj.task.limits import default_limits

if TYPE_CHECKING:
    from ocp_traj.robot import Robot, RobotSource


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
    folder = folder or Path.cwd()
    arm = None if task.robot is None else described(task.robot, folder)
    tables = task_tables(task, arm)
    if task.collision is not None:
        tables["collision"] = collision_table(task.collision, folder)
        source = task.robot.source if task.robot is not None else None
        if task.collision.pairs == "srdf" and source is not None and source.srdf is not None and not source.name:
            tables["robot"]["srdf"] = below(source.srdf, folder, "robot.srdf")
    return tomli_w.dumps(tables)


Arm = tuple[dict[str, Any], "Robot"]
"""The keys of ``[robot]`` that say which arm, and the arm that these alone give."""


def task_tables(task: TrajectoryTask, arm: Arm | None, *, complete: bool = False) -> dict[str, Any]:
    """Return the tables of a case file that states a task.

    Parameters
    ----------
    task : TrajectoryTask
    arm : Arm, optional
        How the task's robot is named.
    complete : bool
        Write limits that are the arm's own, too.

    Raises
    ------
    TaskError
        The task holds functions or a spline family of one's own.
    """
    if task.constraints or task.objective.custom:
        key = "constraints" if task.constraints else "objective"
        raise TaskError(key, "a function of one's own cannot be written to a case file")
    tables: dict[str, Any] = {"schema": 1, "name": task.name}
    tables.update({name: getattr(task, name) for name in ("title", "source") if getattr(task, name)})
    reference = None
    if task.robot is not None and arm is not None:
        tables["robot"], reference = arm[0] | _cell_table(task.robot, arm[1]), arm[1]
        if task.objective.motor is not None:
            motor = task.objective.motor
            tables["robot"]["motor"] = {
                name: np.broadcast_to(getattr(motor, name), (task.n,)).tolist()
                for name in ("torque_constant", "resistance", "gear_ratio")
            }
    tables["waypoints"] = {"joints": task.waypoints.tolist()}
    if np.any(task.tolerance):
        tables["waypoints"]["tolerance"] = np.asarray(task.tolerance).tolist()
    tables["limits"] = _limits_table(task, None if complete else reference)
    tables["spline"] = {"family": task.family.name, "virtual_knots": task.virtual_knots}
    tables["boundary"] = _boundary_table(task)
    tables["objective"] = _objective_table(task)
    tables["search"] = {
        "duration": np.asarray(task.search.duration).tolist(),
        "offset": task.search.offset,
        "protocol": task.search.protocol,
    }
    return tables


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


def _limits_table(task: TrajectoryTask, robot: Robot | None) -> dict[str, Any]:
    """Return the limits that differ from those of the robot as reading the case gives it."""
    table: dict[str, Any] = {}
    gaps: list[dict[str, Any]] = [{"gap": index + 1} for index in range(task.gaps)]
    for name in task.limits.names:
        values = task.limits.get(name)
        if not np.array_equal(values[0], default_limits(name, task.n, robot)):
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


def _boundary_table(task: TrajectoryTask) -> dict[str, Any]:
    table: dict[str, Any] = {}
    for name in RATES:
        value = getattr(task.boundary, name)
        if value is None:
            table[name] = "free"
        else:
            table[name] = np.asarray(value).tolist() if np.any(value) else "zero"
    return table


def _objective_table(task: TrajectoryTask) -> dict[str, Any]:
    objective = task.objective
    table: dict[str, Any] = dict(objective.weights)
    duration, gap_durations = np.asarray(objective.duration), np.asarray(objective.gap_durations)
    bounds: dict[str, Any] = {}
    if not np.array_equal(duration, [0.0, np.inf]):
        bounds["duration"] = duration.tolist()
    if not np.array_equal(gap_durations, np.tile([0.0, np.inf], (task.gaps, 1))):
        bounds["gap_durations"] = gap_durations.tolist()
    if bounds:
        table["bounds"] = bounds
    return table


def _cell_table(robot: Robot, reference: Robot) -> dict[str, Any]:
    """Return how a robot stands in its cell, where that differs from what its description alone gives."""
    table: dict[str, Any] = {}
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


def described(robot: Robot, folder: Path) -> Arm:
    """Return what names the arm, and the arm as reading that gives it.

    Raises
    ------
    TaskError
        No key of a case file leads back to this robot.
    """
    from ocp_traj.robot import RobotSource, load_robot, robot_from_dh, robot_from_urdf

    source = robot.source or RobotSource()
    if source.name:
        named = load_robot(source.name)
        assert named.source is not None  # read from a URDF
        if named.joint_names == robot.joint_names and named.source.lock == source.lock:
            return {"model": source.name}, named
        chosen = _selection(robot, source)
        return {"model": source.name, **chosen}, load_robot(source.name, **chosen)
    if source.dh is not None:
        return {"dh": dict(source.dh)}, robot_from_dh(**source.dh)
    if source.urdf is None:
        raise TaskError("robot", f"{robot.name!r} came neither by name nor from a URDF nor from a DH table")
    relative = below(source.urdf, folder, "robot.urdf")
    chosen = _selection(robot, source)
    return {"urdf": relative, **chosen}, robot_from_urdf(source.urdf, **chosen)


def _selection(robot: Robot, source: RobotSource) -> dict[str, Any]:
    """Return the keys that say which joints of a description stand still, and where if not at zero."""
    table: dict[str, Any] = {"keep": list(robot.joint_names)} if source.name else {}
    if any(source.lock.values()):
        table["lock"] = dict(source.lock)
    elif source.lock and not source.name:
        table["lock"] = list(source.lock)
    return table
