"""Where the variables of the lifted form are, and how they are scaled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.quantities import DERIVATIVES, RATES
from ocp_traj.spline.family import SHORTEST
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.lifted.elements import IndexArray
from ocp_traj.transcription.nlp import RowBlock


@dataclass(frozen=True)
class Layout:
    """Variables [durations (S), knot states (S + 1, number of moving joints, p), slacks].

    Attributes
    ----------
    task : TrajectoryTask
    degree : int
        p of the family.
    segments : int
        S, all sub-segments.
    moving : (n',) joints that have variables; the others stay where they are
    duration_scale : float, s
    state_scales : (p, n')
        One variable unit of each derivative.
    shortest : (S,)
        Least duration of every segment, in units of `duration_scale`.
    """

    task: TrajectoryTask
    degree: int
    segments: int
    moving: Any
    duration_scale: float
    state_scales: Array
    shortest: Array

    @property
    def per_gap(self) -> int:
        """Sub-segments of a gap."""
        return self.segments // self.task.gaps

    @property
    def size(self) -> int:
        """Number of durations and states (slacks come after them)."""
        return self.segments + (self.segments + 1) * len(self.moving) * self.degree

    def state(self, knot: Any, joint: Any, order: Any) -> Any:
        """Return the index of a knot state; `joint` counts moving joints. Broadcasts."""
        return self.segments + (np.asarray(knot) * len(self.moving) + joint) * self.degree + order

    @property
    def places(self) -> tuple[IndexArray, IndexArray]:
        """Segment and moving joint of every (segment, joint) pair, flat."""
        segment, joint = np.meshgrid(np.arange(self.segments), np.arange(len(self.moving)), indexing="ij")
        return segment.ravel(), joint.ravel()

    def label(self, limit: str, segment: Any, joint: Any, fraction: Any) -> RowBlock:
        """Return labels of rows: `joint` is the joint itself, -1 where there is none, `fraction` of the segment."""
        inside = (segment % self.per_gap + fraction) / self.per_gap
        return RowBlock(limit, joint, segment // self.per_gap, inside)

    def knot_gaps(self, knot: IndexArray) -> tuple[IndexArray, IndexArray]:
        """Return the gaps left and right of knots."""
        left: IndexArray = np.maximum(knot - 1, 0) // self.per_gap
        right: IndexArray = np.minimum(knot, self.segments - 1) // self.per_gap
        return left, right

    def encode(self, trajectory: Trajectory) -> Array:
        """Return the variables (without slacks) of a trajectory of this family with the same number of knots."""
        values = np.empty(self.size)
        values[: self.segments] = np.diff(trajectory.breakpoints) / self.duration_scale
        knots = np.asarray(trajectory.breakpoints)
        for order in range(self.degree):
            states = trajectory(knots, order)[:, self.moving]
            index = self.state(np.arange(len(knots))[:, None], np.arange(len(self.moving))[None, :], order)
            values[index] = states / self.state_scales[order]
        return values

    def durations(self, x: Array) -> Array:
        """Return the durations of the segments, s."""
        return x[: self.segments] * self.duration_scale

    def positions(self, x: Array) -> Array:
        """Return the positions at the knots, (S + 1, n)."""
        knots = np.tile(self.task.waypoints[0], (self.segments + 1, 1))
        index = self.state(np.arange(self.segments + 1)[:, None], np.arange(len(self.moving))[None, :], 0)
        knots[:, self.moving] = x[index] * self.state_scales[0]
        return knots


def make_layout(task: TrajectoryTask, guess: Trajectory) -> Layout:
    """Choose moving joints and scales from a guess."""
    degree = task.family.degree
    segments = task.gaps * (task.virtual_knots + 1)
    moving = moving_joints(task)
    scale = float(np.mean(np.diff(guess.breakpoints)))
    shortest = _shortest_durations(task, guess) / scale
    return Layout(task, degree, segments, moving, scale, _state_scales(task, guess, degree, moving), shortest)


def _shortest_durations(task: TrajectoryTask, guess: Trajectory) -> Array:
    """Return the least duration of every segment, s: a part of an even share of its gap in the guess.

    Knots that crowd add nothing to the motion and leave their durations undetermined, which costs a solver many
    iterations.
    """
    still = (np.diff(task.waypoints, axis=0) == 0).all(axis=1)
    fractions = [task.family.least_share(task.virtual_knots, bool(each)) for each in still]
    shares = guess.segment_durations / (task.virtual_knots + 1)
    least: Array = np.repeat(fractions * shares, task.virtual_knots + 1)
    if task.virtual_knots and task.family.degree == 3 and task.boundary.acceleration is not None:
        # Without a jerk limit the best cubic leaves a given end acceleration at once.
        least[0], least[-1] = SHORTEST * shares[0], SHORTEST * shares[-1]
    return least


def moving_joints(task: TrajectoryTask) -> IndexArray:
    """Return the joints that need variables.

    A joint stays when all its waypoints agree and its ends are at rest, unless virtual knots let it move and
    torques or energy could make that worth while; a zero limit keeps it still in any case.
    """
    still = (np.ptp(task.waypoints, axis=0) == 0) & (np.asarray(task.tolerance) == 0).all(axis=0)
    for name in RATES:
        given = getattr(task.boundary, name)
        if given is not None:
            still &= (given == 0).all(axis=0)
    if task.virtual_knots and (task.needs_torque or task.limits.cartesian_speed):
        still &= _frozen(task)
    return np.flatnonzero(~still)


def _frozen(task: TrajectoryTask) -> Any:
    """Return the joints that a zero velocity, acceleration or jerk limit keeps still."""
    frozen = np.zeros(task.n, dtype=bool)
    for name in RATES:
        frozen |= (np.abs(task.limits.get(name)).max(axis=1) == 0).any(axis=0)
    return frozen


def _state_scales(task: TrajectoryTask, guess: Trajectory, degree: int, moving: IndexArray) -> Array:
    """Return one unit of each derivative: the joint's travel, its limits, else its size in the guess.

    A limit far above what the motion needs (more than a hundred times the guess) is not a scale.
    """
    travel = np.ptp(guess(guess.breakpoints), axis=0)
    most = float(travel.max(initial=0.0)) or 1.0
    travel = np.where(travel > 0, travel, 0.1 * most)  # a joint that may move, but need not
    scales = [np.maximum(travel, 1e-3 * most)]
    gap = guess.duration / task.gaps
    for order in range(1, degree):
        size = np.abs(guess(guess.breakpoints, order)).max(axis=0)
        size = np.maximum(size, scales[0] / gap**order)
        if order <= 3:
            limit = np.abs(task.limits.get(DERIVATIVES[order])).max(axis=(0, 1))
            usable = np.isfinite(limit) & (limit > 0) & (limit < 100 * size)
            size = np.where(usable, limit, size)
        scales.append(size)
    return np.stack(scales)[:, moving]
