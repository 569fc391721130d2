"""What a constraint is: values with bounds, at every instant of a motion."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ocp_traj.arrays import Array

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask


@dataclass(frozen=True, eq=False)
class SymbolicSample:
    """The motion at one instant, as CasADi columns (n,).

    Attributes
    ----------
    task : TrajectoryTask
    q, v, a, j : position, velocity, acceleration, jerk
    """

    task: TrajectoryTask
    q: Any
    v: Any
    a: Any
    j: Any

    @cached_property
    def tau(self) -> Any:
        """Joint torques from inverse dynamics, N m (N for prismatic joints)."""
        assert self.task.robot is not None
        return self.task.robot.symbolic.inverse_dynamics(self.q, self.v, self.a)


class Constraint(ABC):
    """A limit, kept at every instant.

    Attributes
    ----------
    name : str
        As in reports, for instance ``velocity``.
    """

    name: str

    @abstractmethod
    def applies(self, task: TrajectoryTask) -> bool:
        """Return whether the task has such a limit."""


class DerivativeLimit(Constraint):
    """Bounds on one derivative of the joint positions, exact on polynomials.

    Attributes
    ----------
    order : int
        0 position, 1 velocity, 2 acceleration, 3 jerk.
    """

    order: ClassVar[int]

    def applies(self, task: TrajectoryTask) -> bool:
        """Return whether any joint has a finite limit."""
        return task.limited(self.name)

    def bounds(self, task: TrajectoryTask) -> Array:
        """Return the (G, 2, n) lower and upper limits."""
        return task.limits.get(self.name)


class SampledConstraint(Constraint):
    """Bounds on a function of (q, v, a, jerk, tau), imposed at samples and audited between them."""

    needs_jerk: bool = False

    @abstractmethod
    def expression(self, sample: SymbolicSample) -> Any:
        """Return the k values as an SX column."""

    @abstractmethod
    def bounds(self, task: TrajectoryTask) -> Array:
        """Return the (G, 2, k) lower and upper limits of the values."""

    def joints(self, task: TrajectoryTask) -> list[int]:
        """Return the joint (from 0) each value belongs to, -1 where it belongs to none."""
        return [-1] * self.bounds(task).shape[2]

    def scales(self, task: TrajectoryTask) -> Array:
        """Return what a violation is relative to, (G, k): the larger finite bound above zero, else 1."""
        return bound_scales(self.bounds(task))


def bound_scales(bounds: Array) -> Array:
    """Return the larger finite bound of (..., 2, k) bounds, 1 where there is none above zero, (..., k)."""
    magnitude = np.where(np.isfinite(bounds), np.abs(bounds), 0.0).max(axis=-2)
    scale: Array = np.where(magnitude > 0, magnitude, 1.0)
    return scale


def finite_joints(bounds: Array) -> list[int]:
    """Return the joints that have a finite limit in any gap of a (G, 2, n) array."""
    return [int(joint) for joint in np.flatnonzero(np.isfinite(bounds).any(axis=(0, 1)))]
