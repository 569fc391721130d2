"""An independent check that a task has no motion: linear programmes over a grid, and travel at full speed."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from scipy.optimize import linprog

from ocp_traj.arrays import Array
from ocp_traj.task import TrajectoryTask

CELLS = 24
"""Cells of the grid per gap."""

PROPORTIONS = 60
"""Draws of how a bounded total is shared by the gaps, where a programme needs durations."""


def has_no_motion(task: TrajectoryTask) -> bool:
    """Return whether no motion of the joints exists, whatever the spline; for bounded totals by many draws."""
    if ends_are_outside(task) or cannot_turn(task) or full_speed_is_too_slow(task):
        return True
    bounds = np.asarray(task.objective.gap_durations)
    total = float(np.asarray(task.objective.duration)[1])
    if (bounds[:, 0] == bounds[:, 1]).all():
        return any(programme_is_empty(task, joint, bounds[:, 0]) for joint in range(task.n))
    if not np.isfinite(total):
        return False
    rng = np.random.default_rng(0)
    travel = np.abs(np.diff(task.waypoints, axis=0)) / np.maximum(np.ptp(task.waypoints, axis=0), 1e-300)
    for _ in range(PROPORTIONS):
        shares = np.sqrt(travel.max(axis=1) + 1e-6) * np.exp(0.5 * rng.standard_normal(task.gaps))
        durations = total * shares / shares.sum()
        if not any(programme_is_empty(task, joint, durations) for joint in range(task.n)):
            return False
    return True


def ends_are_outside(task: TrajectoryTask) -> bool:
    """Return whether an end velocity is beyond a limit, or a joint with a limit of zero has to move."""
    velocity = task.limits.get("velocity")
    given = np.asarray(task.boundary.velocity)
    for side, gap in ((0, 0), (1, task.gaps - 1)):
        if ((given[side] > velocity[gap, 1]) | (given[side] < velocity[gap, 0])).any():
            return True
    moved = np.diff(task.waypoints, axis=0)
    return bool(((moved > 0) & (velocity[:, 1] == 0) | (moved < 0) & (velocity[:, 0] == 0)).any())


def cannot_turn(task: TrajectoryTask) -> bool:
    """Return whether braking fully from an end's speed, step by step, still crosses a position limit."""
    acceleration, position = task.limits.get("acceleration"), task.limits.get("position")
    for joint in range(task.n):
        hardest = float(np.abs(acceleration[:, :, joint]).max())
        for side, order in ((0, 1), (1, -1)):
            v = order * float(np.asarray(task.boundary.velocity)[side, joint])
            q = float(task.waypoints[-side, joint])
            if not np.isfinite(hardest) or v == 0:
                continue
            t = np.linspace(0.0, abs(v) / hardest, 1000)
            path = q + v * t - np.sign(v) * 0.5 * hardest * t**2
            if path.max() > position[:, 1, joint].max() or path.min() < position[:, 0, joint].min():
                return True
    return False


def full_speed_is_too_slow(task: TrajectoryTask) -> bool:
    """Return whether the way at the velocity limits alone takes longer than the durations allow."""
    limit = np.abs(task.limits.get("velocity")).max(axis=1)
    slack = np.asarray(task.tolerance)
    least = np.maximum(np.abs(np.diff(task.waypoints, axis=0)) - slack[1:] - slack[:-1], 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.nan_to_num(least / limit).max(axis=1)
    bounds = np.asarray(task.objective.gap_durations)[:, 1]
    return bool((needed > bounds).any() or needed.sum() > np.asarray(task.objective.duration)[1])


def programme_is_empty(task: TrajectoryTask, joint: int, durations: Array) -> bool:
    """Return whether what every motion fulfils on a grid, given its durations, has no solution for one joint.

    Between two grid points v changes by at most A dt, and q - v dt by at most A dt^2 / 2, either way.
    """
    size = float(np.ptp(task.waypoints[:, joint])) or 1.0
    total = float(durations.sum())
    steps = np.repeat(durations / total / CELLS, CELLS)
    m = len(steps)
    acceleration = np.repeat(task.limits.get("acceleration")[:, :, joint], CELLS, axis=0) * total**2 / size
    velocity = np.repeat(task.limits.get("velocity")[:, :, joint], CELLS, axis=0) * total / size
    here, there = sparse.eye(m, m + 1, format="csr"), sparse.eye(m, m + 1, k=1, format="csr")
    none, dt = sparse.csr_matrix((m, m + 1)), sparse.diags(steps)
    gained = sparse.hstack([none, there - here])
    forwards = sparse.hstack([there - here, -dt @ here])
    backwards = sparse.hstack([here - there, dt @ there])
    lower, upper = acceleration[:, 0], acceleration[:, 1]
    rows = sparse.vstack([gained, -gained, forwards, -forwards, backwards, -backwards]).tocsr()
    half = 0.5 * steps**2
    room = [upper * steps, -lower * steps, upper * half, -lower * half, upper * half, -lower * half]
    most = np.concatenate(room)
    finite = np.isfinite(most)
    bounds = [(None, None)] * (m + 1)
    for index in range(m + 1):
        gap = [min(max(index - 1, 0), m - 1), min(index, m - 1)]
        bounds.append((velocity[gap, 0].max(), velocity[gap, 1].min()))
    for waypoint, at in enumerate(task.waypoints[:, joint] / size):
        slack = np.asarray(task.tolerance)[waypoint, joint] / size + 1e-9
        bounds[waypoint * CELLS] = (at - slack, at + slack)
    for side, index in ((0, m + 1), (1, 2 * m + 1)):
        v = float(np.asarray(task.boundary.velocity)[side, joint]) * total / size
        bounds[index] = (v - 1e-7 * abs(v), v + 1e-7 * abs(v))
    found = linprog(np.zeros(2 * (m + 1)), rows[finite], most[finite], bounds=bounds)
    return bool(found.status == 2)
