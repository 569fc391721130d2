"""A task made ready for solvers: equal consecutive waypoints are one point, positions count from near the motion.

Every solver, reference and form of a problem works on the prepared task, and its motions are brought back to the
waypoints and positions that were asked for. The judge never sees a prepared task.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ocp_traj.arrays import Array
from ocp_traj.exceptions import TaskError
from ocp_traj.trajectory import Trajectory

if TYPE_CHECKING:
    from ocp_traj.task.task import TrajectoryTask

NEAR = 2.0
"""A joint's positions count from 0 where they are at most this many times its travel; there doubles are fine enough."""


@dataclass(frozen=True, eq=False)
class PreparedTask:
    """A task made ready for solvers, and the way back.

    Attributes
    ----------
    original : TrajectoryTask
    task : TrajectoryTask
        The same problem without gaps that last 0 s, with positions relative to `origin`.
    points : (K,) integer array
        The waypoint of `task` that each waypoint of `original` is, from 0.
    kept : (G,) integer array
        The gap of `original` that each gap of `task` is, from 0.
    origin : (n,) array
        Where positions of `task` count from, rad (m for prismatic joints).
    """

    original: TrajectoryTask
    task: TrajectoryTask
    points: NDArray[np.intp]
    kept: NDArray[np.intp]
    origin: Array

    @property
    def changes_nothing(self) -> bool:
        """True when the task was ready as it is."""
        return self.task is self.original

    def restored(self, trajectory: Trajectory) -> Trajectory:
        """Return a motion of the prepared task as one of the original: one time for each of its waypoints."""
        return self._moved(trajectory, self.points, self.origin)

    def prepared(self, trajectory: Trajectory) -> Trajectory:
        """Return a motion of the original task as one of the prepared; it counts where each point is first passed."""
        first = np.unique(self.points, return_index=True)[1]
        first[-1] = len(self.points) - 1
        return self._moved(trajectory, first, -self.origin)

    def _moved(self, trajectory: Trajectory, waypoints: NDArray[np.intp], offset: Array) -> Trajectory:
        if self.changes_nothing:
            return trajectory
        times, coefficients = trajectory.waypoint_times, np.array(trajectory.coefficients)
        if len(times) == waypoints.max() + 1 and trajectory.n == len(offset):
            coefficients[:, :, 0] += offset
            times = times[waypoints]
        return replace(trajectory, coefficients=coefficients, waypoint_times=times)

    def restored_durations(self, durations: Array) -> Array:
        """Return the durations of the original's gaps, (K - 1,) s, from those of the prepared task's."""
        restored = np.zeros(self.original.gaps)
        restored[self.kept] = durations
        return restored

    def in_original_numbers(self, sentence: str) -> str:
        """Return a sentence with the numbers that gaps and waypoints have in the original, counted from 1."""
        if len(self.kept) == self.original.gaps:
            return sentence
        first = np.unique(self.points, return_index=True)[1]

        def renumbered(match: re.Match[str]) -> str:
            numbers, index = (self.kept if match[1] == "gap" else first), int(match[2]) - 1
            return f"{match[1]} {numbers[index] + 1}" if 0 <= index < len(numbers) else match[0]

        return re.sub(r"\b(gap|waypoint) (\d+)\b", renumbered, sentence)


def prepare(task: TrajectoryTask) -> PreparedTask:
    """Return a task made ready for solvers, and the way back.

    Raises
    ------
    TaskError
        With equal consecutive waypoints as one point the spline has too few of them.
    """
    return merged(task, passed_once(task))


def merged(task: TrajectoryTask, once: NDArray[np.bool_]) -> PreparedTask:
    """Return a task whose gaps `once` (K - 1,) between equal waypoints are left out; see `prepare`.

    A point that has several boxes around it is passed in what the boxes have in common. Limits of a gap that is left
    out hold for 0 s, so they limit nothing.
    """
    kept = np.flatnonzero(~once)
    if not kept.size:  # nothing but one point: standing still there is the last gap
        kept = np.array([task.gaps - 1])
    points = np.searchsorted(kept, np.arange(len(task.waypoints)))
    origin = _origin(task)
    if len(kept) == task.gaps and not origin.any():
        return PreparedTask(task, task, points, kept, origin)
    first = np.unique(points, return_index=True)[1]
    boxes = np.full((len(first), task.n), np.inf)
    np.minimum.at(boxes, points, np.asarray(task.tolerance))
    waypoints = np.asarray(task.waypoints)[first] - origin
    limits = {name: task.limits.get(name)[kept] for name in task.limits.names}
    limits["position"] = _containing(limits["position"] - origin, waypoints, boxes)
    gap_durations = np.asarray(task.objective.gap_durations)[kept]
    try:
        ready = task.changed(
            waypoints=waypoints,
            tolerance=boxes,
            limits=task.limits.with_values(limits),
            objective=replace(task.objective, gap_durations=gap_durations),
        )
    except TaskError as error:
        equal = task.gaps - len(kept)
        if not equal:
            raise
        many = "s" if equal > 1 else ""
        problem = f"{error.problem} (equal consecutive waypoints are one point, {equal} waypoint{many} left out)"
        raise TaskError(error.key, problem) from error
    return PreparedTask(task, ready, points, kept, origin)


def passed_once(task: TrajectoryTask) -> NDArray[np.bool_]:
    """Return which gaps lie between equal waypoints that are one point, so that they last 0 s, (K - 1,).

    A gap whose duration has a bound lies between two instants.
    """
    equal = (task.waypoints[1:] == task.waypoints[:-1]).all(axis=1)
    free = (np.asarray(task.objective.gap_durations) == [0.0, np.inf]).all(axis=1)
    return np.asarray(equal & free)


def _origin(task: TrajectoryTask) -> Array:
    """Return where positions should count from, (n,): the first waypoint, for joints that are far from 0.

    Doubles near 0.3 are 5e-17 apart, a fraction of 5e-5 of a travel of 1e-12. Where a joint is farther from 0 than
    it travels, differences from its first waypoint are exact. Torques and places of frames depend on the positions
    themselves, so a task with a robot or a function of the user's keeps them.
    """
    waypoints = np.asarray(task.waypoints)
    if task.robot is not None or task.constraints or task.objective.custom:
        return np.zeros(task.n)
    far = np.abs(waypoints).min(axis=0) >= NEAR * np.ptp(waypoints, axis=0)
    return np.where(far, waypoints[0], 0.0)


def _containing(position: Array, waypoints: Array, boxes: Array) -> Array:
    """Return position limits (G, 2, n) widened where rounding has put a waypoint's box beside them."""
    lower, upper = position[:, 0], position[:, 1]
    for side in (slice(None, -1), slice(1, None)):
        lower = np.minimum(lower, waypoints[side] + boxes[side])
        upper = np.maximum(upper, waypoints[side] - boxes[side])
    return np.stack([lower, upper], axis=1)
