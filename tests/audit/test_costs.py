"""Energies and costs: computed by hand for a pendulum, and against very dense sums for the UR5."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from helpers.audit_motions import INERTIA
from helpers.audit_motions import pendulum as heavy_pendulum
from ocp_traj.audit.costs import (
    acceleration_cost,
    custom_cost,
    energy,
    energy_without_regeneration,
    jerk_cost,
    motor_loss,
    objective_value,
    torque_cost,
)
from ocp_traj.exceptions import InputError
from ocp_traj.robot import Robot, load_robot
from ocp_traj.robot.additions import Friction
from ocp_traj.task import CustomObjective, Limits, Motor, Objective, TrajectoryTask
from ocp_traj.trajectory import Trajectory

pendulum = partial(heavy_pendulum, effort=20)


def bang_bang(a: float = 4.0) -> Trajectory:
    """Return 1 s of acceleration a, then -a: the double integrator's fastest unit motion for a = 4."""
    return Trajectory([0.0, 0.5, 1.0], [[[0.0, 0.0, a / 2]], [[a / 8, a / 2, -a / 2]]], [0.0, 1.0])


def unit_cubic() -> Trajectory:
    return Trajectory([0.0, 1.0], [[[0.0, 0.0, 3.0, -2.0]]], [0.0, 1.0])


def task_for(robot: Robot | None, **changes: object) -> TrajectoryTask:
    return TrajectoryTask([[0.0], [1.0]], robot=robot, **changes)  # type: ignore[arg-type]


def test_a_double_integrator_takes_twice_its_kinetic_energy(tmp_path: Path) -> None:
    # speeding up to 2 rad/s takes I v^2 / 2, braking as much again; only the first half without regeneration
    task = task_for(pendulum(tmp_path, gravity=0.0))
    assert energy(task, bang_bang()) == pytest.approx(INERTIA * 4.0, rel=1e-12)
    assert energy_without_regeneration(task, bang_bang()) == pytest.approx(INERTIA * 2.0, rel=1e-12)


def test_viscous_friction_moves_the_zero_of_the_power(tmp_path: Path) -> None:
    # braking: tau = -I a + b v is zero at v = I a / b = 1 rad/s for b = 2.4
    viscous = 2.4
    task = task_for(pendulum(tmp_path, gravity=0.0, viscous=viscous))
    speeds = np.array([2.0, 1.0])
    first = INERTIA * 2.0 + viscous * 2.0**3 / 12.0  # integral of (I a + b v) v dt with dt = dv / 4
    primitive = -INERTIA * speeds**2 / 2 + viscous * speeds**3 / 12.0
    second = (primitive[0] - primitive[1]) + primitive[1] * -1.0
    assert energy(task, bang_bang()) == pytest.approx(first + second, rel=1e-12)


def test_coulomb_friction_takes_its_torque_times_the_way(tmp_path: Path) -> None:
    # tau = I a + c is positive all along for c > I a: all of c times the way, kinetic energy cancels
    task = task_for(pendulum(tmp_path, gravity=0.0, coulomb=5.0))
    assert energy(task, bang_bang()) == pytest.approx(5.0, rel=1e-12)


def test_lifting_takes_the_potential_energy(tmp_path: Path) -> None:
    # slow enough that the torque never turns round: m g r (sin 1 - sin 0)
    task = task_for(pendulum(tmp_path, gravity=-9.81))
    slow = unit_cubic().scaled(20.0)
    assert energy(task, slow) == pytest.approx(9.81 * np.sin(1.0), rel=1e-10)
    down = Trajectory(slow.breakpoints, slow.coefficients * -1.0, slow.waypoint_times)
    back = energy_without_regeneration(task, down)
    assert back == pytest.approx(0.0, abs=1e-12)
    assert energy(task, down) == pytest.approx(9.81 * np.sin(1.0), rel=1e-10)


def test_smoothness_costs_are_exact() -> None:
    # a = 6 - 12 t: integral of squares 12; jerk -12: 144
    assert acceleration_cost(unit_cubic()) == pytest.approx(12.0, rel=1e-14)
    assert jerk_cost(unit_cubic()) == pytest.approx(144.0, rel=1e-14)
    assert jerk_cost(bang_bang()) == 0.0


def test_torque_cost_and_motor_loss_are_the_hand_computed_ones(tmp_path: Path) -> None:
    # tau = I a = 2.4 N m throughout; limit 20 N m
    motor = Motor(torque_constant=0.1, resistance=2.0, gear_ratio=50.0)
    task = task_for(pendulum(tmp_path, gravity=0.0), objective=Objective(motor_loss=1.0, motor=motor))
    assert torque_cost(task, bang_bang()) == pytest.approx((2.4 / 20.0) ** 2, rel=1e-12)
    assert motor_loss(task, bang_bang()) == pytest.approx(2.0 * (2.4 / 5.0) ** 2, rel=1e-12)
    unlimited = task_for(pendulum(tmp_path, gravity=0.0), limits=Limits(torque=np.inf))
    assert torque_cost(unlimited, bang_bang()) == pytest.approx(2.4**2, rel=1e-12)


def test_without_inertia_there_is_no_energy() -> None:
    task = task_for(None)
    for cost in (energy, energy_without_regeneration, torque_cost):
        assert cost(task, unit_cubic()) is None


def test_motor_loss_needs_motors(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="needs the motors' parameters"):
        motor_loss(task_for(pendulum(tmp_path, gravity=0.0)), unit_cubic())


def test_a_users_objective_is_integrated(tmp_path: Path) -> None:
    symbols = [ca.SX.sym(name) for name in ("q", "v", "a", "tau")]
    q, v, _, tau = symbols
    way = CustomObjective("way", ca.Function("way", symbols, [ca.fabs(v)]), weight=3.0)
    both = CustomObjective("both", ca.Function("both", symbols, [ca.vertcat(q * v, tau * v)]), weight=1.0)
    robot = pendulum(tmp_path, gravity=0.0)
    assert custom_cost(task_for(robot), unit_cubic(), way) == pytest.approx(1.0, rel=1e-10)
    assert custom_cost(task_for(robot), unit_cubic(), both) == pytest.approx(0.5, rel=1e-10)
    task = task_for(robot, objective=Objective(time=2.0, custom=(way, both)))
    assert objective_value(task, unit_cubic()) == pytest.approx(2.0 + 3.0 + 0.5, rel=1e-10)


def test_the_objective_is_the_weighted_sum(tmp_path: Path) -> None:
    motor = Motor(torque_constant=0.1, resistance=2.0, gear_ratio=50.0)
    weights = {
        "time": 0.5,
        "energy": 0.25,
        "energy_without_regeneration": 2.0,
        "torque": 3.0,
        "acceleration": 0.125,
        "jerk": 4.0,
        "motor_loss": 5.0,
    }
    task = task_for(pendulum(tmp_path, gravity=0.0), objective=Objective(motor=motor, **weights))
    expected = 0.5 + 0.25 * 2.4 + 2 * 1.2 + 3 * 0.0144 + 0.125 * 16.0 + 0.0 + 5 * 0.4608
    assert objective_value(task, bang_bang()) == pytest.approx(expected, rel=1e-12)
    assert objective_value(task_for(None), unit_cubic()) == 1.0


@pytest.mark.parametrize("friction", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_energies_agree_with_a_very_dense_sum(friction: bool, seed: int) -> None:
    robot = load_robot("ur5")
    if friction:
        robot = robot.with_changes(
            friction=Friction(np.full(6, 0.5), np.array([1.0, 2.0, 0.0, 1.0, 0.5, 1.0]))
        )
    rng = np.random.default_rng(seed)
    waypoints = rng.uniform(-2, 2, (4, 6))
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.3, 0.9, 3))])
    spline = CubicSpline(times, waypoints, bc_type="clamped")
    trajectory = Trajectory(times, np.transpose(spline.c[::-1], (1, 2, 0)), times)
    task = TrajectoryTask(waypoints, Limits(position=np.inf), robot=robot)
    # composite Gauss-Legendre with two nodes on 60 000 cells, cut where a velocity changes its sign
    turns = [spline.derivative().roots(extrapolate=False)[joint] for joint in range(6)]
    cells = np.unique(np.concatenate([np.linspace(0.0, times[-1], 60_001), times, *turns]))
    middle, half = 0.5 * (cells[1:] + cells[:-1]), 0.5 * np.diff(cells)
    total, positive, squared = 0.0, 0.0, 0.0
    limits = task.limits.get("torque")[0, 1]
    for node in (-(3**-0.5), 3**-0.5):
        t = middle + half * node
        q, v, a = (trajectory(t, order) for order in range(3))
        tau = robot.batch.torque(q, v, a)
        total += (np.abs(tau * v).sum(axis=1) * half).sum()
        positive += (np.maximum(tau * v, 0).sum(axis=1) * half).sum()
        squared += (((tau / limits) ** 2).sum(axis=1) * half).sum()
    assert energy(task, trajectory) == pytest.approx(total, rel=2e-8)
    assert energy_without_regeneration(task, trajectory) == pytest.approx(positive, rel=2e-8)
    assert torque_cost(task, trajectory) == pytest.approx(squared, rel=2e-8)


def test_energy_is_the_same_at_every_subdivision(tmp_path: Path) -> None:
    task = task_for(pendulum(tmp_path, gravity=-9.81, viscous=0.3, coulomb=0.2))
    whole = unit_cubic()
    middle = 0.37
    second = [whole(middle)[0], whole(middle, 1)[0], whole(middle, 2)[0] / 2, -2.0]
    cut = Trajectory([0.0, middle, 1.0], [whole.coefficients[0], [second]], [0.0, 1.0])
    assert energy(task, cut) == pytest.approx(energy(task, whole), rel=1e-10)
