"""Lower and upper limits of a motion's quantities."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array, ArrayLike, read_only
from ocp_traj.exceptions import TaskError
from ocp_traj.quantities import JOINT_LIMITS

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot


@dataclass(frozen=True)
class Limits:
    """Lower and upper limits of joint quantities.

    Every entry is a number (symmetric, all joints), n numbers (symmetric), a (2, n) array [lower, upper], or a
    (G, 2, n) array, one block a gap between waypoints. ``None`` leaves it to the robot (position, velocity,
    acceleration, jerk, torque, where it has them) or unlimited; ``inf`` is explicitly unlimited. Inside a task every
    entry is (G, 2, n).

    Parameters
    ----------
    position : rad or m
    velocity : rad/s or m/s
    acceleration : rad/s^2 or m/s^2
    jerk : rad/s^3 or m/s^3
    torque : N m or N
    torque_rate : N m/s or N/s
    cartesian_speed : tuple of (frame, m/s)
        Bound on the norm of a named frame's linear velocity.
    others : mapping
        Limits of further quantities by the name of their row in `ocp_traj.quantities.JOINT_LIMITS`.
    """

    position: ArrayLike | None = None
    velocity: ArrayLike | None = None
    acceleration: ArrayLike | None = None
    jerk: ArrayLike | None = None
    torque: ArrayLike | None = None
    torque_rate: ArrayLike | None = None
    cartesian_speed: tuple[tuple[str, float], ...] = ()
    others: Mapping[str, ArrayLike] = field(default_factory=dict)

    def get(self, name: str) -> Array:
        """Return one limit, inside a task its (G, 2, n) array; None where there is none."""
        values: Any = self.others.get(name)
        return getattr(self, name, values)

    @property
    def names(self) -> list[str]:
        """Names of the joint limits: the six that have a field, and those of `others`."""
        return [name for name in JOINT_LIMITS if name in self.__dataclass_fields__ or name in self.others]

    def with_values(self, values: Mapping[str, ArrayLike]) -> Limits:
        """Return a copy with other joint limits, by name."""
        known = {name: value for name, value in values.items() if name in self.__dataclass_fields__}
        others = {name: value for name, value in values.items() if name not in known}
        return replace(self, others={**self.others, **others}, **known)  # type: ignore[arg-type]

    def expanded(self, gaps: int, n: int, robot: Robot | None) -> Limits:
        """Return limits with every entry a (gaps, 2, n) array; `robot` fills what was left out.

        Raises
        ------
        TaskError
            A name is unknown, a shape, a sign or the order of the bounds is wrong; names the limit.
        """
        for name in self.others:
            if name not in JOINT_LIMITS or name in self.__dataclass_fields__:
                expected = ", ".join(sorted(set(JOINT_LIMITS) - set(self.__dataclass_fields__))) or "none"
                raise TaskError(f"limits.{name}", f"is no further quantity, those known are: {expected}")
        expanded: dict[str, Any] = {}
        for name in self.names:
            given = self.get(name)
            value = default_limits(name, n, robot) if given is None else given
            expanded[name] = _expand_limit(name, value, gaps, n)
        for frame, speed in self.cartesian_speed:
            if not speed > 0:
                raise TaskError(
                    "limits.cartesian_speed", f"{speed} for frame {frame!r}, expected a positive speed"
                )
        return self.with_values(expanded)


def default_limits(name: str, n: int, robot: Robot | None) -> Array:
    """Return the (2, n) limits that hold where a task gives none: the robot's, else infinite ones.

    Efforts of a description without masses limit nothing, since its torques are not known.
    """
    row = JOINT_LIMITS[name]
    if robot is not None and row.from_robot and (robot.has_inertia or not row.needs_inertia):
        return getattr(robot, f"{name}_limits")
    return symmetric(np.inf, n)


def symmetric(limit: ArrayLike, n: int) -> Array:
    """Return the (2, n) lower and upper limits of one number or n numbers."""
    upper = np.broadcast_to(np.asarray(limit, dtype=np.float64), (n,))
    return np.stack([-upper, upper])


def _expand_limit(name: str, value: ArrayLike, gaps: int, n: int) -> Array:
    key = f"limits.{name}"
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise TaskError(key, f"{value!r} is not a number, {n} numbers or two rows of {n} numbers") from None
    if np.isnan(array).any():
        raise TaskError(key, "contains nan, expected numbers or inf")
    if array.ndim == 0 or array.shape == (n,):
        if (array < 0).any():
            raise TaskError(key, f"{array[array < 0].flat[0]:g} is negative, expected a limit of 0 or more")
        array = symmetric(array, n)
    if array.shape == (2, n):
        array = np.broadcast_to(array, (gaps, 2, n))
    if array.shape != (gaps, 2, n):
        raise TaskError(
            key,
            f"has shape {array.shape}, expected a number, {n} numbers or two rows (lower, upper) of {n} numbers",
        )
    if (array[:, 0] > array[:, 1]).any():
        joint = int(np.argwhere(array[:, 0] > array[:, 1])[0, 1])
        raise TaskError(key, f"the lower limit of joint {joint + 1} is above the upper one")
    if name != "position" and ((array[:, 0] > 0).any() or (array[:, 1] < 0).any()):
        raise TaskError(key, "the range of every joint must contain 0")
    return read_only(array)
