"""The pictures of a motion: its quantities against their limits, its tool path, its power."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.audit.measures import measure_limit
from ocp_traj.exceptions import InputError
from ocp_traj.pictures.picture import LIMIT, Line, Panel, Picture
from ocp_traj.quantities import DERIVATIVES, JOINT_LIMITS
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

SAMPLES = 300


def sample_times(trajectory: Trajectory, count: int = SAMPLES) -> Array:
    """Return at least `count` times that include both sides of every breakpoint."""
    even = np.linspace(trajectory.breakpoints[0], trajectory.breakpoints[-1], count)
    inner = trajectory.breakpoints[1:-1]
    before = inner - 1e-9 * max(trajectory.duration, 1e-9)
    return np.unique(np.concatenate([even, inner, before]))


def motion_picture(task: TrajectoryTask, trajectory: Trajectory, relative: bool = False) -> Picture:
    """Return position, velocity, acceleration, jerk and torque of every joint over time, with limits dashed.

    Parameters
    ----------
    task
        Limits, and the robot for torques.
    trajectory
        The motion.
    relative
        Show every value as a share of its joint's limit (positions: -1 and 1 are the ends of the range).
    """
    t = sample_times(trajectory)
    panels = []
    for name in (*DERIVATIVES, "torque", *task.limits.others):
        values = _values(task, trajectory, name, t)
        if values is None:
            continue
        limits = sample_limits(task, trajectory, name, t)
        if relative and np.isfinite(limits).all():
            panels.append(_relative_panel(name, t, values, limits))
        else:
            panels.append(_plain_panel(name, JOINT_LIMITS[name].symbol, t, values, limits))
    caption = (
        "Shares of the limits: a line that touches the dashed ±1 uses its limit fully; quantities without "
        "limits are in their units."
        if relative
        else "Limits are dashed in the colour of their joint."
    )
    name = "limits" if relative else "motion"
    return Picture(name, "Motion against its limits", caption, tuple(panels), columns=2)


def _values(task: TrajectoryTask, trajectory: Trajectory, name: str, t: Array) -> Array | None:
    if name == "torque":
        if not task.has_inertia or task.robot is None:
            return None
        return task.robot.torque(*(trajectory(t, derivative) for derivative in range(3)))
    if name not in DERIVATIVES:
        return measure_limit(task, trajectory, name, t)
    return trajectory(t, DERIVATIVES.index(name))


def sample_limits(task: TrajectoryTask, trajectory: Trajectory, name: str, t: Array) -> Array:
    """Return the limits of a quantity at times (N, 2, n); they may differ between gaps.

    A motion that does not tell when it passes the waypoints is held against the tightest of all gaps.
    """
    limits = task.limits.get(name)
    if len(trajectory.waypoint_times) != len(task.waypoints):
        tightest = np.stack([limits[:, 0].max(axis=0), limits[:, 1].min(axis=0)])
        return np.broadcast_to(tightest, (t.size, *tightest.shape))
    gap = trajectory.gap_at(t)
    return np.asarray(limits[gap])


def _relative_panel(name: str, t: Array, values: Array, limits: Array) -> Panel:
    lower, upper = limits[:, 0], limits[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        if name == "position":
            shares = (2 * values - lower - upper) / (upper - lower)
        else:
            shares = np.where(values >= 0, values / upper, -values / lower)
    lines = _joint_lines(t, np.nan_to_num(shares))
    lines += [Line(t[[0, -1]], np.full(2, side), "limit", LIMIT, dashed=True) for side in (-1.0, 1.0)]
    return Panel(name.capitalize(), "time (s)", "share of the limit", tuple(lines), y_range=(-1.15, 1.15))


def _plain_panel(name: str, unit: str, t: Array, values: Array, limits: Array) -> Panel:
    lines = _joint_lines(t, values)
    reach = 1.5 * np.abs(values).max(axis=0)
    for joint in range(values.shape[1]):
        for side in range(2):
            bound = limits[:, side, joint]
            if np.isfinite(bound).all() and np.abs(bound).max() <= reach[joint]:
                lines.append(Line(t, bound, "", joint, dashed=True))
    return Panel(name.capitalize(), "time (s)", f"{name} ({unit})", tuple(lines))


def _joint_lines(t: Array, values: Array) -> list[Line]:
    return [Line(t, values[:, joint], f"joint {joint + 1}", joint) for joint in range(values.shape[1])]


def tool_path(task: TrajectoryTask, trajectory: Trajectory, t: Array) -> Array:
    """Return the tool's positions in the base frame (N, 3), m.

    Raises
    ------
    InputError
        The task has no robot.
    """
    if task.robot is None:
        raise InputError(f"case {task.name} has no robot, so there is no tool path")
    return np.array([task.robot.pose(q)[:3, 3] for q in trajectory(t)])


def path_length(points: Array) -> float:
    """Return the length of a polyline (N, 3), m."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def path_picture(task: TrajectoryTask, trajectory: Trajectory) -> Picture:
    """Return the tool's x, y, z over time and its path seen from above and from the side."""
    t = sample_times(trajectory)
    points = tool_path(task, trajectory, t)
    waypoints = tool_path(task, trajectory, np.asarray(trajectory.waypoint_times))
    over_time = Panel(
        "Tool position",
        "time (s)",
        "position (m)",
        tuple(Line(t, points[:, axis], "xyz"[axis], axis) for axis in range(3)),
    )
    views = tuple(
        Panel(
            title,
            f"{'xyz'[across]} (m)",
            f"{'xyz'[up]} (m)",
            (
                Line(waypoints[:, across], waypoints[:, up], "waypoints, joined", LIMIT, dashed=True),
                Line(points[:, across], points[:, up], "tool path", 5),
            ),
            equal=True,
        )
        for title, across, up in (("From above", 0, 1), ("From the front", 0, 2), ("From the side", 1, 2))
    )
    caption = f"The tool travels {path_length(points):.4f} m in the base frame."
    return Picture("path", "Tool path", caption, (over_time, *views), columns=2)


def power_picture(task: TrajectoryTask, trajectory: Trajectory) -> Picture:
    """Return the mechanical power of every joint, and the energy spent, over time."""
    t = sample_times(trajectory, 2 * SAMPLES)
    torque = _values(task, trajectory, "torque", t)
    if torque is None:
        raise InputError(f"case {task.name} has no robot with inertia, so there is no power")
    power = torque * trajectory(t, 1)
    total = np.abs(power).sum(axis=1)
    spent = np.concatenate([[0.0], np.cumsum((total[1:] + total[:-1]) / 2 * np.diff(t))])
    panels = (
        Panel("Power", "time (s)", "torque × velocity (W)", tuple(_joint_lines(t, power))),
        Panel("Energy", "time (s)", "∫ Σ|power| dt (J)", (Line(t, spent, "all joints", 8),)),
    )
    caption = f"Peak of Σ|power| {total.max():.4g} W, energy {spent[-1]:.4g} J (from these samples)."
    return Picture("power", "Power and energy", caption, panels, columns=2)


MOTION_PICTURES: dict[str, Callable[[TrajectoryTask, Trajectory], Picture]] = {
    "motion": motion_picture,
    "limits": lambda task, trajectory: motion_picture(task, trajectory, relative=True),
    "path": path_picture,
    "power": power_picture,
}
"""Pictures of one motion, by name."""
