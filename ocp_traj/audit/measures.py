"""The judge's own measures of further quantities, and where a motion uses their limits most.

A measure is the judge's formula in NumPy; it never reuses what a solver was given.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.audit.motion import Motion
from ocp_traj.audit.numerics import chebyshev
from ocp_traj.audit.torque import JointCurve, joint_peaks, segments, smallest_limit, torques_at
from ocp_traj.audit.verdict import Extremum
from ocp_traj.exceptions import InputError
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

Measure = Callable[[TrajectoryTask, Array, Array, Array, Array], Array]
"""From a task and q, v, a, tau, each (N, n), to values (N, n) of a limit, or terms (N, k) of a cost's integrand."""

LIMIT_MEASURES: dict[str, Measure] = {}
"""Measures of limits by the names of their rows in `ocp_traj.quantities.JOINT_LIMITS`."""

COST_MEASURES: dict[str, Measure] = {}
"""Measures of costs by the names of their rows in `ocp_traj.quantities.COSTS`."""

_TOLERANCE = 1e-9
_INTEGRAL_TOLERANCE = 1e-10
_ROUNDING = 1e-12


def measure_limit(task: TrajectoryTask, trajectory: Trajectory, name: str, t: Array) -> Array:
    """Return a further limited quantity at times (N,), (N, n)."""
    q, v, a = (trajectory(t, order) for order in range(3))
    tau = task.robot.torque(q, v, a) if task.robot is not None and task.has_inertia else np.zeros_like(q)
    return _named(LIMIT_MEASURES, "limits", name)(task, q, v, a, tau)


def further_peaks(task: TrajectoryTask, motion: Motion) -> tuple[list[Extremum], list[str]]:
    """Return the largest ratio of every joint's further limits, and a sentence for each limit not resolved.

    Raises
    ------
    InputError
        The judge has no measure of a limit.
    """
    peaks, findings = [], []
    for name in task.limits.others:
        if task.limited(name):
            curve = _curve(task, motion, _named(LIMIT_MEASURES, "limits", name), smallest_limit(task, name))
            peaks += joint_peaks(task, JointCurve(motion, curve), curve.coefficients, name)
            findings += [] if curve.resolved else [f"{name}: could not be resolved between samples"]
    return peaks, findings


def integrate_measure(task: TrajectoryTask, trajectory: Trajectory, name: str) -> float:
    """Return a further cost of a motion without its weight: the integral of its measure over time.

    Raises
    ------
    InputError
        The judge has no measure of the cost.
    """
    measure = _named(COST_MEASURES, "objective", name)
    return integral(task, Motion.of(trajectory), lambda *state: measure(task, *state))


def integral(
    task: TrajectoryTask, motion: Motion, function: Callable[[Array, Array, Array, Array], Array]
) -> float:
    """Return the integral over time of the sum of (q, v, a, tau), each (N, n), to values (N, k)."""

    def integrand(chosen: chebyshev.Pieces, x: Array) -> Array:
        values = function(*torques_at(task, motion, chosen, x))
        return values.reshape(*x.shape, -1).sum(axis=2, keepdims=True)

    pieces, left, right = segments(task, motion)
    degree = motion.trajectory.degree
    curve = chebyshev.fit(
        integrand, pieces, left, right, lambda largest: _INTEGRAL_TOLERANCE * largest, motion_degree=degree
    )
    seconds = (curve.right - curve.left) * motion.durations[curve.pieces]
    return float((chebyshev.integrals(curve.coefficients[:, 0]) * 0.5 * seconds).sum())


def _named(measures: dict[str, Measure], table: str, name: str) -> Measure:
    try:
        return measures[name]
    except KeyError:
        raise InputError(f"{table}.{name}: the judge has no measure of it") from None


def _curve(task: TrajectoryTask, motion: Motion, measure: Measure, smallest: Array) -> chebyshev.ChebyshevCurve:
    def values(chosen: chebyshev.Pieces, x: Array) -> Array:
        return measure(task, *torques_at(task, motion, chosen, x)).reshape(*x.shape, motion.n)

    return chebyshev.fit(
        values,
        *segments(task, motion),
        lambda largest: np.maximum(_TOLERANCE * np.minimum(largest, smallest), _ROUNDING * largest),
        motion_degree=motion.trajectory.degree,
    )
