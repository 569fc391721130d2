"""What is done to a motion that misses its limits by a little: slow it down, or solve again with tighter ones."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from metaheuristics import Status
from ocp_traj.audit import Verdict, audit
from ocp_traj.solvers.prepared import run_prepared
from ocp_traj.solvers.solver import Outcome, Request, Solver
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory

LARGEST_ROUNDING = 1e-4
"""Excess over a limit, or miss of a bounded duration, that counts as a gradient solver's rounding."""

LARGEST_OVERSIGHT = 0.1
"""Excess over a limit, between the points a gradient solver looked at, that limits tightened by as much can mend."""

LARGEST_REPAIR = 1.02
"""Uniform slowing that still counts as rounding off a solver's sampled limits; more is a different motion."""


def slowed_into_limits(task: TrajectoryTask, trajectory: Trajectory) -> tuple[Trajectory, Verdict, float]:
    """Return a motion, slowed into its limits where a little slowing does it, its verdict, and the slowing.

    Parameters
    ----------
    task : TrajectoryTask
        Whose limits count.
    trajectory : Trajectory
        Its total duration is brought inside its bounds first where only rounding kept it out.
    """
    trajectory = within_duration(task, trajectory)
    verdict = audit(task, trajectory)
    scale = verdict.smallest_feasible_scale
    if not verdict.feasible and scale is not None and 1.0 < scale <= LARGEST_REPAIR:
        slower = trajectory.scaled(scale)
        repaired = audit(task, slower)
        if repaired.feasible:
            return slower, repaired, scale
    return trajectory, verdict, 1.0


def within_duration(task: TrajectoryTask, trajectory: Trajectory) -> Trajectory:
    """Return the motion with its total duration inside its bounds where only rounding kept it out."""
    low, high = np.asarray(task.objective.duration)
    wanted = float(np.clip(trajectory.duration, low, high))
    miss = abs(wanted / trajectory.duration - 1.0)
    return trajectory.scaled(wanted / trajectory.duration) if 0.0 < miss < LARGEST_ROUNDING else trajectory


def can_be_mended(task: TrajectoryTask, trajectory: Trajectory) -> bool:
    """Return whether a motion keeps its limits but for what a little slowing or a tighter solve takes away."""
    verdict = audit(task, trajectory)
    scale, worst = verdict.smallest_feasible_scale, verdict.worst
    slowing = scale is not None and scale <= LARGEST_REPAIR
    return verdict.feasible or slowing or (worst is not None and worst.ratio <= 1.0 + LARGEST_ROUNDING)


def is_oversight(verdict: Verdict | None, status: Status) -> bool:
    """Return whether a solved motion, which no slowing can mend, is a little over its limits."""
    if verdict is None or verdict.feasible or verdict.worst is None or status is not Status.CONVERGED:
        return False
    return 1.0 < verdict.worst.ratio < 1.0 + LARGEST_OVERSIGHT


def draw_in(verdict: Verdict, before: Mapping[str, float]) -> dict[str, float]:
    """Return by what fraction of itself each limit is drawn in: twice its excess more than before.

    Parameters
    ----------
    verdict : Verdict
        On the last motion found, against the task's own limits.
    before : mapping
        Fractions by name of the limits that motion was found within.
    """
    fractions = dict(before)
    for extremum in verdict.limits.values():
        if extremum.broken:
            fractions[extremum.limit] = fractions.get(extremum.limit, 0.0) + 2.0 * (extremum.ratio - 1.0)
    return fractions


def solve_tighter(
    solver: Solver, task: TrajectoryTask, fractions: Mapping[str, float], request: Request
) -> Outcome:
    """Solve again with broken limits drawn in; the outcome is of the tighter task.

    Parameters
    ----------
    solver : Solver
        Asked once more.
    task : TrajectoryTask
        With its own limits.
    fractions : mapping
        By name of the limit; see `draw_in`.
    request : Request
        What is left of budget and time, warm.
    """
    return run_prepared(solver, task.changed(limits=tightened(task, fractions)), request)


def tightened(task: TrajectoryTask, fractions: float | Mapping[str, float]) -> Limits:
    """Return a task's limits drawn in by fractions of themselves; positions not beyond the waypoints.

    Parameters
    ----------
    task : TrajectoryTask
    fractions : number or mapping
        The same for all limits, or by name.
    """
    given = fractions if isinstance(fractions, Mapping) else dict.fromkeys((*task.limits.names, "position"), fractions)
    tighter = {name: task.limits.get(name) * (1.0 - given.get(name, 0.0)) for name in task.limits.names}
    fraction = given.get("position", 0.0)
    position = task.limits.get("position")
    size = np.where(np.isfinite(position), np.abs(position), 0.0)
    bounded = np.isfinite(position).all(axis=1, keepdims=True)
    room = fraction * np.where(bounded, np.ptp(np.where(bounded, position, 0.0), axis=1, keepdims=True), size)
    waypoints = np.asarray(task.waypoints)
    least, most = (choose(waypoints[:-1], waypoints[1:]) for choose in (np.minimum, np.maximum))
    lower, upper = position[:, 0], position[:, 1]
    drawn_in = [
        np.where(np.isfinite(lower), np.maximum(lower, np.minimum(lower + room[:, 0], least)), lower),
        np.where(np.isfinite(upper), np.minimum(upper, np.maximum(upper - room[:, 1], most)), upper),
    ]
    return task.limits.with_values({**tighter, "position": np.stack(drawn_in, axis=1)})
