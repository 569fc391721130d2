"""One instant of a motion, (q, v, a, jerk, tau), and functions of it: what limits and costs are made of."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import casadi as ca

from ocp_traj.arrays import Array
from ocp_traj.quantities import SpeedLaw
from ocp_traj.task import TrajectoryTask


@dataclass(frozen=True, eq=False)
class Instant:
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

    @property
    def state(self) -> tuple[Any, Any, Any, Any]:
        """What a user's own functions take: q, v, a, tau, with zeros for tau in a task without inertia."""
        tau = self.tau if self.task.has_inertia else ca.SX.zeros(self.task.n)
        return self.q, self.v, self.a, tau


class Instants(Protocol):
    """Many instants of the motions of a population at once; arrays are (n, N, S, p)."""

    task: TrajectoryTask

    @property
    def torque(self) -> Array:
        """Joint torques."""

    def motion(self, order: int) -> Array:
        """Return a derivative of the positions."""

    def call(self, function: Any) -> Array:
        """Evaluate a CasADi function (q, v, a, j) -> (k,) everywhere, (k, N, S, p)."""


class FunctionOfInstant(ABC):
    """What a limit or a cost computes at one instant.

    Attributes
    ----------
    name : str
        Of its row in `ocp_traj.quantities`.
    needs_jerk : bool
        Whether the values depend on the jerk.
    """

    name: str
    needs_jerk: bool = False

    @abstractmethod
    def expression(self, instant: Instant) -> Any:
        """Return the k values as an SX column."""

    def function(self, task: TrajectoryTask) -> Any:
        """Return the CasADi function (q, v, a, j) -> values."""
        symbols = [ca.SX.sym(name, task.n) for name in "qvaj"]
        return ca.Function(self.name, symbols, [self.expression(Instant(task, *symbols))])

    def values(self, instants: Instants, function: Any) -> Array:
        """Return the values at many instants, (k, N, S, p); `function` is that of `function`."""
        return instants.call(function)

    def scaling(self, task: TrajectoryTask) -> SpeedLaw | None:
        """Return how the values go with the uniform speed of a motion, None where that is not known."""
        return None
