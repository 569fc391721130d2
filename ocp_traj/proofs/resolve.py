"""A task as the plain numbers that a proof is about, and a motion beside it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ocp_traj.exceptions import InputError
from ocp_traj.proofs.not_proved import NotProved
from ocp_traj.quantities import JOINT_LIMITS
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

SAME = 1e-9
"""Fraction of a motion's duration by which a waypoint time may be off its breakpoint before it is moved there."""


def hexadecimal(values: Any) -> Any:
    """Return numbers, in nested lists or arrays, as the strings of `float.hex`."""
    if isinstance(values, (list, tuple, np.ndarray)):
        return [hexadecimal(value) for value in values]
    return float(values).hex()


def resolve_task(task: TrajectoryTask) -> dict[str, Any]:
    """Return the section ``task`` of a proof: SI units, limits per gap and side, links as numbers.

    Parameters
    ----------
    task : TrajectoryTask

    Raises
    ------
    NotProved
        The task limits or weighs what no proof covers; names it.
    """
    reason = _reason_against(task)
    if reason:
        raise NotProved(reason)
    shape = (task.gaps, 2, task.n)
    boundary = {name: getattr(task.boundary, name) for name in ("velocity", "acceleration", "jerk")}
    dynamic = task.limited("torque") or task.limited("torque_rate") or task.objective.needs_torque
    return {
        "name": task.name,
        "waypoints": hexadecimal(task.waypoints),
        "tolerance": hexadecimal(np.broadcast_to(task.tolerance, task.waypoints.shape)),
        "limits": {
            name: hexadecimal(np.broadcast_to(task.limits.get(name), shape))
            for name in JOINT_LIMITS
            if task.limited(name)
        },
        "boundary": {key: None if value is None else hexadecimal(value) for key, value in boundary.items()},
        "duration": hexadecimal(task.objective.duration),
        "gap_durations": hexadecimal(task.objective.gap_durations),
        "weights": hexadecimal_values(task.objective.weights),
        "loss_factors": _loss_factors(task) if "motor_loss" in task.objective.weights else None,
        "robot": _robot(task) if dynamic else None,
    }


def hexadecimal_values(numbers: dict[str, float]) -> dict[str, str]:
    """Return a table of numbers with its values as hexadecimal strings."""
    return {name: float(value).hex() for name, value in numbers.items()}


def _reason_against(task: TrajectoryTask) -> str:
    """Return the first thing about a task that proofs do not cover, or an empty string."""
    if task.constraints:
        return f"the constraint {task.constraints[0].name!r} is a function of one's own, which no proof covers"
    if task.objective.custom:
        return f"the cost {task.objective.custom[0].name!r} is a function of one's own, which no proof covers"
    if task.needs_torque and task.robot is not None and task.robot.coupling is not None:
        return f"torques of {task.robot.name!r}, whose joints follow one another, are not covered by proofs yet"
    if task.limits.cartesian_speed:
        return f"the speed limit of frame {task.limits.cartesian_speed[0][0]!r} is not covered by proofs yet"
    return ""


def _loss_factors(task: TrajectoryTask) -> Any:
    """Return resistance over squared gear ratio times torque constant, one a joint, W/(N m)^2."""
    motor = task.objective.motor
    assert motor is not None  # the task was checked for it
    constant, resistance, ratio = (
        np.broadcast_to(np.asarray(value, dtype=np.float64), (task.n,))
        for value in (motor.torque_constant, motor.resistance, motor.gear_ratio)
    )
    return hexadecimal(resistance / (ratio * constant) ** 2)


def _robot(task: TrajectoryTask) -> dict[str, Any]:
    """Return links (payload included), gravity in root axes and friction."""
    robot = task.robot
    assert robot is not None  # a task that needs torques has one
    return {
        "links": [
            {
                "parent": link.parent + 1,
                "prismatic": bool(link.prismatic),
                "rotation": hexadecimal(link.rotation),
                "translation": hexadecimal(link.translation),
                "mass": hexadecimal(link.mass),
                "first": hexadecimal(link.first_moment),
                "second": hexadecimal(link.second_moment),
                "armature": hexadecimal(link.armature),
            }
            for link in robot.links
        ],
        "gravity": hexadecimal(robot.model.gravity.linear),
        "viscous": hexadecimal(robot.friction.viscous),
        "coulomb": hexadecimal(robot.friction.coulomb),
    }


def resolve_motion(task: TrajectoryTask, trajectory: Trajectory) -> dict[str, Any]:
    """Return the section ``motion`` of a proof; waypoint times a rounding away from a breakpoint are moved there.

    Parameters
    ----------
    task : TrajectoryTask
    trajectory : Trajectory
        With one waypoint time for each waypoint.

    Raises
    ------
    InputError
        Joints or waypoint times do not fit the task.
    """
    if trajectory.n != task.n:
        raise InputError(f"the trajectory has {trajectory.n} joints, expected {task.n}")
    times, count = trajectory.waypoint_times, len(task.waypoints)
    if len(times) != count:
        raise InputError(f"the trajectory passes {len(times)} waypoints, expected {count}")
    index = np.abs(trajectory.breakpoints[:, None] - times).argmin(axis=0)
    nearest = trajectory.breakpoints[index]
    if (np.abs(nearest - times) > SAME * trajectory.duration).any():
        where = int(np.argmax(np.abs(nearest - times)))
        raise InputError(f"waypoint {where + 1} is passed at {times[where]:.9g} s, which is no breakpoint")
    return {
        "schema": 1,
        "case": trajectory.case,
        "family": trajectory.family,
        "waypoint_times": hexadecimal(nearest),
        "breakpoints": hexadecimal(trajectory.breakpoints),
        "coefficients": hexadecimal(trajectory.coefficients),
    }


def is_about(document: dict[str, Any], task: TrajectoryTask, relative: float = 1e-12) -> bool:
    """Return whether a proof is about a task: every number the same but for the last bits.

    The last bits of unit conversions and link placements may differ between platforms.

    Parameters
    ----------
    document : dict
        The proof, as read.
    task : TrajectoryTask
    relative : float
        Largest relative difference of two numbers that are the same; also absolute below 1.
    """
    try:
        return _same(document.get("task"), resolve_task(task), relative)
    except NotProved:
        return False


def _same(given: Any, own: Any, relative: float) -> bool:
    if isinstance(own, dict):
        keys = isinstance(given, dict) and set(given) == set(own)
        return keys and all(_same(given[key], own[key], relative) for key in own)
    if isinstance(own, list):
        lengths = isinstance(given, list) and len(given) == len(own)
        return lengths and all(_same(a, b, relative) for a, b in zip(given, own))
    if given == own or not (isinstance(own, str) and isinstance(given, str)):
        return bool(given == own)
    try:
        a, b = float.fromhex(given), float.fromhex(own)
    except (ValueError, OverflowError):  # a name
        return False
    return math.isclose(a, b, rel_tol=relative, abs_tol=relative)
