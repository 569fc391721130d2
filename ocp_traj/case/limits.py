"""The ``[limits]`` table of a case file, with exceptions for single gaps between waypoints."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.case.robots import resolve_inside, robot_errors
from ocp_traj.case.section import Section
from ocp_traj.case.units import joint_factors
from ocp_traj.quantities import FRAME_LIMITS, JOINT_LIMITS
from ocp_traj.task.limits import Limits, default_limits, symmetric

if TYPE_CHECKING:
    from ocp_traj.robot import Robot


def read_limits(
    section: Section, gaps: int, n: int, robot: Robot | None, folder: Path, trusted: Collection[str]
) -> Limits:
    """Return the limits of a ``[limits]`` table in SI, each a (gaps, 2, n) array or None where left out.

    Raises
    ------
    CaseError
        A key is unknown, a shape, unit or sign is wrong, a gap or frame does not exist.
    """
    section.check_keys((*JOINT_LIMITS, *FRAME_LIMITS, "unit", "gaps", "moveit"))
    factors = joint_factors(section, n, robot)
    common = _from_moveit(section, robot, folder, trusted)
    common.update(_entries(section, factors, n))
    limits: dict[str, Array] = {}
    for name, value in common.items():
        limits[name] = np.tile(value, (gaps, 1, 1))
    seen: set[int] = set()
    for entry in section.sections("gaps"):
        entry.check_keys(("gap", *JOINT_LIMITS))
        gap = entry.integer("gap", None, gaps)
        if gap < 1 or gap in seen:
            raise entry.error("gap", f"{gap} given, expected each of 1 to {gaps} at most once")
        seen.add(gap)
        for name, value in _entries(entry, factors, n).items():
            if name not in limits:
                limits[name] = np.tile(default_limits(name, n, robot), (gaps, 1, 1))
            limits[name][gap - 1] = value
    return Limits(cartesian_speed=_cartesian_speeds(section, robot)).with_values(limits)


def _entries(section: Section, factors: Array, n: int) -> dict[str, Array]:
    """Return the limits given in one table as (2, n) arrays in SI."""
    entries: dict[str, Array] = {}
    for name, quantity in JOINT_LIMITS.items():
        if name not in section:
            continue
        value = section.array_of_shape(name, (), (n,), (2, n), finite=False)
        if value.ndim < 2:
            if (value < 0).any():
                raise section.error(name, f"{value.min():g} given, expected a limit of 0 or more")
            value = symmetric(value, n)
        entries[name] = value * factors if "rad" in quantity.unit else value
        _check_sides(section, name, value)
    return entries


def _check_sides(section: Section, name: str, value: Array) -> None:
    lower, upper = value
    if (lower > upper).any():
        joint = int(np.argmax(lower > upper))
        raise section.error(
            name,
            f"the lower limit of joint {joint + 1}, {lower[joint]:g}, is above its upper, {upper[joint]:g}",
        )
    if (np.isposinf(lower) | np.isneginf(upper)).any():
        raise section.error(
            name, "a lower limit of inf or an upper one of -inf leaves nothing; expected -inf or inf"
        )


def _cartesian_speeds(section: Section, robot: Robot | None) -> tuple[tuple[str, float], ...]:
    speeds = []
    for entry in section.sections("cartesian_speed"):
        entry.check_keys(("frame", "speed"))
        frame, speed = entry.text("frame"), entry.number("speed")
        if speed <= 0:
            raise entry.error("speed", f"{speed:g} given, expected a positive speed, m/s")
        if robot is None:
            raise entry.error("frame", "needs a robot, but the case has no [robot]")
        with robot_errors(entry, "frame"):
            robot.pose(np.zeros(robot.n), frame)
        speeds.append((frame, speed))
    return tuple(speeds)


def _from_moveit(
    section: Section, robot: Robot | None, folder: Path, trusted: Collection[str]
) -> dict[str, Array]:
    """Return what a MoveIt ``joint_limits.yaml`` limits, (2, n) each; SI by definition."""
    if "moveit" not in section:
        return {}
    if robot is None:
        raise section.error("moveit", "names joints of a robot, but the case has no [robot]")
    from ocp_traj.robot import limits_from_moveit

    with robot_errors(section, "moveit"):
        return limits_from_moveit(resolve_inside(section, "moveit", folder, trusted), robot)
