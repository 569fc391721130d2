"""What a limit is: values with bounds, at every instant of a motion."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.instant import FunctionOfInstant, Instant
from ocp_traj.task import TrajectoryTask


class Limit(ABC):
    """A limit, kept at every instant.

    Attributes
    ----------
    name : str
        As in reports, for instance ``velocity``.
    """

    name: str

    def applies(self, task: TrajectoryTask) -> bool:
        """Return whether the task has such a limit: whether any joint has a finite one."""
        return task.limited(self.name)

    @abstractmethod
    def bounds(self, task: TrajectoryTask) -> Array:
        """Return the (G, 2, k) lower and upper limits of the values."""


class InstantLimit(FunctionOfInstant, Limit):
    """Bounds on a function of (q, v, a, jerk, tau), imposed at samples and audited between them."""

    def joints(self, task: TrajectoryTask) -> list[int]:
        """Return the joint (from 0) each value belongs to, -1 where it belongs to none."""
        return [-1] * self.bounds(task).shape[2]

    def scales(self, task: TrajectoryTask) -> Array:
        """Return what a violation is relative to, (G, k): the larger finite bound above zero, else 1."""
        return bound_scales(self.bounds(task))


class JointLimit(InstantLimit):
    """Bounds on one value of every joint, those of the row of `JOINT_LIMITS` that has the limit's name."""

    @abstractmethod
    def value(self, instant: Instant) -> Any:
        """Return the values of all joints as an SX column (n,)."""

    def expression(self, instant: Instant) -> Any:
        """Return the values of the limited joints."""
        return self.value(instant)[self.joints(instant.task)]

    def bounds(self, task: TrajectoryTask) -> Array:
        """Return the limits of the limited joints."""
        return task.limits.get(self.name)[:, :, self.joints(task)]

    def joints(self, task: TrajectoryTask) -> list[int]:
        """Return the limited joints."""
        return finite_joints(task.limits.get(self.name))


def bound_scales(bounds: Array, fallback: Any = 1.0) -> Array:
    """Return the larger finite bound of (..., 2, k) bounds, `fallback` where there is none above zero, (..., k)."""
    magnitude = np.where(np.isfinite(bounds), np.abs(bounds), 0.0).max(axis=-2)
    return np.where(magnitude > 0, magnitude, fallback)


def finite_joints(bounds: Array) -> list[int]:
    """Return the joints that have a finite limit in any gap of a (G, 2, n) array."""
    return [int(joint) for joint in np.flatnonzero(np.isfinite(bounds).any(axis=(0, 1)))]
