"""Motions and small robots for the tests of the judge."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline, PPoly, make_interp_spline

from ocp_traj.robot import Robot, robot_from_urdf
from ocp_traj.robot.additions import Friction
from ocp_traj.trajectory import Trajectory

PENDULUM = """<?xml version="1.0"?>
<robot name="pendulum">
  <link name="base"/>
  <link name="arm">
    <inertial>
      <origin xyz="0.5 0 0"/>
      <mass value="2.0"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="base"/>
    <child link="arm"/>
    <axis xyz="0 -1 0"/>
    <limit lower="-10" upper="10" velocity="100" effort="1000"/>
  </joint>
</robot>
"""
"""2 kg at 0.5 m, 0.1 kg m^2 about it; gravity torque 9.81 cos q, q from the horizon."""

INERTIA = 0.1 + 2.0 * 0.5**2


def pendulum(
    folder: Path, *, gravity: float = -9.81, viscous: float = 0.0, coulomb: float = 0.0, effort: int = 1000
) -> Robot:
    """Return the pendulum as a robot."""
    path = folder / "pendulum.urdf"
    path.write_text(PENDULUM.replace("1000", str(effort)))
    return robot_from_urdf(path).with_changes(
        gravity=[0.0, 0.0, gravity], friction=Friction(np.array([viscous]), np.array([coulomb]))
    )


def from_pieces(polynomial: PPoly, waypoint_times: np.ndarray | None = None) -> Trajectory:
    """Return a SciPy piecewise polynomial as a trajectory."""
    coefficients = np.transpose(polynomial.c[::-1], (1, 2, 0))
    times = polynomial.x if waypoint_times is None else waypoint_times
    return Trajectory(polynomial.x, coefficients, times, "test")


def clamped_cubic(waypoints: np.ndarray, durations: np.ndarray) -> Trajectory:
    """Return the cubic spline through waypoints that is at rest at both ends."""
    times = np.concatenate([[0.0], np.cumsum(durations)])
    return from_pieces(CubicSpline(times, waypoints, bc_type="clamped"))


def random_spline(rng: np.random.Generator, degree: int, n: int, gaps: int) -> Trajectory:
    """Return a spline of maximal smoothness through random points, over a time of order one."""
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 1.0, gaps))])
    points = rng.normal(size=(gaps + 1, n)) * 10.0 ** rng.uniform(-6, 2)
    ends = [(order, np.zeros(n)) for order in range(1, (degree + 1) // 2)]
    spline = make_interp_spline(times, points, k=degree, bc_type=(ends, ends))
    coefficients = [spline(times[:-1], nu=order) / math.factorial(order) for order in range(degree + 1)]
    return Trajectory(times, np.stack(coefficients, axis=2), times, "test")


def random_pieces(rng: np.random.Generator, degree: int, n: int, count: int) -> Trajectory:
    """Return unconnected random polynomials, some with vanishing leading coefficients."""
    breakpoints = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 1.0, count))])
    coefficients = rng.normal(size=(count, n, degree + 1))
    coefficients[:, :, -1] *= 10.0 ** rng.uniform(-18, 0)
    return Trajectory(breakpoints, coefficients, breakpoints, "test")
