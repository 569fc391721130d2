"""Energies and other costs of a motion: the judge's measure of what a solver minimised.

Torques are the judge's Chebyshev series; between the zeros of torque and velocity |tau qdot| is a polynomial,
which Gauss-Legendre quadrature integrates exactly.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.audit.custom import numeric_function
from ocp_traj.audit.measures import integral, integrate_measure
from ocp_traj.audit.motion import Motion
from ocp_traj.audit.numerics import chebyshev
from ocp_traj.audit.numerics.polynomials import roots_in_unit_interval
from ocp_traj.audit.torque import TorqueCurve, torque_curve
from ocp_traj.exceptions import InputError
from ocp_traj.task import CustomObjective, TrajectoryTask
from ocp_traj.trajectory import Trajectory


def energy(task: TrajectoryTask, trajectory: Trajectory) -> float | None:
    """Return the integral of sum |tau_i qdot_i| dt, J, or None without a robot that has inertia.

    No motor losses; friction counts if the robot has any (paper A; its printed formula is lost, |tau qdot| is
    our reading). Relative accuracy about 1e-9.

    Parameters
    ----------
    task : TrajectoryTask
    trajectory : Trajectory
    """
    return _of_power(task, trajectory, np.abs)


def energy_without_regeneration(task: TrajectoryTask, trajectory: Trajectory) -> float | None:
    """Return the integral of sum max(tau_i qdot_i, 0) dt, J (braking gives nothing back), or None."""
    return _of_power(task, trajectory, _positive)


def torque_cost(task: TrajectoryTask, trajectory: Trajectory) -> float | None:
    """Return the integral of sum (tau_i / limit_i)^2 dt, s, or None without inertia.

    The limit is the largest magnitude a joint may have in any gap; a joint without one counts with 1 N m.
    """
    limits = np.abs(task.limits.get("torque")).max(axis=(0, 1))
    scale = np.where(np.isfinite(limits) & (limits > 0), limits, 1.0)
    return _of_squared_torque(task, trajectory, 1.0 / scale**2)


def motor_loss(task: TrajectoryTask, trajectory: Trajectory) -> float | None:
    """Return the copper loss, integral of sum R_i (tau_i / (N_i k_i))^2 dt, J, or None without inertia.

    Raises
    ------
    InputError
        The task's objective has no motor parameters.
    """
    motor = task.objective.motor
    if motor is None:
        raise InputError("motor_loss needs the motors' parameters in the objective, but there are none")
    constant, resistance, gear = (
        np.broadcast_to(np.asarray(value, dtype=np.float64), (task.n,))
        for value in (motor.torque_constant, motor.resistance, motor.gear_ratio)
    )
    return _of_squared_torque(task, trajectory, resistance / (gear * constant) ** 2)


def acceleration_cost(trajectory: Trajectory) -> float:
    """Return the integral of the sum of squared accelerations, rad^2/s^3 (m^2/s^3)."""
    return _of_squared_derivative(trajectory, 2)


def jerk_cost(trajectory: Trajectory) -> float:
    """Return the integral of the sum of squared jerks, rad^2/s^5 (m^2/s^5)."""
    return _of_squared_derivative(trajectory, 3)


def custom_cost(task: TrajectoryTask, trajectory: Trajectory, objective: CustomObjective) -> float:
    """Return the integral of a user's own function of (q, v, a, tau), without its weight.

    Torques are zeros for a task without a robot that has inertia.
    """
    return integral(task, Motion.of(trajectory), numeric_function(objective.function, task.n))


def objective_value(task: TrajectoryTask, trajectory: Trajectory) -> float:
    """Return the task's weighted cost of a motion: every term with weight, the user's own included.

    Parameters
    ----------
    task : TrajectoryTask
    trajectory : Trajectory
    """
    terms: dict[str, Callable[[], float | None]] = {
        "time": lambda: trajectory.duration,
        "energy": lambda: energy(task, trajectory),
        "energy_without_regeneration": lambda: energy_without_regeneration(task, trajectory),
        "torque": lambda: torque_cost(task, trajectory),
        "acceleration": lambda: acceleration_cost(trajectory),
        "jerk": lambda: jerk_cost(trajectory),
        "motor_loss": lambda: motor_loss(task, trajectory),
    }
    total = 0.0
    for name, weight in task.objective.weights.items():
        value = terms[name]() if name in terms else integrate_measure(task, trajectory, name)
        assert value is not None, f"a task with a weight on {name} has a robot with inertia"
        total += weight * value
    for objective in task.objective.custom:
        total += objective.weight * custom_cost(task, trajectory, objective)
    return total


def _positive(values: Array) -> Array:
    return np.maximum(values, 0.0)


def _gauss(degree: int) -> tuple[Array, Array]:
    """Return nodes and weights on [0, 1] that integrate polynomials of this degree exactly."""
    nodes, weights = np.polynomial.legendre.leggauss(degree // 2 + 1)
    return 0.5 * (nodes + 1.0), 0.5 * weights


def _torques(task: TrajectoryTask, trajectory: Trajectory) -> TorqueCurve | None:
    return torque_curve(task, Motion.of(trajectory)) if task.has_inertia else None


def _of_power(task: TrajectoryTask, trajectory: Trajectory, part: Callable[[Array], Array]) -> float | None:
    torques = _torques(task, trajectory)
    if torques is None:
        return None
    row, start, end = _power_pieces(torques)
    segment, joint = row // torques.n, row % torques.n
    nodes, weights = _gauss(chebyshev.DEGREE + trajectory.degree)
    u = start[:, None] + (end - start)[:, None] * nodes
    series = torques.coefficients().reshape(-1, chebyshev.DEGREE + 1)
    tau = chebyshev.evaluate(np.repeat(series[row], nodes.size, axis=0), np.arccos(u).ravel()).reshape(
        u.shape
    )
    curve = torques.curve
    middle, half = 0.5 * (curve.left + curve.right)[segment], 0.5 * (curve.right - curve.left)[segment]
    v = torques.motion.sample_joint(middle[:, None] + half[:, None] * u, curve.pieces[segment], joint, 1)
    seconds = 0.5 * torques.seconds[segment] * (end - start)
    return float((part(tau * v) @ weights * seconds).sum())


def _power_pieces(torques: TorqueCurve) -> tuple[chebyshev.Pieces, Array, Array]:
    """Return intervals of every series, in [-1, 1], inside which neither torque nor velocity changes sign."""
    curve, motion, n = torques.curve, torques.motion, torques.n
    row, theta = chebyshev.zeros(torques.coefficients().reshape(-1, chebyshev.DEGREE + 1))
    rows = len(curve.pieces) * n
    velocity = motion.coefficients[1]
    roots = roots_in_unit_interval(velocity.reshape(-1, velocity.shape[2])).reshape(len(velocity), n, -1)
    width = (curve.right - curve.left)[:, None, None]
    still = 2.0 * (roots[curve.pieces] - curve.left[:, None, None]) / width - 1.0
    still_row = np.repeat(np.arange(rows), still.shape[2])
    all_rows = np.concatenate([row, still_row, np.arange(rows), np.arange(rows)])
    points = np.concatenate(
        [np.cos(theta), np.clip(still.ravel(), -1, 1), np.full(rows, -1.0), np.ones(rows)]
    )
    order = np.lexsort((points, all_rows))
    all_rows, points = all_rows[order], points[order]
    keep = (all_rows[1:] == all_rows[:-1]) & (points[1:] > points[:-1])
    return all_rows[:-1][keep], points[:-1][keep], points[1:][keep]


def _of_squared_torque(task: TrajectoryTask, trajectory: Trajectory, factors: Array) -> float | None:
    torques = _torques(task, trajectory)
    if torques is None:
        return None
    nodes, weights = _gauss(2 * chebyshev.DEGREE)
    basis = np.cos(np.multiply.outer(np.arange(chebyshev.DEGREE + 1.0), np.arccos(2.0 * nodes - 1.0)))
    squared = (torques.coefficients() @ basis) ** 2 @ weights
    return float((squared @ factors * torques.seconds).sum())


def _of_squared_derivative(trajectory: Trajectory, order: int) -> float:
    motion = Motion.of(trajectory)
    nodes, weights = _gauss(2 * trajectory.degree)
    pieces = np.arange(len(motion.starts))
    values = motion.sample(np.tile(nodes, (len(pieces), 1)), pieces, order)
    return float(np.einsum("scn,c,s->", values**2, weights, motion.durations))
