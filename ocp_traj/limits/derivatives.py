"""Limits of the position, velocity, acceleration and jerk of the joints."""

from __future__ import annotations

from ocp_traj.arrays import Array
from ocp_traj.limits.limit import Limit
from ocp_traj.quantities import DERIVATIVES
from ocp_traj.task import TrajectoryTask


class DerivativeLimit(Limit):
    """Bounds on one derivative of the joint positions, exact on polynomials.

    A motion s times slower has 1 / s^order of the derivative.

    Attributes
    ----------
    order : int
        0 position, 1 velocity, 2 acceleration, 3 jerk.
    """

    def __init__(self, order: int) -> None:
        self.order, self.name = order, DERIVATIVES[order]

    def bounds(self, task: TrajectoryTask) -> Array:
        """Return the (G, 2, n) lower and upper limits."""
        return task.limits.get(self.name)


DERIVATIVE_LIMITS = tuple(DerivativeLimit(order) for order in range(len(DERIVATIVES)))
"""The limits of position, velocity, acceleration and jerk, by order."""
