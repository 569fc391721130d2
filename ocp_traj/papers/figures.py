"""The papers' figures: convergence, motions against limits, tool paths."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.papers.records import Records
from ocp_traj.quantities import DERIVATIVES, JOINT_LIMITS

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

LEAST_SHOWN = 1e-3
"""Distances from the best below this, %, are drawn here."""


def _save(figure: Any, path: Path) -> str:
    import matplotlib.pyplot as plt

    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=72)
    plt.close(figure)
    return path.name


def _figure(rows: int, columns: int, width: float, height: float) -> Any:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt.subplots(rows, columns, figsize=(width, height), layout="constrained", squeeze=False)


def convergence_figure(
    records: Records, labels: list[str], group: str, path: Path, title: str, unit: str
) -> str:
    """Draw the median distance of the best feasible cost from the best of all runs, with quartile bands.

    Both axes are logarithmic: on plain ones the first generation hides all that follows.
    """
    runs = {
        label: [row["history"] for row in records.runs(label, group) if len(row["history"]["cost"]) > 1]
        for label in labels
    }
    runs = {label: histories for label, histories in runs.items() if histories}
    last = max(entry["evaluations"][-1] for histories in runs.values() for entry in histories)
    curves = {}
    for label, histories in runs.items():
        grid = np.geomspace(max(histories[0]["evaluations"][0], 1), last, 300)
        curves[label] = grid, np.stack([_course(entry, grid, "evaluations") for entry in histories])
    best = min(float(np.nanmin(values, initial=np.inf)) for _, values in curves.values())
    figure, axes = _figure(1, 1, 7, 4)
    axis = axes[0, 0]
    for label, (grid, values) in curves.items():
        above = np.full_like(values, np.inf) if np.isinf(best) else 100.0 * (values / best - 1.0)
        _band(axis, grid, np.maximum(above, LEAST_SHOWN), label)
    axis.set(xlabel="evaluations", ylabel=f"above the best of all runs ({best:.4g} {unit}), %", title=title)
    if np.isinf(best):  # a logarithmic axis cannot be drawn without a number on it
        axis.set(ylabel="no run is feasible")
    else:
        axis.set(xscale="log", yscale="log")
    axis.grid(alpha=0.3)
    axis.legend()
    return _save(figure, path)


def _band(axis: Any, grid: Any, curves: Any, label: str) -> None:
    """Draw median and quartiles of curves (S, N) where they are finite; the line starts where half of them are."""
    low, middle, high = np.quantile(curves, [0.25, 0.5, 0.75], axis=0, method="inverted_cdf")
    shown = np.isfinite(middle)
    (line,) = axis.plot(
        grid[shown],
        middle[shown],
        label=label if shown.any() else f"{label}: feasible in less than half of the runs",
    )
    inside = shown & np.isfinite(high)
    axis.fill_between(grid[inside], low[inside], high[inside], alpha=0.15, color=line.get_color())


def _course(history: dict[str, Any], grid: Any, along: str) -> Any:
    """Return the best feasible cost at every point of the grid, infinite before there is one."""
    at = np.array(history[along], dtype=float)
    cost = np.array([np.inf if value is None else value for value in history["cost"]], dtype=float)
    violation = np.array([np.inf if value is None else value for value in history["violation"]], dtype=float)
    cost = np.where(violation > 1e-9, np.inf, cost)
    index = np.searchsorted(at, grid, side="right") - 1
    return np.where(index >= 0, cost[np.clip(index, 0, len(at) - 1)], np.inf)


def motion_figure(task: TrajectoryTask, motions: dict[str, Trajectory], path: Path, title: str) -> str:
    """Draw q, v, a and jerk of every joint, a row a quantity and a column a motion, with broken limits in black."""
    alone = len(motions) == 1
    figure, axes = _figure(2, 2, 9, 6) if alone else _figure(4, len(motions), 4.2 * len(motions), 8)
    axes = axes.reshape(4, -1)
    for column, (name, motion) in enumerate(motions.items()):
        t = np.linspace(0, motion.duration, 700)
        for row, quantity in enumerate(DERIVATIVES):
            axis = axes[row, column]
            values = motion(t, row)
            limits = task.limits.get(quantity)[0]
            for joint in range(task.n):
                axis.plot(t, values[:, joint], lw=1, label=f"joint {joint + 1}")
                room = 1e-6 * (1 + np.abs(limits[:, joint]))
                over = (values[:, joint] > limits[1, joint] + room[1]) | (
                    values[:, joint] < limits[0, joint] - room[0]
                )
                axis.plot(t[over], values[over, joint], ".", ms=3, color="black")
            axis.grid(alpha=0.3)
            if column == 0:
                axis.set_ylabel(f"{quantity}, {JOINT_LIMITS[quantity].symbol}")
        axes[0, column].set_title(name, fontsize=10)
        for row in (2, 3) if alone else (3,):
            axes[row, column].set_xlabel("time, s")
    axes[0, 0].legend(fontsize=7, ncols=2)
    figure.suptitle(f"{title} (black: over a limit)")
    return _save(figure, path)


def tool_path_figure(task: TrajectoryTask, motion: Trajectory, path: Path, title: str) -> tuple[str, float]:
    """Draw the tool's path in space and x, y, z over time; return the file name and the path's length, m."""
    robot = task.robot
    assert robot is not None
    t = np.linspace(0, motion.duration, 400)
    points = np.stack([robot.pose(q)[:3, 3] for q in motion(t)])
    marks = np.stack([robot.pose(q)[:3, 3] for q in task.waypoints])
    figure, axes = _figure(1, 2, 9, 4)
    axes[0, 0].remove()
    space = figure.add_subplot(1, 2, 1, projection="3d")
    space.plot(*points.T, lw=1.5)
    space.plot(*marks.T, "o", ms=4, color="black")
    space.locator_params(nbins=4)
    space.set(xlabel="x, m", ylabel="y, m", zlabel="z, m", title="path of the tool")
    for column, name in enumerate("xyz"):
        axes[0, 1].plot(t, points[:, column], label=name)
    axes[0, 1].set(xlabel="time, s", ylabel="position, m")
    axes[0, 1].grid(alpha=0.3)
    axes[0, 1].legend()
    figure.suptitle(title)
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    return _save(figure, path), length


def joints_figure(
    records: Records, labels: list[str], group: str, joints: tuple[int, ...], path: Path, title: str
) -> str:
    """Draw the convergence of joints optimised alone, a panel a joint: median over seeds and quartiles."""
    columns = 3 if len(joints) > 2 else len(joints)
    rows = -(-len(joints) // columns)
    figure, axes = _figure(rows, columns, 3.6 * columns, 2.9 * rows)
    for axis in axes.ravel()[len(joints) :]:
        axis.remove()
    for axis, joint in zip(axes.ravel(), joints, strict=False):
        for label in labels:
            parts = [
                part["history"]
                for row in records.runs(label, group)
                for part in row["parts"]
                if part["joint"] == joint
            ]
            if parts:
                grid = np.arange(parts[0]["generation"][-1] + 1)
                curves = np.stack([_course(part, grid, "generation") for part in parts])
                _band(axis, grid, curves, label)
        axis.set(
            xlabel="generation", ylabel="best feasible total, s", title=f"joint {joint}", xscale="symlog"
        )
        axis.grid(alpha=0.3)
    axes[0, 0].legend(fontsize=8)
    figure.suptitle(title)
    return _save(figure, path)


def segments_figure(part: dict[str, Any], path: Path, title: str) -> str:
    """Draw the three durations of the best candidate of one joint over the generations of one run."""
    history = part["history"]
    durations = np.array(history["x"])
    curves = {f"segment {gap + 1}": durations[:, gap] for gap in range(durations.shape[1])}
    return lines_figure(path, np.array(history["generation"]), curves, "generation", "duration, s", title)


def lines_figure(
    path: Path, x: Any, curves: dict[str, Any], xlabel: str, ylabel: str, title: str, kind: str = "line"
) -> str:
    """Draw a few named curves or bars."""
    figure, axes = _figure(1, 1, 6.5, 3.6)
    axis = axes[0, 0]
    width = (x[1] - x[0]) / (len(curves) + 1) if len(x) > 1 else 1.0
    for index, (name, values) in enumerate(curves.items()):
        if kind == "bars":
            axis.bar(np.asarray(x) + index * width, values, width, label=name)
        else:
            axis.plot(x, values, ".-" if len(x) < 30 else "-", label=name)
    axis.set(xlabel=xlabel, ylabel=ylabel, title=title)
    axis.grid(alpha=0.3)
    axis.legend()
    return _save(figure, path)


def best_motion(task: TrajectoryTask, rows: list[dict[str, Any]], field: str) -> Trajectory | None:
    """Rebuild the best (feasible first) run's motion from its gap durations (families without virtual knots)."""
    from ocp_traj.transcription import trajectory_from_durations

    usable = [row for row in rows if row["segments"] and row[field] is not None]
    if not usable:
        return None
    best = min(usable, key=lambda row: (not row["feasible"], row[field]))
    return trajectory_from_durations(task, best["segments"])
