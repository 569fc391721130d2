"""From durations and knot positions to the exact trajectory of a task's family."""

from __future__ import annotations

from typing import Any

import numpy as np

from ocp_traj.arrays import Array, ArrayLike
from ocp_traj.exceptions import InputError, TaskError
from ocp_traj.quantities import RATES
from ocp_traj.spline import EndConditions, Piece
from ocp_traj.task import Boundary, TrajectoryTask
from ocp_traj.task.preparing import merged, passed_once
from ocp_traj.trajectory import Trajectory


def end_conditions(task: TrajectoryTask) -> EndConditions:
    """Return the derivatives the task gives at both ends, each (1, n); those above the jerk vanish or are free."""
    above = {order: np.zeros((1, task.n)) for order in task.family.end_orders if order > 3}
    ends: list[dict[int, Any]] = [dict(above), dict(above)]
    for order, name in enumerate(RATES, start=1):
        given = getattr(task.boundary, name)
        if given is not None:
            for side in (0, 1):
                ends[side][order] = given[side][None, :]
    return EndConditions(*ends)


def decided_knots(task: TrajectoryTask) -> tuple[list[int], list[int]]:
    """Return the virtual knots whose positions follow from the end conditions, next to the start and the end.

    Raises
    ------
    InputError
        An end has more such conditions than the gap beside it has virtual knots.
    """
    first, last = task.family.fixed_by_ends(end_conditions(task))
    segments = task.gaps * (task.virtual_knots + 1)
    room = task.virtual_knots if task.gaps > 1 else task.virtual_knots - max(first, last)
    if max(first, last) > room:
        raise InputError(
            f"spline.virtual_knots: {task.virtual_knots} given, but the boundary conditions decide "
            f"{max(first, last)} knot positions at each end; expected at least as many virtual knots in a gap"
        )
    return list(range(1, first + 1)), list(range(segments - last, segments))


def pieces_through(
    task: TrajectoryTask, durations: list[Any], positions: list[Any], ends: EndConditions
) -> list[Piece]:
    """Return the pieces of the family's curve through knot positions; see `Family.pieces`.

    Parameters
    ----------
    task : TrajectoryTask
    durations, positions : lists of m and m + 1 entries
        Positions that the end conditions decide are ignored.
    ends : EndConditions
        Those of the task, as numbers or symbols.
    """
    first, last = decided_knots(task)
    known = [None if knot in (*first, *last) else row for knot, row in enumerate(positions)]
    return task.family.pieces(durations, known, ends)


def build_trajectory(task: TrajectoryTask, durations: Array, positions: Array) -> Trajectory:
    """Return the family's curve through knot positions.

    Parameters
    ----------
    task : TrajectoryTask
    durations : (m,) s, of all sub-segments
    positions : (m + 1, n) rad (m)
        At the knots; those that the end conditions decide are ignored.
    """
    columns, rows = [np.full((1, 1), h) for h in durations], [row[None, :] for row in positions]
    pieces = pieces_through(task, columns, rows, end_conditions(task))
    degree = max(piece.degree for piece in pieces)
    coefficients = np.zeros((len(pieces), task.n, degree + 1))
    for index, piece in enumerate(pieces):
        for power, value in enumerate(piece.coefficients()):
            coefficients[index, :, power] = np.ravel(value) / durations[index] ** power
    breakpoints = np.concatenate([[0.0], np.cumsum(durations)])
    waypoint_times = breakpoints[:: task.virtual_knots + 1]
    return Trajectory(breakpoints, coefficients, waypoint_times, family=task.family.name, case=task.name)


def trajectory_from_durations(task: TrajectoryTask, durations: ArrayLike) -> Trajectory:
    """Return the task's family without virtual knots, run through the waypoints with given gap durations.

    Parameters
    ----------
    task : TrajectoryTask
    durations : (K - 1,) s
        0 between equal waypoints that are passed once.

    Raises
    ------
    InputError
        Their number is wrong, or one is not positive between waypoints that are two.

    Examples
    --------
    >>> import ocp_traj as ot
    >>> task = ot.load_case("fanuc-m10id8l")
    >>> published = ot.trajectory_from_durations(task, [0.311, 0.660, 1.676])
    >>> round(published.duration, 3)
    2.647
    >>> ot.audit(task, published).feasible
    True
    """
    h = np.asarray(durations, dtype=np.float64)
    if h.shape != (task.gaps,):
        raise InputError(f"{h.size} durations given, expected {task.gaps}, one a gap between waypoints")
    once = passed_once(task) & (h == 0)
    if not (np.isfinite(h).all() and (once | (h > 0)).all()):
        raise InputError(f"durations {h.tolist()} given, expected positive numbers")
    ready = merged(without_virtual_knots(task), once)
    return ready.restored(build_trajectory(ready.task, h[ready.kept], np.asarray(ready.task.waypoints)))


def without_virtual_knots(task: TrajectoryTask) -> TrajectoryTask:
    """Return a task without virtual knots; its end conditions are the default ones where knots served the others."""
    if task.virtual_knots == 0:
        return task
    try:
        return task.changed(virtual_knots=0)
    except TaskError:
        return task.changed(virtual_knots=0, boundary=Boundary(task.boundary.velocity))
