"""A robot from a table of Denavit-Hartenberg parameters: kinematics and limits, no inertia."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ocp_traj.arrays import Array, ArrayLike
from ocp_traj.exceptions import RobotError
from ocp_traj.robot.additions import vector
from ocp_traj.robot.robot import Robot, RobotSource
from ocp_traj.units import factor

CONVENTIONS = ("standard", "modified")
"""Denavit-Hartenberg's own convention ("standard") and Craig's ("modified")."""


def _screw_x(a: float, alpha: float) -> Array:
    """Return Trans(x, a) Rot(x, alpha), (4, 4)."""
    c, s = _cosine_sine(alpha)
    return np.array([[1.0, 0.0, 0.0, a], [0.0, c, -s, 0.0], [0.0, s, c, 0.0], [0.0, 0.0, 0.0, 1.0]])


def _screw_z(d: float, theta: float) -> Array:
    """Return Trans(z, d) Rot(z, theta), (4, 4)."""
    c, s = _cosine_sine(theta)
    return np.array([[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, d], [0.0, 0.0, 0.0, 1.0]])


def _cosine_sine(angle: float) -> tuple[float, float]:
    """Return cosine and sine, exact at multiples of a right angle (within 1e-15 rad)."""
    quarter = angle / (0.5 * np.pi)
    if abs(quarter - round(quarter)) < 1e-15 * max(1.0, abs(quarter)):
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarter) % 4]
    return float(np.cos(angle)), float(np.sin(angle))


def robot_from_dh(
    convention: str,
    a: ArrayLike,
    alpha: ArrayLike,
    d: ArrayLike,
    theta: ArrayLike,
    unit: str = "rad",
    joints: Sequence[str] | None = None,
    position_limits: ArrayLike | None = None,
    velocity_limits: ArrayLike | None = None,
    *,
    name: str = "dh",
) -> Robot:
    """Return the robot of a table of Denavit-Hartenberg parameters, one row a joint.

    Standard: T_i = Rot(z, theta) Trans(z, d) Trans(x, a) Rot(x, alpha), the joint comes first. Modified
    (Craig, *Introduction to Robotics*, Eq. 3.6): T_i = Rot(x, alpha) Trans(x, a) Rot(z, theta) Trans(z, d),
    where row i holds a_{i-1} and alpha_{i-1}. The joint's value is added to theta (revolute) or d
    (prismatic).

    Parameters
    ----------
    convention : {"standard", "modified"}
    a, d : (n,)
        m.
    alpha, theta : (n,)
        In `unit`; theta is the angle at joint value zero.
    unit : {"rad", "deg"}
    joints : sequence of n str, optional
        "revolute" (default) or "prismatic".
    position_limits, velocity_limits : (2, n), optional
        Lower and upper; rad and rad/s, m and m/s for prismatic joints.
    name : str

    Returns
    -------
    Robot
        With frames "base" and "tool" (the last row's frame); `has_inertia` is false.

    Raises
    ------
    RobotError
        The convention, a joint type or a length is wrong.

    Examples
    --------
    >>> arm = robot_from_dh("standard", a=[0.4, 0.3], alpha=[0, 0], d=[0, 0], theta=[0, 0])
    >>> arm.pose([0.0, 0.0])[:3, 3].round(12).tolist()
    [0.7, 0.0, 0.0]
    """
    import pinocchio as pin

    if convention not in CONVENTIONS:
        raise RobotError(f"DH convention {convention!r} is unknown, expected one of {', '.join(CONVENTIONS)}")
    count = int(np.size(a))
    if count == 0:
        raise RobotError("DH table is empty, expected at least one row")
    scale = factor(unit)
    rows = np.column_stack(
        [
            vector(a, count, "DH column a"),
            vector(alpha, count, "DH column alpha") * scale,
            vector(d, count, "DH column d"),
            vector(theta, count, "DH column theta") * scale,
        ]
    )
    kinds = ("revolute",) * count if joints is None else tuple(joints)
    if len(kinds) != count or not set(kinds) <= {"revolute", "prismatic"}:
        raise RobotError(f"DH joints is {list(kinds)}, expected {count} of 'revolute' or 'prismatic'")
    columns = dict(zip(("a", "alpha", "d", "theta"), rows.T.tolist(), strict=True))
    unlimited = np.array([[-np.inf] * count, [np.inf] * count])
    return Robot(
        name=name,
        joint_names=tuple(f"joint_{index + 1}" for index in range(count)),
        joint_types=kinds,
        position_limits=unlimited if position_limits is None else np.asarray(position_limits, dtype=float),
        velocity_limits=unlimited if velocity_limits is None else np.asarray(velocity_limits, dtype=float),
        torque_limits=unlimited,
        bare_model=_dh_model(pin, name, convention, rows, kinds),
        tool="tool",
        base="base",
        source=RobotSource(dh={"convention": convention, **columns, "joints": list(kinds)}),
    )


def _dh_model(pin: Any, name: str, convention: str, rows: Array, kinds: tuple[str, ...]) -> Any:
    """Return the massless `pin.Model`; every joint acts along its frame's z."""
    model = pin.Model()
    model.name = name
    model.addFrame(pin.Frame("base", 0, 0, pin.SE3.Identity(), pin.FrameType.BODY))
    after = np.eye(4)  # what lies between the previous joint's frame and this row's own transform
    for index, (length, twist, offset, angle) in enumerate(rows):
        across, along = _screw_x(length, twist), _screw_z(offset, angle)
        # Rotation about and translation along z commute, so the joint may act after the row's constant part.
        placement = after @ across @ along if convention == "modified" else after @ along
        joint = pin.JointModelPZ() if kinds[index] == "prismatic" else pin.JointModelRZ()
        model.addJoint(index, joint, pin.SE3(placement), f"joint_{index + 1}")
        after = np.eye(4) if convention == "modified" else across
    model.addFrame(pin.Frame("tool", len(kinds), 0, pin.SE3(after), pin.FrameType.BODY))
    return model
