"""Drake's KinematicTrajectoryOptimization: a B-spline whose waypoints sit at path parameters chosen by the user."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.interpolate import BSpline, PPoly

from helpers.peers.answer import PeerAnswer, from_piecewise, least_cpu_time, symmetric_limit
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

ORDER = 4
"""Of the B-spline: cubic, the class of curves our own cubic family is taken from."""

START_DURATION = 20.0
"""Of the first guess, s: slow enough to keep every limit of the cases here."""


def path_parameters(task: TrajectoryTask, choice: str | Any) -> np.ndarray:
    """Return where the waypoints sit on [0, 1]: ``"uniform"``, ``"chord"``, or proportional to given times."""
    if not isinstance(choice, str):
        times = np.asarray(choice, dtype=np.float64)
        return (times - times[0]) / (times[-1] - times[0])
    steps = np.ones(task.gaps)
    if choice == "chord":
        steps = np.linalg.norm(np.diff(task.waypoints, axis=0), axis=1)
    cumulative = np.concatenate([[0.0], np.cumsum(steps)])
    scaled: np.ndarray = cumulative / cumulative[-1]
    return scaled


def solve_with_drake(
    task: TrajectoryTask, choice: str | Any, control_points: int, *, repeats: int = 1, name: str = ""
) -> PeerAnswer:
    """Return Drake's motion, with the solver Drake chooses (SNOPT)."""
    s = path_parameters(task, choice)
    (trajectory, message), seconds = least_cpu_time(lambda: _solve(task, s, control_points), repeats)
    setting = f"{name or choice}, {control_points} control points"
    return PeerAnswer("Drake", setting, trajectory, seconds, message)


def _solve(task: TrajectoryTask, s: np.ndarray, control_points: int) -> tuple[Trajectory | None, str]:
    from pydrake.planning import KinematicTrajectoryOptimization
    from pydrake.solvers import Solve

    problem = KinematicTrajectoryOptimization(
        task.n, control_points, spline_order=ORDER, duration=START_DURATION
    )
    _constrain(problem, task, s)
    program = problem.get_mutable_prog()
    program.SetInitialGuess(problem.control_points(), _straight_control_points(problem, task, s))
    result = Solve(program)
    if not result.is_success():
        return None, f"{result.get_solver_id().name()}: {result.get_solution_result().name}"
    return _to_trajectory(problem.ReconstructTrajectory(result), s), ""


def _constrain(problem: Any, task: TrajectoryTask, s: np.ndarray) -> None:
    problem.AddDurationCost(1.0)
    problem.AddDurationConstraint(1e-2, 100.0)
    adders = {
        "velocity": problem.AddVelocityBounds,
        "acceleration": problem.AddAccelerationBounds,
        "jerk": problem.AddJerkBounds,
    }
    for limit, add in adders.items():
        if task.limited(limit):
            bound = symmetric_limit(task, limit)
            add(-bound, bound)
    if task.limited("position"):
        problem.AddPositionBounds(*np.asarray(task.limits.get("position"))[0])
    for waypoint, parameter in zip(np.asarray(task.waypoints), s):
        problem.AddPathPositionConstraint(waypoint, waypoint, float(parameter))
    rest = np.zeros(task.n)
    for end in (0.0, 1.0):
        problem.AddPathVelocityConstraint(rest, rest, end)
        if task.boundary.acceleration is not None:
            problem.AddPathAccelerationConstraint(rest, rest, end)


def _straight_control_points(problem: Any, task: TrajectoryTask, s: np.ndarray) -> np.ndarray:
    """Return control points (n, N) on the polyline through the waypoints, at the Greville parameters."""
    knots = np.asarray(problem.basis().knots())
    count = problem.num_control_points()
    greville = np.array([knots[i + 1 : i + ORDER].mean() for i in range(count)])
    columns = [np.interp(greville, s, np.asarray(task.waypoints)[:, joint]) for joint in range(task.n)]
    return np.stack(columns)


def _to_trajectory(curve: Any, s: np.ndarray) -> Trajectory:
    knots = np.asarray(curve.basis().knots())
    points = np.stack([np.ravel(point) for point in curve.control_points()])
    spline, starts = BSpline(knots, points, ORDER - 1), np.unique(knots)
    powers = [spline(starts[:-1], power) / math.factorial(power) for power in range(ORDER)]
    pieces = PPoly(np.stack(powers[::-1]), starts)
    return from_piecewise(pieces, knots[0] + s * (knots[-1] - knots[0]), "drake")
