"""From the tables of a case file to a trajectory task; every key, unit and shape is checked on the way."""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.case.collision import read_collision
from ocp_traj.case.limits import read_limits
from ocp_traj.case.robots import MAX_JOINTS, limited_to, read_motor, read_robot, short_way
from ocp_traj.case.section import Section
from ocp_traj.case.units import joint_factors
from ocp_traj.exceptions import CaseError, InputError, TaskError
from ocp_traj.quantities import COSTS, RATES
from ocp_traj.spline import FAMILIES
from ocp_traj.task import Boundary, Limits, Objective, Search, TrajectoryTask

if TYPE_CHECKING:
    from ocp_traj.robot import Robot

TABLES = (
    "schema",
    "name",
    "title",
    "source",
    "robot",
    "waypoints",
    "limits",
    "spline",
    "boundary",
    "objective",
    "search",
    "collision",
)
"""Keys at the top of a case file."""

MAX_WAYPOINTS = 10_000
"""Largest number of waypoints of a case."""

MAX_VIRTUAL_KNOTS = 1000
"""Largest number of virtual knots in a gap."""

MAX_SEGMENTS = 100_000
"""Largest number of polynomial segments of a case."""

MAX_POSITION = 1e9
"""Largest waypoint coordinate, rad or m: differences and their powers stay finite."""

_NAME = re.compile(r"[A-Za-z0-9_-]{1,100}")


def task_from_tables(
    tables: dict[str, Any], file: str, folder: Path, trusted: Collection[str] = ()
) -> TrajectoryTask:
    """Return the task that the tables of a case file state.

    Parameters
    ----------
    tables : dict
        As TOML gives them.
    file : str
        The file as the caller named it, for messages.
    folder : pathlib.Path
        Where the file lies; paths in it are relative to this.
    trusted : collection of str
        Dotted keys the caller set by hand: their paths may leave the folder.

    Raises
    ------
    CaseError
        Something is unknown, missing, of the wrong type, shape or unit, or impossible.
    """
    case = Section(file, "", tables)
    case.check_keys(TABLES)
    if case.integer("schema", None, 10**6) != 1:
        raise case.error("schema", f"{tables['schema']} given, this version reads schema 1")
    name = case.text("name")
    if not _NAME.fullmatch(name):
        raise case.error("name", f"{name[:60]!r} given, expected 1 to 100 letters, digits, - and _")
    robot = read_robot(case.section("robot"), folder, trusted) if "robot" in case else None
    try:
        return TrajectoryTask(
            robot=robot,
            name=name,
            title=case.text("title", ""),
            source=case.text("source", ""),
            **_problem(case, robot, folder, trusted),
        )
    except TaskError as error:
        raise CaseError(file, error.key, error.problem) from error


def _problem(case: Section, robot: Robot | None, folder: Path, trusted: Collection[str]) -> dict[str, Any]:
    section = case.section("waypoints")
    section.check_keys(("unit", "joints", "poses", "start", "weights", "tolerance", "continuous"))
    count, n = _size(section, robot)
    limits = read_limits(case.section("limits"), count - 1, n, robot, folder, trusted)
    spline = case.section("spline")
    spline.check_keys(("family", "virtual_knots"))
    family = spline.choice("family", tuple(FAMILIES), "cubic")
    knots = spline.integer("virtual_knots", FAMILIES[family].default_virtual_knots, MAX_VIRTUAL_KNOTS)
    if (count - 1) * (knots + 1) > MAX_SEGMENTS:
        raise spline.error(
            "virtual_knots", f"{knots} in each of {count - 1} gaps make more than {MAX_SEGMENTS} segments"
        )
    return {
        "waypoints": _waypoints(section, robot, limits, n),
        "tolerance": _tolerance(section, robot, count, n),
        "limits": limits,
        "family": family,
        "virtual_knots": knots,
        "boundary": _boundary(case.section("boundary"), n, robot),
        "objective": _objective(case, count - 1, n),
        "search": _search(case.section("search")),
        "collision": read_collision(case, count - 1, folder, trusted),
    }


def _size(section: Section, robot: Robot | None) -> tuple[int, int]:
    """Return the number of waypoints and of joints, K and n."""
    given = [name for name in ("joints", "poses") if name in section]
    if len(given) != 1:
        raise section.error(
            "", f"{' and '.join(given) or 'neither joints nor poses'} given, expected joints or poses"
        )
    shape = section.array(given[0], finite=True).shape
    if len(shape) != 2:
        raise section.error(given[0], "expected one row of numbers a waypoint")
    count, width = shape
    if not 2 <= count <= MAX_WAYPOINTS:
        raise section.error(
            given[0], f"{count} waypoint{'s' if count > 1 else ''} given, expected 2 to {MAX_WAYPOINTS}"
        )
    if given == ["poses"]:
        if robot is None:
            raise section.error("poses", "need a robot, but the case has no [robot]")
        if width != 7:
            raise section.error("poses", f"rows have {width} numbers, expected 7: x, y, z, qx, qy, qz, qw")
        return count, robot.n
    if robot is not None and width != robot.n:
        raise section.error("joints", robot.row_problem(width))
    if not 1 <= width <= MAX_JOINTS:
        raise section.error("joints", f"rows have {width} numbers, expected 1 to {MAX_JOINTS}")
    return count, width


def _waypoints(section: Section, robot: Robot | None, limits: Limits, n: int) -> Array:
    if "joints" in section:
        for name in ("start", "weights"):
            if name in section:
                raise section.error(name, "belongs to poses, but joints are given")
        waypoints = section.array("joints") * joint_factors(section, n, robot)
        if np.abs(waypoints).max() > MAX_POSITION:
            raise section.error("joints", f"a coordinate is beyond {MAX_POSITION:g} rad or m")
        if section.choice("continuous", ("as-given", "short"), "as-given") == "short":
            return short_way(section, robot, waypoints)
        return waypoints
    assert robot is not None  # _size refuses poses without a robot
    return _waypoints_from_poses(section, robot, limits, n)


def _waypoints_from_poses(section: Section, robot: Robot, limits: Limits, n: int) -> Array:
    from ocp_traj.robot.inverse_kinematics import solve_poses

    if "continuous" in section:
        raise section.error("continuous", "belongs to joints, but poses are given: they take the nearest turn")
    if "unit" in section:
        raise section.error("unit", "belongs to joints, but poses are given (m, and unit quaternions)")
    poses = section.array("poses")
    if np.abs(poses[:, :3]).max() > MAX_POSITION:
        raise section.error("poses", f"a coordinate is beyond {MAX_POSITION:g} m")
    start = section.array_of_shape("start", (n,))
    weights = section.array_of_shape("weights", (n,)) if "weights" in section else np.ones(n)
    if not (weights > 0).all():
        raise section.error("weights", f"{weights.min():g} given, expected positive numbers")
    if limits.position is not None:
        position = np.asarray(limits.position)
        robot = limited_to(robot, np.stack([position[:, 0].min(axis=0), position[:, 1].max(axis=0)]))
    try:
        return np.asarray(solve_poses(robot, poses, start, weights))
    except TaskError:
        raise
    except InputError as error:
        raise section.error("poses", str(error)) from error


def _tolerance(section: Section, robot: Robot | None, count: int, n: int) -> Array:
    if "tolerance" not in section:
        return np.zeros(())
    tolerance = section.array_of_shape("tolerance", (), (n,), (count, n))
    if (tolerance < 0).any():
        raise section.error("tolerance", f"{tolerance.min():g} given, expected numbers of 0 or more")
    return tolerance * joint_factors(section, n, robot)


def _boundary(section: Section, n: int, robot: Robot | None) -> Boundary:
    section.check_keys((*RATES, "unit"))
    factors = joint_factors(section, n, robot)
    words: dict[str, float | None] = {"zero": 0.0, "free": None}
    values: dict[str, Any] = {}
    for name in RATES:
        if name not in section:
            continue
        given = section.data[name]
        if isinstance(given, str):
            options = ("zero",) if name == "velocity" else ("zero", "free")
            if given not in options:
                expected = " or ".join(repr(option) for option in options)
                raise section.error(
                    name, f"{given[:60]!r} given, expected {expected} or two rows (start, end) of {n} numbers"
                )
            values[name] = words[given]
        else:
            values[name] = section.array_of_shape(name, (2, n)) * factors
    return Boundary(**values)


def _objective(case: Section, gaps: int, n: int) -> Objective:
    section = case.section("objective")
    section.check_keys((*COSTS, "bounds"))
    weights = {name: section.number(name) for name in COSTS if name in section}
    for name, weight in weights.items():
        if weight < 0:
            raise section.error(name, f"{weight:g} given, expected a weight of 0 or more")
    values: dict[str, Any] = {}
    bounds = section.section("bounds")
    bounds.check_keys(("duration", "gap_durations"))
    if "duration" in bounds:
        values["duration"] = bounds.array_of_shape("duration", (2,), finite=False)
    if "gap_durations" in bounds:
        values["gap_durations"] = bounds.array_of_shape("gap_durations", (gaps, 2), finite=False)
    return Objective(**values, motor=read_motor(case.section("robot"), n)).with_weights(weights)


def _search(section: Section) -> Search:
    section.check_keys(("duration", "offset", "protocol"))
    values: dict[str, Any] = {}
    if "duration" in section:
        values["duration"] = section.array_of_shape("duration", (2,))
    if "offset" in section:
        values["offset"] = section.number("offset")
    if "protocol" in section:
        values["protocol"] = section.choice("protocol", ("shared", "per-joint"))
    return Search(**values)
