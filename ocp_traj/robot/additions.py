"""What a robot has besides its links: a payload at the tool, joint friction, joints that follow others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ocp_traj.arrays import Array, ArrayLike, read_only
from ocp_traj.exceptions import RobotError

STANDARD_GRAVITY = (0.0, 0.0, -9.81)
"""Default gravity in the base frame, m/s^2 (the value Pinocchio uses)."""


def vector(values: ArrayLike, length: int, name: str) -> Array:
    """Return `values` as a read-only vector of finite numbers.

    Raises
    ------
    RobotError
        The length is wrong or a value is not finite; `name` tells which argument.
    """
    array = read_only(values)
    if array.shape != (length,):
        raise RobotError(f"{name} has shape {array.shape}, expected ({length},)")
    if not np.all(np.isfinite(array)):
        raise RobotError(f"{name} is {array.tolist()}, expected finite numbers")
    return array


@dataclass(frozen=True)
class Payload:
    """A rigid body fixed to the tool frame.

    Parameters
    ----------
    mass : float
        kg, >= 0.
    com : (3,)
        Centre of mass in the tool frame, m.
    inertia : (6,)
        ixx, iyy, izz, ixy, ixz, iyz about the centre of mass, axes parallel to the tool frame, kg m^2.

    Raises
    ------
    RobotError
        The mass is negative, a shape is wrong, or the inertia is not that of a body (its tensor must be
        positive semidefinite and each principal moment at most the sum of the other two).
    """

    mass: float
    com: Array = field(default_factory=lambda: np.zeros(3))
    inertia: Array = field(default_factory=lambda: np.zeros(6))

    def __post_init__(self) -> None:
        mass = float(self.mass)
        if not (np.isfinite(mass) and mass >= 0.0):
            raise RobotError(f"payload mass is {self.mass} kg, expected a finite number >= 0")
        object.__setattr__(self, "mass", mass)
        object.__setattr__(self, "com", vector(self.com, 3, "payload com"))
        object.__setattr__(self, "inertia", vector(self.inertia, 6, "payload inertia"))
        moments = np.linalg.eigvalsh(self.tensor)
        slack = 1e-9 * max(float(np.max(np.abs(moments))), 1e-12)
        if moments[0] < -slack or moments[2] > moments[0] + moments[1] + slack:
            raise RobotError(
                f"payload inertia has principal moments {moments.tolist()} kg m^2, expected non-negative "
                "ones of which none exceeds the sum of the other two"
            )

    @property
    def tensor(self) -> Array:
        """Inertia tensor about the centre of mass, (3, 3), kg m^2."""
        ixx, iyy, izz, ixy, ixz, iyz = self.inertia
        return np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])


@dataclass(frozen=True)
class Friction:
    """Joint friction: the torque ``viscous * v + coulomb * sign(v)`` is added to the inverse dynamics.

    Parameters
    ----------
    viscous : (n,)
        N m s/rad (N s/m for prismatic joints), >= 0.
    coulomb : (n,)
        N m (N for prismatic joints), >= 0.
    """

    viscous: Array
    coulomb: Array

    def __post_init__(self) -> None:
        length = np.size(self.viscous)
        for name in ("viscous", "coulomb"):
            values = vector(getattr(self, name), length, f"{name} friction")
            if np.any(values < 0.0):
                raise RobotError(f"{name} friction is {values.tolist()}, expected numbers >= 0")
            object.__setattr__(self, name, values)

    @classmethod
    def none(cls, n: int) -> Friction:
        """Return zero friction for `n` joints."""
        return cls(viscous=np.zeros(n), coulomb=np.zeros(n))

    @property
    def is_zero(self) -> bool:
        """Whether neither kind of friction acts."""
        return not (np.any(self.viscous) or np.any(self.coulomb))


@dataclass(frozen=True, eq=False)
class Coupling:
    """The positions of the N joints of a model as affine functions of the n joints of a task.

    Parameters
    ----------
    joints : tuple of N str
        Names of the model's joints.
    matrix : (N, n)
        Velocity of every model joint per velocity of every task joint; a row has one entry.
    offset : (N,)
        Positions of the model's joints where the task's are zero, rad or m.

    Raises
    ------
    RobotError
        A shape is wrong or a number is not finite.
    """

    joints: tuple[str, ...]
    matrix: Array
    offset: Array

    def __post_init__(self) -> None:
        matrix, offset = read_only(self.matrix), read_only(self.offset)
        if matrix.ndim != 2 or len(matrix) != len(self.joints) or offset.shape != (len(self.joints),):
            raise RobotError(
                f"coupling of {len(self.joints)} joints has shapes {matrix.shape} and {offset.shape}, expected "
                "one row and one offset a joint"
            )
        if not (np.isfinite(matrix).all() and np.isfinite(offset).all()):
            raise RobotError("coupling has a number that is not finite")
        object.__setattr__(self, "matrix", matrix)
        object.__setattr__(self, "offset", offset)

    @classmethod
    def of(
        cls, joints: Sequence[str], leading: Sequence[str], rules: Mapping[str, tuple[str, float, float]]
    ) -> Coupling:
        """Return the coupling of `joints`, of which `leading` are the task's and all others follow by `rules`.

        Parameters
        ----------
        joints, leading : sequence of str
        rules : mapping
            The joint that each follower follows, its multiplier and its offset.

        Raises
        ------
        RobotError
            A joint is neither a leading one nor follows one.
        """
        matrix, offset = np.zeros((len(joints), len(leading))), np.zeros(len(joints))
        for row, name in enumerate(joints):
            driver, multiplier, offset[row] = rules.get(name, (name, 1.0, 0.0))
            if driver not in leading:
                raise RobotError(f"joint {name!r} follows {driver!r}, expected one of {', '.join(leading)}")
            matrix[row, leading.index(driver)] = multiplier
        return cls(tuple(joints), matrix, offset)

    @property
    def n(self) -> int:
        """Number of joints of the task."""
        return int(self.matrix.shape[1])

    def positions(self, q: Array) -> Array:
        """Return the positions (..., N) of the model's joints at those of the task (..., n)."""
        return q @ self.matrix.T + self.offset

    def rates(self, v: Array) -> Array:
        """Return velocities or accelerations (..., N) of the model's joints from those of the task (..., n)."""
        return v @ self.matrix.T

    def torques(self, tau: Array) -> Array:
        """Return the torques (..., n) of the task's joints that do the work of the model's (..., N)."""
        return tau @ self.matrix

    def symbols(self, *columns: Any) -> tuple[Any, ...]:
        """Return CasADi columns q, v, a of the model's joints from those of the task; any number of them."""
        import casadi as ca

        matrix = ca.DM(self.matrix)
        rates = [ca.mtimes(matrix, column) for column in columns]
        return (rates[0] + ca.DM(self.offset), *rates[1:])
