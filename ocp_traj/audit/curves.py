"""Cartesian speeds of frames and a user's own constraints, at every time, to a stated bound."""

from __future__ import annotations

from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.audit.custom import numeric_function
from ocp_traj.audit.kinematics import range_ratios
from ocp_traj.audit.motion import Motion
from ocp_traj.audit.numerics import chebyshev
from ocp_traj.audit.torque import segments, torques_at
from ocp_traj.audit.verdict import Extremum
from ocp_traj.exceptions import InputError
from ocp_traj.robot.robot import Robot
from ocp_traj.task import CustomConstraint, TrajectoryTask

_TOLERANCE = 1e-9
_ROUNDING = 1e-14
_JUMP_ROUNDING = 1e-12


def speed_peaks(task: TrajectoryTask, motion: Motion) -> tuple[list[Extremum], list[str]]:
    """Return the largest ratio of every limited frame's speed, and a sentence for each that was not resolved.

    The frame's positions, by Pinocchio, are interpolated and the interpolants differentiated; the velocity
    functions of the solvers play no part.

    Raises
    ------
    InputError
        The task has no robot.
    """
    if not task.limits.cartesian_speed:
        return [], []
    if task.robot is None:
        raise InputError("limits.cartesian_speed needs a robot, but this task has none")
    peaks, findings = [], []
    for frame, limit in task.limits.cartesian_speed:
        curve = _squared_speed(task.robot, motion, frame, limit)
        row, theta = chebyshev.critical_points(curve.coefficients[:, 0])
        values = np.sqrt(np.maximum(chebyshev.evaluate(curve.coefficients[row, 0], theta), 0.0))
        best = int(np.argmax(values))
        peaks.append(
            Extremum(
                limit="cartesian_speed",
                joint=-1,
                ratio=float(values[best] / limit),
                value=float(values[best]),
                bound=float(limit),
                label=frame,
                **_place(motion, curve, row[best : best + 1], theta[best : best + 1]),
            )
        )
        if not curve.resolved:
            findings.append(f"cartesian speed {frame}: could not be resolved between samples")
    return peaks, findings


def _place(
    motion: Motion, curve: chebyshev.ChebyshevCurve, row: chebyshev.Pieces, theta: Array
) -> dict[str, Any]:
    """Return the time and gap of one point of a curve."""
    piece = curve.pieces[row]
    time = motion.starts[piece] + motion.durations[piece] * curve.position(row, theta)
    return {"time": float(time[0]), "gap": int(motion.gaps[piece][0])}


def _squared_speed(robot: Robot, motion: Motion, frame: str, limit: float) -> chebyshev.ChebyshevCurve:
    def place(pieces: chebyshev.Pieces, x: Array) -> Array:
        q = motion.sample(x, pieces, 0).reshape(-1, motion.n)
        return np.array([robot.pose(row, frame)[:3, 3] for row in q]).reshape(*x.shape, 3)

    shortest = float(motion.durations.min())
    allowed = _TOLERANCE * limit * shortest / chebyshev.DEGREE**2
    count = len(motion.starts)
    places = chebyshev.fit(
        place,
        np.arange(count),
        np.zeros(count),
        np.ones(count),
        lambda largest: np.maximum(allowed, _ROUNDING * largest.max()),
        motion_degree=motion.trajectory.degree,
    )
    seconds = (places.right - places.left) * motion.durations[places.pieces]
    rates = chebyshev.differentiate(places.coefficients) * (2.0 / seconds)[:, None, None]

    def squared(pieces: chebyshev.Pieces, x: Array) -> Array:
        segment, theta = places.locate(np.repeat(pieces, x.shape[1]), x.ravel())
        velocity = [chebyshev.evaluate(rates[segment, axis], theta) for axis in range(3)]
        return np.sum(np.square(velocity), axis=0).reshape(*x.shape, 1)

    return chebyshev.fit(
        squared,
        places.pieces,
        places.left,
        places.right,
        lambda largest: np.maximum(_TOLERANCE * np.minimum(largest, limit**2), _JUMP_ROUNDING * largest),
        motion_degree=motion.trajectory.degree,
    )


def constraint_peaks(
    task: TrajectoryTask, motion: Motion, most: int | None = None
) -> tuple[list[Extremum], list[str]]:
    """Return the largest ratio of each of the task's own constraints, and a sentence for each not resolved.

    The ratio is 1 + excess / scale; `most` bounds the number of segments.
    """
    peaks, findings = [], []
    for constraint in task.constraints:
        peak, resolved = _constraint_peak(task, motion, constraint, most)
        peaks.append(peak)
        if not resolved:
            findings.append(f"constraint {constraint.name}: could not be resolved between samples")
    return peaks, findings


def _constraint_peak(
    task: TrajectoryTask, motion: Motion, constraint: CustomConstraint, most: int | None
) -> tuple[Extremum, bool]:
    function = numeric_function(constraint.function, task.n)
    scale = _scale(constraint)

    def values_at(pieces: chebyshev.Pieces, x: Array) -> Array:
        return function(*torques_at(task, motion, pieces, x)).reshape(*x.shape, -1)

    pieces, left, right = segments(task, motion)
    curve = chebyshev.fit(
        values_at,
        pieces,
        left,
        right,
        lambda largest: np.maximum(_TOLERANCE * scale, _JUMP_ROUNDING * largest),
        most,
        motion.trajectory.degree,
    )
    size = curve.coefficients.shape[1]
    flat = curve.coefficients.reshape(-1, chebyshev.DEGREE + 1)
    lower, upper = _bounds(constraint, size, len(flat))
    chosen = _rows_to_refine(flat, lower, upper, scale)
    row, theta = chebyshev.critical_points(flat[chosen])
    row = chosen[row]
    values, lower, upper = chebyshev.evaluate(flat[row], theta), lower[row], upper[row]
    ratios = range_ratios(values, lower, upper, np.full_like(values, scale))
    best = int(np.argmax(ratios))
    nearer_upper = values[best] - upper[best] >= lower[best] - values[best]
    peak = Extremum(
        limit="constraint",
        joint=-1,
        ratio=float(ratios[best]),
        value=float(values[best]),
        bound=float(upper[best] if nearer_upper else lower[best]),
        label=constraint.name,
        **_place(motion, curve, row[best : best + 1] // size, theta[best : best + 1]),
    )
    return peak, curve.resolved


def _bounds(constraint: CustomConstraint, size: int, rows: int) -> tuple[Array, Array]:
    """Return the bounds of every row; the values of one segment follow one another."""
    try:
        lower, upper = (
            np.broadcast_to(np.asarray(bound, dtype=np.float64), (size,))
            for bound in (constraint.lower, constraint.upper)
        )
    except ValueError:
        raise InputError(f"constraint {constraint.name}: has {size} values, its bounds do not fit") from None
    value = np.arange(rows) % size
    return lower[value], upper[value]


def _rows_to_refine(series: Array, lower: Array, upper: Array, scale: float) -> chebyshev.Pieces:
    """Return the rows that may hold the largest ratio: bounds of the others are below a value seen."""
    low, high, lower_bound, upper_bound = (
        range_ratios(values, lower, upper, np.full_like(values, scale))
        for values in chebyshev.enclosures(series)
    )
    seen = np.maximum(low, high).max()
    return np.flatnonzero(np.maximum(lower_bound, upper_bound) >= seen)


def _scale(constraint: CustomConstraint) -> float:
    """Return what divides an excess: as given, or the largest finite bound, or 1."""
    if constraint.scale is not None:
        return float(constraint.scale)
    bounds = np.abs(
        np.concatenate([np.ravel(constraint.lower), np.ravel(constraint.upper)]).astype(np.float64)
    )
    finite = bounds[np.isfinite(bounds) & (bounds > 0)]
    return float(finite.max()) if finite.size else 1.0
