"""The task that travels with a result: a case as JSON, complete in itself, and back."""

from __future__ import annotations

import copy
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ocp_traj.case.chains import LIMITS, chain_table, robot_of_chain
from ocp_traj.case.reading import task_from_tables
from ocp_traj.case.section import Section
from ocp_traj.case.toml_files import apply_override, read_text
from ocp_traj.case.writing import Arm, described, task_tables
from ocp_traj.exceptions import CaseError, RobotError, TaskError
from ocp_traj.files import finite
from ocp_traj.quantities import JOINT_LIMITS
from ocp_traj.spline import FAMILIES
from ocp_traj.task import TrajectoryTask

if TYPE_CHECKING:
    from ocp_traj.robot import Robot

MAX_BYTES = 2**30
"""Largest file that a task is read from, bytes."""

_INFINITY = float("inf")


def task_to_json(task: TrajectoryTask) -> dict[str, Any] | None:
    """Return a task as JSON values, keys as in a case file; None where it has functions or a family of one's own.

    A robot that came by name or from a DH table is named so, any other is written as its chain of joints. Limits are
    complete, those of the robot too; ``null`` is no limit.

    Parameters
    ----------
    task : TrajectoryTask
    """
    if FAMILIES.get(task.family.name) is not task.family:
        return None
    try:
        tables = task_tables(task, None if task.robot is None else _arm(task.robot), complete=True)
    except TaskError:  # functions of one's own
        return None
    tables["limits"] = {**dict.fromkeys(task.limits.names), **tables["limits"]}
    return finite(tables)


def _arm(robot: Robot) -> Arm:
    """Return the name or the DH table that leads back to a robot, else its chain."""
    if robot.source is not None and (robot.source.name or robot.source.dh is not None):
        table, reference = described(robot, Path())
        if _differs_in_its_cell_alone(robot, reference):
            return table, reference
    chain = chain_table(robot)
    return {"chain": chain}, robot_of_chain(Section("task", "robot.chain", chain))


def _differs_in_its_cell_alone(robot: Robot, reference: Robot) -> bool:
    cell = {name: getattr(robot, name) for name in ("tool", "base", "gravity", "payload", "friction")}
    try:
        return replace(reference, **cell) == robot
    except RobotError:  # a frame that the arm as it is named does not have
        return False


def task_from_json(data: Any, file: str, overrides: Sequence[str] = ()) -> TrajectoryTask:
    """Return the task that `task_to_json` wrote.

    Parameters
    ----------
    data : mapping
        As read from a file.
    file : str
        The file as the caller named it, for messages.
    overrides : sequence of str
        ``KEY=VALUE``, as in `load_case`.

    Raises
    ------
    CaseError
        Something in the task cannot be used.
    """
    if not isinstance(data, Mapping):
        raise CaseError(file, "task", f"holds a {type(data).__name__}, expected an object with the keys of a case")
    tables = copy.deepcopy(dict(data))
    trusted = [apply_override(tables, override, file) for override in overrides]
    _put_infinities_back(tables)
    name = tables.get("name")
    if not isinstance(name, str):
        raise CaseError(file, "name", "missing, expected a text")
    task = task_from_tables({**tables, "name": "task"}, file, Path(file).parent, trusted)
    return replace(task, name=name)


def carried_task(
    path: Path, file: str | None = None, overrides: Sequence[str] = ()
) -> TrajectoryTask | None:
    """Return the task that a result or an exact curve carries as its key ``task``, None where it carries none.

    Parameters
    ----------
    path : pathlib.Path
        A JSON file.
    file : str, optional
        Its name in messages.
    overrides : sequence of str
        ``KEY=VALUE``, as in `load_case`.

    Raises
    ------
    CaseError
        The file cannot be read, or something in the task cannot be used.
    """
    file = file or str(path)
    carried = carried_tables(path, file)
    return None if carried is None else task_from_json(carried, file, overrides)


def carried_tables(path: Path, file: str) -> Any:
    """Return what a result or an exact curve carries as its key ``task``, unread; None where it carries nothing."""
    try:
        data = json.loads(read_text(path, file, MAX_BYTES))
    except (ValueError, RecursionError) as error:
        if isinstance(error, CaseError):
            raise
        raise CaseError(file, "", f"is no JSON: {error}") from None
    return data.get("task") if isinstance(data, Mapping) else None


def _put_infinities_back(tables: dict[str, Any]) -> None:
    """Replace ``null`` by the infinity it stands for, in limits and bounds."""
    limits = tables.get("limits")
    if isinstance(limits, dict):
        gaps = limits.get("gaps")
        for table in (limits, *(gaps if isinstance(gaps, list) else ())):
            _restore(table, tuple(JOINT_LIMITS))
    chain = _inside(tables, "robot", "chain", "joints")
    for joint in chain if isinstance(chain, list) else ():
        _restore_pairs(joint, LIMITS)
    bounds = _inside(tables, "objective", "bounds")
    _restore_pairs(bounds, ("duration",))
    if isinstance(bounds, dict) and isinstance(bounds.get("gap_durations"), list):
        bounds["gap_durations"] = [_pair(entry) for entry in bounds["gap_durations"]]


def _inside(table: Any, *names: str) -> Any:
    for name in names:
        table = table.get(name) if isinstance(table, dict) else None
    return table


def _restore(table: Any, names: Sequence[str]) -> None:
    for name in names if isinstance(table, dict) else ():
        value = table.get(name, 0.0)
        if value is None:
            table[name] = _INFINITY
        elif isinstance(value, list) and len(value) == 2 and all(isinstance(side, list) for side in value):
            table[name] = [_filled(value[0], -_INFINITY), _filled(value[1], _INFINITY)]
        elif isinstance(value, list):
            table[name] = _filled(value, _INFINITY)


def _restore_pairs(table: Any, names: Sequence[str]) -> None:
    for name in names if isinstance(table, dict) else ():
        if name in table:
            table[name] = _pair(table[name])


def _pair(value: Any) -> Any:
    """Return lower and upper with infinities in place of ``null``."""
    if isinstance(value, list) and len(value) == 2:
        return [*_filled(value[:1], -_INFINITY), *_filled(value[1:], _INFINITY)]
    return value


def _filled(values: list[Any], infinity: float) -> list[Any]:
    return [infinity if value is None else value for value in values]
