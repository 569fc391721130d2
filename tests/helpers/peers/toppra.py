"""toppra as its first example uses it: a cubic path, limits of velocity and acceleration, constant s'' in cells."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from helpers.peers.answer import PeerAnswer, from_piecewise, least_cpu_time, symmetric_limit
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory


def solve_with_toppra(
    task: TrajectoryTask, s: Any, *, cells_per_gap: int = 100, repeats: int = 1, name: str = ""
) -> PeerAnswer:
    """Return the timing of the spline through the waypoints at path parameters `s`; jerk is not looked at."""
    grid = np.concatenate(
        [np.linspace(a, b, cells_per_gap, endpoint=False) for a, b in zip(s, s[1:])] + [[s[-1]]]
    )
    (speeds, curve), seconds = least_cpu_time(lambda: _solve(task, np.asarray(s), grid), repeats)
    setting = f"{name or 'given'} path, {cells_per_gap} cells a gap"
    if speeds is None:
        return PeerAnswer("toppra", setting, None, seconds, "no timing found")
    return PeerAnswer("toppra", setting, _exact_motion(curve, grid, speeds, np.asarray(s)), seconds)


def _solve(task: TrajectoryTask, s: np.ndarray, grid: np.ndarray) -> tuple[np.ndarray | None, CubicSpline]:
    import toppra
    import toppra.algorithm
    import toppra.constraint

    path = toppra.SplineInterpolator(s, np.asarray(task.waypoints))
    limits = [
        toppra.constraint.JointVelocityConstraint(symmetric_limit(task, "velocity")),
        toppra.constraint.JointAccelerationConstraint(symmetric_limit(task, "acceleration")),
    ]
    instance = toppra.algorithm.TOPPRA(
        limits, path, gridpoints=grid, parametrizer="ParametrizeConstAccel", solver_wrapper="seidel"
    )
    _, speeds, _ = instance.compute_parameterization(0.0, 0.0)
    return speeds, CubicSpline(s, np.asarray(task.waypoints))


def _exact_motion(curve: CubicSpline, grid: np.ndarray, speeds: np.ndarray, s: np.ndarray) -> Trajectory:
    """Return the degree-6 curve q(s(t)): cubic in s, and s quadratic in t in each cell (constant s'')."""
    step = np.diff(grid)
    spans = 2.0 * step / (speeds[:-1] + speeds[1:])
    half = 0.5 * (speeds[1:] ** 2 - speeds[:-1] ** 2) / (2.0 * step)
    local = [curve(grid[:-1], power) / factor for power, factor in ((0, 1), (1, 1), (2, 2), (3, 6))]
    move = np.stack([np.zeros_like(half), speeds[:-1], half], axis=1)  # s(t) - s_i, ascending
    coefficients = np.zeros((len(half), local[0].shape[1], 7))
    power = np.zeros((len(half), 7))
    power[:, 0] = 1.0
    for values in local:
        coefficients += values[:, :, None] * power[:, None, :]
        longer = np.zeros_like(power)
        for degree in range(3):
            longer[:, degree:] += move[:, degree, None] * power[:, : 7 - degree]
        power = longer
    times = np.concatenate([[0.0], np.cumsum(spans)])
    pieces = PPoly(np.moveaxis(coefficients, 2, 0)[::-1], times)
    return from_piecewise(pieces, times[np.searchsorted(grid, s)], "toppra")
