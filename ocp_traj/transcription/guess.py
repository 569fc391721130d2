"""First motions: closed-form timing, knots inserted exactly, and uniform scaling into the limits."""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.quantities import RATES
from ocp_traj.task import Boundary, TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.curve import build_trajectory

DENSE = 16
"""Samples a piece for the uniform scaling of a guess."""


def closed_form_durations(task: TrajectoryTask) -> Array:
    """Return gap durations from the limits alone, (K - 1,) s.

    Each joint needs at least the time to travel at its velocity limit, to accelerate and brake halfway, or to do so
    with bounded jerk; the slowest joint decides. Without any limit a gap takes 1 s.
    """
    travel = np.abs(np.diff(task.waypoints, axis=0))
    durations = np.zeros(task.gaps)
    for power, (name, factor) in enumerate(zip(RATES, (1.2, 2.0, 2.2)), start=1):
        limit = np.minimum(-task.limits.get(name)[:, 0], task.limits.get(name)[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            needed = factor * (travel / limit) ** (1.0 / power)
        needed[(travel == 0) | ~np.isfinite(needed)] = 0.0
        durations = np.maximum(durations, needed.max(axis=1))
    usual = float(durations.max()) or 1.0
    return np.maximum(durations, 0.05 * usual)


def initial_guess(task: TrajectoryTask, durations: Array | None = None) -> Trajectory:
    """Return a motion of the task's family and number of knots, scaled into its kinematic limits.

    Parameters
    ----------
    task : TrajectoryTask
    durations : (K - 1,), optional
        Of the gaps, s, before the scaling; from distances and limits when left out.
    """
    gaps = closed_form_durations(task) if durations is None else durations
    if not task.virtual_knots:
        return _smooth(task, gaps)
    bare = task.changed(virtual_knots=0, boundary=Boundary(task.boundary.velocity))
    return insert_knots(_smooth(bare, gaps), task.virtual_knots)


def _smooth(task: TrajectoryTask, durations: Array) -> Trajectory:
    """Return the spline through the waypoints, slowed into its limits where it is at rest at its ends.

    The total comes into its bounds first, then each gap into its own.
    """
    curve = build_trajectory(task, durations, np.asarray(task.waypoints))
    if task.boundary.is_rest:
        scale = kinematic_scale(task, curve)
        low, high = np.asarray(task.objective.duration)
        total = np.clip(curve.duration * max(scale, 1e-12), low, high)
        curve = curve.scaled(float(total / curve.duration))
    bounds = np.asarray(task.objective.gap_durations)
    gaps = np.clip(curve.segment_durations, bounds[:, 0], bounds[:, 1])
    if (gaps == curve.segment_durations).all():
        return curve
    return build_trajectory(task, gaps, np.asarray(task.waypoints))


def kinematic_scale(task: TrajectoryTask, trajectory: Trajectory) -> float:
    """Return the uniform slowing that brings velocity, acceleration and jerk into their limits (sampled)."""
    fractions = np.linspace(0.0, 1.0, DENSE, endpoint=False)
    breakpoints = np.asarray(trajectory.breakpoints)
    t = (breakpoints[:-1, None] + fractions * np.diff(breakpoints)[:, None]).ravel()
    gap = np.clip(np.searchsorted(trajectory.waypoint_times, t, side="right") - 1, 0, task.gaps - 1)
    scale = 0.0
    for order, name in enumerate(RATES, start=1):
        limits = task.limits.get(name)[gap]
        value = trajectory(t, order)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.maximum(value / limits[:, 1], value / limits[:, 0])
        ratio = np.where(value == 0, 0.0, ratio)
        finite = ratio[np.isfinite(ratio)]
        scale = max(scale, float(finite.max(initial=0.0)) ** (1.0 / order))
    return scale or 1.0


def insert_knots(trajectory: Trajectory, virtual_knots: int) -> Trajectory:
    """Return the same motion with `virtual_knots` knots in every gap, by halving the longest pieces exactly.

    Parameters
    ----------
    trajectory : Trajectory
    virtual_knots : int
        At least as many as it has.
    """
    pieces: list[tuple[float, Array]] = []
    waypoint_times = np.asarray(trajectory.waypoint_times)
    breakpoints = np.asarray(trajectory.breakpoints)
    for start, end in zip(waypoint_times, waypoint_times[1:]):
        inside = np.flatnonzero((breakpoints[:-1] >= start) & (breakpoints[:-1] < end))
        parts = [
            (float(breakpoints[k + 1] - breakpoints[k]), np.asarray(trajectory.coefficients[k]))
            for k in inside
        ]
        while len(parts) < virtual_knots + 1:
            longest = int(np.argmax([duration for duration, _ in parts]))
            duration, coefficients = parts[longest]
            half = (duration / 2, coefficients), (duration / 2, shift_polynomial(coefficients, duration / 2))
            parts[longest : longest + 1] = half
        pieces += parts
    times = np.concatenate([[0.0], np.cumsum([duration for duration, _ in pieces])])
    return Trajectory(
        times,
        np.stack([coefficients for _, coefficients in pieces]),
        times[:: virtual_knots + 1],
        trajectory.family,
        trajectory.case,
    )


def shift_polynomial(coefficients: Array, shift: float) -> Array:
    """Return the coefficients of p(t + shift), ascending along the last axis."""
    shifted = np.array(coefficients)
    size = shifted.shape[-1]
    for start in range(size - 1):
        for power in range(size - 2, start - 1, -1):
            shifted[..., power] += shift * shifted[..., power + 1]
    return shifted
