"""Joint torques and their rates against their limits, at every time, to a stated bound."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.audit.kinematics import side_ratios
from ocp_traj.audit.motion import Motion
from ocp_traj.audit.numerics import chebyshev
from ocp_traj.audit.tolerances import POSITION_JUMPS
from ocp_traj.audit.verdict import Extremum
from ocp_traj.exceptions import InputError
from ocp_traj.robot.robot import Robot
from ocp_traj.task import TrajectoryTask

TORQUE_TOLERANCE = 1e-9
"""Allowed interpolation error as a part of the torque limit, or of the largest torque if that is smaller."""

_RATE_TOLERANCE = 1e-7
_ROUNDING = 1e-13
_SHORTEST_SEGMENT = 1e-12


@dataclass(frozen=True)
class JointCurve:
    """A quantity of every joint along a motion as Chebyshev series.

    Attributes
    ----------
    motion : Motion
    curve : ChebyshevCurve
    """

    motion: Motion
    curve: chebyshev.ChebyshevCurve

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.motion.n

    @property
    def gaps(self) -> chebyshev.Pieces:
        """Gap between waypoints of each segment, (S,)."""
        return self.motion.gaps[self.curve.pieces]

    @property
    def seconds(self) -> Array:
        """Length of each segment, (S,), s."""
        return (self.curve.right - self.curve.left) * self.motion.durations[self.curve.pieces]

    def times(self, segment: chebyshev.Pieces, theta: Array) -> Array:
        """Return the times of angles in segments, s."""
        piece = self.curve.pieces[segment]
        return self.motion.starts[piece] + self.motion.durations[piece] * self.curve.position(segment, theta)


@dataclass(frozen=True)
class TorqueCurve(JointCurve):
    """The torques of a motion as Chebyshev series, in the three parts that scale differently with time.

    At a uniform slowing s = 1/x the torques are gravity + x viscous + x^2 inertial + coulomb sign(v).

    Attributes
    ----------
    motion : Motion
    curve : ChebyshevCurve
        3 n components: gravity, viscous friction, the rest; N m (N for prismatic joints).
    coulomb : (S, n) array
        Coulomb friction of each segment; segments end where a velocity with Coulomb friction is zero.
    """

    coulomb: Array

    @property
    def bounds(self) -> Array:
        """Bound on the error of the torques of each segment, (S, n), N m."""
        return self.curve.bounds.reshape(-1, 3, self.n).sum(axis=1)

    def coefficients(self, x: float = 1.0) -> Array:
        """Return the Chebyshev coefficients of the torques at slowing 1/x, (S, n, .)."""
        gravity, viscous, inertial = np.split(self.curve.coefficients, 3, axis=1)
        torques = gravity + x * viscous + x**2 * inertial
        torques[:, :, 0] += self.coulomb
        return torques

    def rate_coefficients(self, x: float = 1.0) -> Array:
        """Return those of the torque rates at slowing 1/x, (S, n, .), without jumps of Coulomb friction."""
        per_second = 2.0 * x / self.seconds
        return chebyshev.differentiate(self.coefficients(x)) * per_second[:, None, None]


def torque_curve(task: TrajectoryTask, motion: Motion) -> TorqueCurve:
    """Sample the reference inverse dynamics along a motion until the error bound meets the tolerance.

    Raises
    ------
    InputError
        The task has no robot with inertia.
    """
    robot = task.robot
    if robot is None or not robot.has_inertia:
        raise InputError("torques need a robot with inertia, but this task has none")
    smallest = smallest_limit(task, "torque")
    rate = smallest_limit(task, "torque_rate")
    length = float(motion.durations.min())

    def tolerance(largest: Array) -> Array:
        per_joint = largest.reshape(3, -1).sum(axis=0)
        floor = _ROUNDING * per_joint.max()
        allowed = TORQUE_TOLERANCE * np.minimum(per_joint, smallest)
        rate_allowed = _RATE_TOLERANCE * rate * length / (2 * chebyshev.DEGREE**2)
        return np.tile(np.maximum(np.minimum(allowed, rate_allowed), floor), 3)

    pieces, left, right = segments(task, motion)
    parts, degree = _parts(robot, motion), motion.trajectory.degree
    curve = chebyshev.fit(parts, pieces, left, right, tolerance, motion_degree=degree)
    sign = _directions(motion, curve.pieces, 0.5 * (curve.left + curve.right))
    return TorqueCurve(motion, curve, robot.friction.coulomb * sign)


def _directions(motion: Motion, pieces: chebyshev.Pieces, x: Array) -> Array:
    """Return the sign of every velocity at one point of each piece, (S, n); 0 for a joint at rest.

    A joint rests in a piece where it is so slow that at this speed it would go no farther in the whole motion than
    its position may jump.
    """
    v = motion.sample(x[:, None], pieces, 1)[:, 0]
    moving = np.abs(motion.extrema[1]).max(axis=2) * motion.trajectory.duration > POSITION_JUMPS
    signs: Array = np.sign(v) * moving[pieces]
    return signs


def torques_at(
    task: TrajectoryTask, motion: Motion, pieces: chebyshev.Pieces, x: Array
) -> tuple[Array, Array, Array, Array]:
    """Return q, v, a, tau, each (S C, n), at points x (S, C); each row of x inside one of `segments`.

    Coulomb friction acts against the velocity in the middle of the row. Without a robot that has inertia tau
    is 0.
    """
    q, v, a = (motion.sample(x, pieces, order).reshape(-1, motion.n) for order in range(3))
    robot = task.robot
    if robot is None or not robot.has_inertia:
        return q, v, a, np.zeros_like(q)
    sign = np.repeat(_directions(motion, pieces, x.mean(axis=1)), x.shape[1], axis=0)
    return q, v, a, robot.torque(q, v, a) + robot.friction.coulomb * (sign - np.sign(v))


def smallest_limit(task: TrajectoryTask, name: str) -> Array:
    """Return the smallest limit of every joint, (n,), infinite where it is 0 or there is none."""
    limit = np.abs(task.limits.get(name)).min(axis=(0, 1))
    return np.where(limit > 0, limit, np.inf)


def _parts(robot: Robot, motion: Motion) -> chebyshev.Function:
    """Return (pieces, x) -> gravity, viscous friction and inertial torques, Coulomb friction taken off."""

    def parts(pieces: chebyshev.Pieces, x: Array) -> Array:
        states = [motion.sample(x, pieces, order) for order in range(3)]
        q, v, a = (state.reshape(-1, motion.n) for state in states)
        still = np.zeros_like(q)
        gravity = robot.torque(q, still, still)
        viscous = robot.friction.viscous * v
        inertial = robot.torque(q, v, a) - robot.friction.coulomb * np.sign(v) - gravity - viscous
        return np.concatenate([gravity, viscous, inertial], axis=1).reshape(*x.shape, -1)

    return parts


def segments(task: TrajectoryTask, motion: Motion) -> tuple[chebyshev.Pieces, Array, Array]:
    """Return pieces and the left and right ends inside them, cut where Coulomb friction may turn round."""
    count = len(motion.starts)
    if task.robot is None or not task.robot.has_inertia:
        return np.arange(count), np.zeros(count), np.ones(count)
    rubbing = np.flatnonzero(task.robot.friction.coulomb > 0)
    cuts = motion.candidates[0][:, rubbing].reshape(count, -1)
    cuts = np.sort(np.concatenate([np.zeros((count, 1)), cuts, np.ones((count, 1))], axis=1), axis=1)
    cuts[:, 1:-1][cuts[:, 1:-1] > 1.0 - _SHORTEST_SEGMENT] = 1.0
    piece, column = np.nonzero(np.diff(cuts, axis=1) > _SHORTEST_SEGMENT)
    return piece, cuts[piece, column], cuts[piece, column + 1]


def torque_peaks(task: TrajectoryTask, torques: TorqueCurve) -> list[Extremum]:
    """Return the largest torque ratio of every limited joint."""
    return joint_peaks(task, torques, torques.coefficients(), "torque")


def torque_rate_peaks(task: TrajectoryTask, torques: TorqueCurve) -> list[Extremum]:
    """Return the largest torque-rate ratio of every limited joint."""
    return joint_peaks(task, torques, torques.rate_coefficients(), "torque_rate")


def joint_peaks(task: TrajectoryTask, torques: JointCurve, coefficients: Array, name: str) -> list[Extremum]:
    """Return the largest ratio of every joint to a limit, from series (S, n, .) of the values on a curve."""
    n = torques.n
    flat = coefficients.reshape(-1, coefficients.shape[2])
    limits = task.limits.get(name)[torques.gaps].transpose(0, 2, 1).reshape(-1, 2)
    chosen = _rows_to_refine(flat, limits, n)
    row, theta = chebyshev.critical_points(flat[chosen])
    row = chosen[row]
    values = chebyshev.evaluate(flat[row], theta)
    ratios = side_ratios(values, limits[row, 0], limits[row, 1], _ROUNDING * np.abs(flat).sum(axis=1).max())
    segment, joint = row // n, row % n
    peaks = []
    for index in np.flatnonzero(np.isfinite(task.limits.get(name)).any(axis=(0, 1))):
        mine = np.flatnonzero(joint == index)
        best = mine[np.argmax(ratios[mine])]
        peaks.append(
            Extremum(
                limit=name,
                joint=int(index),
                time=float(torques.times(segment[best : best + 1], theta[best : best + 1])[0]),
                ratio=float(ratios[best]),
                gap=int(torques.gaps[segment[best]]),
                value=float(values[best]),
                bound=float(limits[row[best], 1 if values[best] >= 0 else 0]),
            )
        )
    return peaks


def _rows_to_refine(series: Array, limits: Array, n: int) -> chebyshev.Pieces:
    """Return the rows that may hold a joint's largest ratio: bounds of the others are below a value seen."""
    low, high, lower_bound, upper_bound = (
        side_ratios(values, limits[:, 0], limits[:, 1]).reshape(-1, n)
        for values in chebyshev.enclosures(series)
    )
    seen = np.maximum(low, high).max(axis=0)
    return np.flatnonzero((np.maximum(lower_bound, upper_bound) >= seen).ravel())


def relative_bound(task: TrajectoryTask, torques: TorqueCurve) -> float:
    """Return the bound on the torques' error as a part of the smallest limit, or of the largest torque."""
    limit = smallest_limit(task, "torque")
    largest = np.abs(torques.coefficients()).sum(axis=2).max()
    measure = np.where(np.isfinite(limit), limit, largest)
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.where(torques.bounds == 0, 0.0, torques.bounds / measure)
    return float(part.max())
