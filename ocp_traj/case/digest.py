"""One hash for everything about a task that decides its answer."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.quantities import RATES
from ocp_traj.task import Objective, TrajectoryTask

if TYPE_CHECKING:
    from ocp_traj.collision import CollisionScene
    from ocp_traj.robot import Robot


def task_digest(task: TrajectoryTask) -> str:
    """Return a hash (64 hexadecimal digits) of the task's name and all that decides its answer.

    Title and source do not enter. Numbers enter with 12 significant digits, so the last bits of another
    platform's unit conversion or inverse kinematics do not change it.

    Parameters
    ----------
    task : TrajectoryTask
    """
    text = "\n".join(_parts(task))
    return hashlib.sha256(text.encode()).hexdigest()


def _parts(task: TrajectoryTask) -> Iterator[str]:
    yield "ocp-traj task 1"
    yield f"name {task.name}"
    yield f"robot {task.robot.digest() if task.robot is not None else 'none'}"
    yield f"spline {task.family} {task.virtual_knots}"
    yield from _numbers("waypoints", task.waypoints)
    yield from _numbers("tolerance", task.tolerance)
    for name in task.limits.names:
        yield from _numbers(name, task.limits.get(name))
    for frame, speed in task.limits.cartesian_speed:
        yield from _numbers(f"cartesian_speed {frame!r}", speed)
    for name in RATES:
        yield from _numbers(f"boundary {name}", getattr(task.boundary, name))
    yield from _objective_parts(task.objective)
    yield from _numbers("search duration", task.search.duration)
    yield from _numbers("search offset", task.search.offset)
    yield f"search protocol {task.search.protocol}"
    for constraint in task.constraints:
        yield f"constraint {constraint.name!r} {constraint.function.serialize()}"
        for name in ("lower", "upper", "scale"):
            yield from _numbers(name, getattr(constraint, name))
    if task.collision is not None and task.robot is not None:
        yield from _collision_parts(task.robot, task.collision)


def _collision_parts(robot: Robot, scene: CollisionScene) -> Iterator[str]:
    from ocp_traj.collision.digest import geometry_digest

    yield f"collision {geometry_digest(robot, scene)}"
    yield from _numbers("collision margins", (scene.margin, scene.self_margin, scene.cover, scene.with_itself))
    yield f"collision pairs {scene.pairs} {scene.ignore}"
    for contact in scene.contact:
        yield f"contact {contact.bodies} {contact.waypoint}"
        yield from _numbers("contact", (contact.within, contact.depth))


def _objective_parts(objective: Objective) -> Iterator[str]:
    for name in objective.names:
        yield from _numbers(f"objective {name}", objective.weight(name))
    for name in ("duration", "gap_durations"):
        yield from _numbers(f"objective {name}", getattr(objective, name))
    if objective.motor is not None:
        for name in ("torque_constant", "resistance", "gear_ratio"):
            yield from _numbers(f"motor {name}", getattr(objective.motor, name))
    for custom in objective.custom:
        yield f"custom {custom.name!r} {custom.function.serialize()}"
        yield from _numbers("weight", custom.weight)


def _numbers(label: str, values: Any) -> Iterator[str]:
    if values is None:
        yield f"{label} free"
        return
    array = np.asarray(values, dtype=np.float64)
    yield f"{label} {array.shape}"
    yield from (f"{value + 0.0:.11e}" for value in array.ravel())
