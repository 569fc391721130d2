"""What the rows of a task should be, worked out apart: SciPy's splines, Pinocchio's dynamics, limits as given."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest
from scipy.interpolate import BSpline, PPoly, make_interp_spline

from ocp_traj.robot import robot_from_urdf
from ocp_traj.robot.additions import Friction
from ocp_traj.task import Boundary, CustomConstraint, Limits, Objective, Search, TrajectoryTask

DEGREES = {"cubic": 3, "quintic": 5, "septic": 7}
ORDERS = {"position": 0, "velocity": 1, "acceleration": 2, "jerk": 3}

LINK = """  <link name="{name}"><inertial><origin xyz="{at}"/><mass value="{mass}"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0.001" ixz="0" iyz="0.002"/></inertial></link>
"""
JOINT = """  <joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>
    <origin xyz="{at}"/><limit lower="-9" upper="9" velocity="99" effort="999"/></joint>
"""


def make_arm(folder: Path, friction: tuple[float, float] = (0.3, 0.0)) -> Any:
    """Return an arm that turns, bends and reaches out (two hinges and a slide), with friction."""
    links = [("base", "0 0 0", 1.0), ("turret", "0.05 0.01 0.1", 3.0), ("arm", "0.2 0 0.02", 2.0)]
    links.append(("hand", "0.1 0.03 -0.02", 1.5))
    joints = [
        ("revolute", "0 0 1", "0 0 0.2"),
        ("revolute", "0 -1 0", "0.1 0 0.3"),
        ("prismatic", "1 0 0", "0.3 0 0"),
    ]
    text = "".join(LINK.format(name=name, at=at, mass=mass) for name, at, mass in links)
    for index, (kind, axis, at) in enumerate(joints):
        ends = {"parent": links[index][0], "child": links[index + 1][0]}
        text += JOINT.format(name=f"joint{index}", kind=kind, axis=axis, at=at, **ends)
    path = folder / "arm.urdf"
    path.write_text(f'<robot name="arm">\n{text}</robot>')
    shares = np.array([1.0, 0.7, 0.4])
    return robot_from_urdf(path).with_changes(friction=Friction(friction[0] * shares, friction[1] * shares))


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The arm, with viscous friction."""
    return make_arm(tmp_path_factory.mktemp("arm"))


def torque(robot: Any, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Return torques by Pinocchio's recursion, friction added."""
    data = robot.model.createData()
    friction = robot.friction.viscous * v + robot.friction.coulomb * np.sign(v)
    return np.asarray(pin.rnea(robot.model, data, q, v, a)) + friction


def torque_rate(robot: Any, q: np.ndarray, v: np.ndarray, a: np.ndarray, j: np.ndarray) -> np.ndarray:
    """Return d tau / dt by Pinocchio's derivatives (no Coulomb friction)."""
    data = robot.model.createData()
    pin.computeRNEADerivatives(robot.model, data, q, v, a)
    inertia = np.triu(data.M) + np.triu(data.M, 1).T
    return np.asarray(data.dtau_dq @ v + data.dtau_dv @ a + inertia @ j + robot.friction.viscous * a)


def squared_speed(robot: Any, frame: str, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return the square of a frame's linear speed."""
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q, v)
    velocity = pin.getFrameVelocity(robot.model, data, robot.model.getFrameId(frame))
    return np.array([np.square(velocity.linear).sum()])


def custom_function() -> Any:
    """Return a limit of one's own: two values of position, velocity, acceleration and torque."""
    q, v, a, tau = (ca.SX.sym(name, 3) for name in ("q", "v", "a", "tau"))
    return ca.Function("own", [q, v, a, tau], [ca.vertcat(q[0] * v[1] + 0.1 * a[2], tau[1] * v[1])])


def custom_values(robot: Any, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Return the values of `custom_function`."""
    return np.array([q[0] * v[1] + 0.1 * a[2], torque(robot, q, v, a)[1] * v[1]])


CUSTOM_BOUNDS = np.array([[-0.5, -np.inf], [0.8, 25.0]])
FRAMES = (("hand", 0.9), ("arm", 0.4))

WAYPOINTS = np.array([[0.1, -0.4, 0.05], [0.7, 0.3, -0.1], [-0.2, 0.5, 0.2], [0.4, -0.1, 0.15]])
GAPS = len(WAYPOINTS) - 1


def sided(size: float, seed: int) -> np.ndarray:
    """Return limits (gaps, 2, joints) that differ by gap, joint and side; some joints have none on a side."""
    rng = np.random.default_rng(seed)
    limits = size * rng.uniform(0.5, 1.5, (GAPS, 2, 3)) * np.array([-1.0, 1.0])[:, None]
    limits[0, 0, 1] = -np.inf
    limits[1, :, 2] = [-np.inf, np.inf]
    limits[2, 1, 0] = np.inf
    return limits


LIMITS: dict[str, np.ndarray] = {
    "position": sided(1.6, 1),
    "velocity": sided(1.2, 2),
    "acceleration": sided(4.0, 3),
    "jerk": sided(30.0, 4),
    "torque": sided(20.0, 5),
    "torque_rate": sided(120.0, 6),
}
LIMITS["acceleration"][:, :, 2] = [-np.inf, np.inf]
LIMITS["torque"][:, :, 0] = [-np.inf, np.inf]


def make_task(robot: Any, family: str, knots: int = 0, **changes: Any) -> TrajectoryTask:
    """Return a task with every kind of limit."""
    values: dict[str, Any] = {
        "waypoints": WAYPOINTS,
        "limits": Limits(**LIMITS, cartesian_speed=FRAMES),
        "robot": robot,
        "family": family,
        "virtual_knots": knots,
        "boundary": Boundary(acceleration=None) if family == "cubic" else Boundary(),
        "objective": Objective(
            time=1.0, duration=(3.0, 5.0), gap_durations=[[0.5, 2.0], [0.0, 1.5], [0.7, np.inf]]
        ),
        "search": Search((0.25, 1.5)),
        "constraints": (CustomConstraint("own", custom_function(), *CUSTOM_BOUNDS),),
    }
    return TrajectoryTask(**{**values, **changes})


@dataclass(frozen=True)
class Motion:
    """Polynomials of all segments, in time from each segment's start, and what knots are said to have."""

    pieces: PPoly
    knots: np.ndarray
    """(S + 1, orders, n)."""

    @property
    def durations(self) -> np.ndarray:
        return np.diff(self.pieces.x)

    def coefficients(self, order: int, segment: int) -> np.ndarray:
        """Return a derivative of a segment's own polynomial, falling powers of time, (powers, n)."""
        column: np.ndarray = self.pieces.c[:, segment]
        for _ in range(order):
            column = column[:-1] * np.arange(len(column) - 1.0, 0.0, -1.0)[:, None]
        return column

    def at(self, order: int, segment: int, fraction: Any) -> np.ndarray:
        """Return a derivative at a fraction of a segment, at its end too, (n,), or (N, n) at N fractions."""
        local = np.asarray(fraction)[..., None] * self.durations[segment]
        value = np.zeros_like(local)
        for row in self.coefficients(order, segment):
            value = value * local + row
        return np.asarray(value)

    def state(self, segment: int, fraction: float, orders: int = 3) -> list[np.ndarray]:
        return [self.at(order, segment, fraction) for order in range(orders)]

    def extremes(self, order: int, segment: int) -> np.ndarray:
        """Return the largest and the smallest value of a derivative on a segment, (2, n)."""
        found = []
        for column in self.coefficients(order, segment).T:
            roots = np.roots(np.polyder(column))
            inside = roots.real[np.abs(roots.imag) < 1e-9]
            points = np.clip(np.array([0.0, self.durations[segment], *inside]), 0.0, self.durations[segment])
            values = np.polyval(column, points)
            found.append([values.max(), values.min()])
        return np.array(found).T


def spline(degree: int, durations: np.ndarray, knots: np.ndarray, start: Any, end: Any) -> Motion:
    """Return SciPy's spline through knots with derivatives (order, values) given at its ends."""
    times = np.concatenate([[0.0], np.cumsum(durations)])
    curve: BSpline = make_interp_spline(times, knots, k=degree, bc_type=(start, end))
    coefficients = np.array([curve(times[:-1], nu=k) / math.factorial(k) for k in range(degree)])
    top = np.diff(curve(times, nu=degree - 1), axis=0) / (np.diff(times)[:, None] * math.factorial(degree))
    states = np.stack([curve(times, nu=k) for k in range(degree)], axis=1)
    return Motion(PPoly(np.concatenate([coefficients, top[None]])[::-1], times), states)


def unconnected(degree: int, durations: np.ndarray, states: np.ndarray) -> Motion:
    """Return the segments that knot states (S + 1, degree, n) stand for, whether they meet or not."""
    times = np.concatenate([[0.0], np.cumsum(durations)])
    factors = np.array([math.factorial(order) for order in range(degree)])
    low = np.moveaxis(states[:-1] / factors[:, None], 1, 0)
    top = np.diff(states[:, -1], axis=0) / (durations[:, None] * math.factorial(degree))
    return Motion(PPoly(np.concatenate([low, top[None]])[::-1], times), states)


INSTANTS = ("torque", "torque_rate", "cartesian_speed", "custom")


def instant_limits(robot: Any, name: str) -> tuple[Any, np.ndarray, list[int], int]:
    """Return the function of (q, v, a[, jerk]), the bounds (gaps, 2, k), the joints and the orders of one limit."""
    if name in ("torque", "torque_rate"):
        joints = [joint for joint in range(3) if np.isfinite(LIMITS[name][:, :, joint]).any()]
        own = torque if name == "torque" else torque_rate
        return (
            (lambda *u: own(robot, *u)[joints]),
            LIMITS[name][:, :, joints],
            joints,
            3 + (name == "torque_rate"),
        )
    if name == "cartesian_speed":
        bounds = np.array([[-np.inf, -np.inf], [limit**2 for _, limit in FRAMES]])
        speeds = lambda q, v, a: np.concatenate([squared_speed(robot, frame, q, v) for frame, _ in FRAMES])  # noqa: E731
        return speeds, np.tile(bounds, (GAPS, 1, 1)), [-1, -1], 3
    return (lambda *u: custom_values(robot, *u)), np.tile(CUSTOM_BOUNDS, (GAPS, 1, 1)), [-1, -1], 3


def larger_finite(*bounds: float) -> float:
    """Return the larger magnitude of the finite bounds."""
    return max(abs(bound) for bound in bounds if np.isfinite(bound))
