"""Smoothness: integrals of squared acceleration and of squared jerk."""

from __future__ import annotations

from ocp_traj.costs.cost import Cost
from ocp_traj.quantities import DERIVATIVES


class SquaredDerivative(Cost):
    """Integral of the sum over joints of a squared derivative, exact on polynomials.

    At uniform speed r it is r^(2 order - 1) times as large.

    Attributes
    ----------
    order : int
        2 acceleration, 3 jerk.
    """

    def __init__(self, order: int) -> None:
        self.order, self.name = order, DERIVATIVES[order]


SQUARED_DERIVATIVES = (SquaredDerivative(2), SquaredDerivative(3))
"""The costs that are exact integrals of polynomials."""
