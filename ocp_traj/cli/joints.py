"""Joints by name with the numbers of their limits, and where each comes from: for ``check`` and ``list joints``."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.quantities import JOINT_LIMITS

if TYPE_CHECKING:
    from ocp_traj.arrays import Array
    from ocp_traj.robot import Robot
    from ocp_traj.task import TrajectoryTask

_ENDINGS = (".urdf", ".xacro", ".xml")

NOT_GIVEN = "not given"
LEFT_OUT = "left out"


def is_description(name: str) -> bool:
    """Return whether an argument names a robot description rather than a case."""
    return Path(name).suffix.lower() in _ENDINGS


def robot_joints(robot: Robot) -> dict[str, Any]:
    """Return the joints of a robot and the limits of its description, as JSON values."""
    values = {
        name: getattr(robot, f"{name}_limits")[None] for name, row in JOINT_LIMITS.items() if row.from_robot
    }
    return {"schema": 1, **_rows(robot.n, robot, values, ()), **_stance(robot)}


def case_joints(task: TrajectoryTask, named: Collection[str]) -> dict[str, Any]:
    """Return the joints of a task and their limits, as JSON values.

    Parameters
    ----------
    task : TrajectoryTask
    named : collection of str
        Limits that the case file gives for all gaps.
    """
    values = {name: np.asarray(task.limits.get(name)) for name in task.limits.names}
    rows = _rows(task.n, task.robot, values, named)
    return {"schema": 1, "case": task.name, **rows, **(_stance(task.robot) if task.robot is not None else {})}


def _rows(n: int, robot: Robot | None, values: dict[str, Array], named: Collection[str]) -> dict[str, Any]:
    joints = []
    for index in range(n):
        kind = "" if robot is None else robot.joint_types[index]
        limits = {
            name: _limit(name, kind, value[:, :, index], _own(robot, name, index), name in named)
            for name, value in values.items()
        }
        joints.append(
            {
                "number": index + 1,
                "name": None if robot is None else robot.joint_names[index],
                "type": kind or None,
                "limits": limits,
            }
        )
    return {"robot": None if robot is None else robot.name, "joints": joints}


def _own(robot: Robot | None, name: str, index: int) -> Array | None:
    """Return the robot's own limit (2,) of a joint."""
    if robot is None or not JOINT_LIMITS[name].from_robot:
        return None
    return getattr(robot, f"{name}_limits")[:, index]


def _limit(name: str, kind: str, values: Array, own: Array | None, named: bool) -> dict[str, Any]:
    """Return one limit of one joint, (G, 2) over the gaps; no limit is null."""
    row = JOINT_LIMITS[name]
    lower, upper = float(values[:, 0].min()), float(values[:, 1].max())
    if named:
        source = "case"
    elif not np.isfinite(values).any():
        source = NOT_GIVEN if own is None or not np.isfinite(own).any() else LEFT_OUT
    else:
        source = "robot" if own is not None and (values == own).all() else "case"
    entry: dict[str, Any] = {
        "lower": _finite(lower),
        "upper": _finite(upper),
        "unit": row.prismatic_unit if kind == "prismatic" and row.prismatic_unit else row.unit,
        "from": source,
    }
    if (values != values[0]).any():
        entry["by_gap"] = [[_finite(low), _finite(high)] for low, high in values.tolist()]
    return entry


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _stance(robot: Robot) -> dict[str, Any]:
    held = {} if robot.source is None else dict(robot.source.lock)
    follow = {
        name: {"joint": driver, "multiplier": multiplier, "offset": offset}
        for name, (driver, multiplier, offset) in robot.followers.items()
    }
    return {"tool": robot.tool, "base": robot.base, "held": held, "follow": follow}


def joint_lines(found: dict[str, Any]) -> Iterator[str]:
    """Yield what `robot_joints` or `case_joints` found in words, one line per joint and one per further fact."""
    for joint in found["joints"]:
        kind = f" ({joint['type']})" if joint["type"] else ""
        limits = ", ".join(f"{name.replace('_', ' ')} {_in_words(limit)}" for name, limit in joint["limits"].items())
        yield f"{joint['number']} {joint['name'] or 'joint'}{kind}: {limits}"
    if "tool" not in found:
        return
    if found["held"]:
        yield "held still: " + ", ".join(f"{name} at {value:.6g}" for name, value in found["held"].items())
    for name, rule in found["follow"].items():
        yield f"{name} follows {rule['joint']}: {rule['multiplier']:g} times its position, plus {rule['offset']:g}"
    yield f"tool {found['tool']}, base {found['base']}"


def _in_words(limit: dict[str, Any]) -> str:
    lower, upper, source = limit["lower"], limit["upper"], limit["from"]
    if source in (NOT_GIVEN, LEFT_OUT):
        return source
    if lower is None and upper is None:
        return f"none ({source})"
    ends = ["-inf" if lower is None else f"{lower:.6g}", "inf" if upper is None else f"{upper:.6g}"]
    numbers = f"±{upper:.6g}" if lower is not None and upper == -lower else " to ".join(ends)
    varies = ", differs between gaps" if "by_gap" in limit else ""
    return f"{numbers} {limit['unit']} ({source}{varies})"


def hints(task: TrajectoryTask) -> Iterator[str]:
    """Yield what a person may not expect: efforts that limit nothing, and long ways of continuous joints."""
    robot = task.robot
    if robot is None:
        return
    if not robot.has_inertia and np.isfinite(robot.torque_limits).any() and not task.limited("torque"):
        names = ", ".join(robot.massless_joints)
        yield f"torque limits of the robot are left out: {names} move no mass, so torques are not known"
    steps = np.diff(task.waypoints, axis=0)
    for index in range(task.n):
        if robot.joint_types[index] == "continuous":
            yield from _long_ways(robot.joint_names[index], steps[:, index])


def _long_ways(name: str, steps: Array) -> Iterator[str]:
    for gap, step in enumerate(steps):
        if abs(step) > np.pi * (1.0 + 1e-9):
            short = step - 2.0 * np.pi * np.round(step / (2.0 * np.pi))
            yield (
                f"{name} is continuous and goes {step:.4g} rad from waypoint {gap + 1} to {gap + 2}; the short way "
                f'is {short:.4g} rad: waypoints.continuous = "short"'
            )
