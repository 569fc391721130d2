"""What a cost is: the integral over the motion of a function of one instant."""

from __future__ import annotations

from abc import ABC
from typing import Any, ClassVar, Literal

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.instant import FunctionOfInstant, Instants
from ocp_traj.task import TrajectoryTask


class Cost(ABC):
    """A term of the objective.

    Attributes
    ----------
    name : str
        The weight's name in a case file.
    """

    name: str

    def weight(self, task: TrajectoryTask) -> float:
        """Return the cost's weight in the task."""
        return task.objective.weight(self.name)


class InstantCost(FunctionOfInstant, Cost):
    """Integral of a function of (q, v, a, tau), by a quadrature over samples.

    Attributes
    ----------
    shape : str
        How the values of `expression` become the integrand: their ``"sum"``, the sum of their ``"absolute"``
        values, or the sum of their ``"positive"`` parts. The kinks of the last two are kept exactly by one slack
        per sample and value, never smoothed.
    """

    shape: ClassVar[Literal["sum", "absolute", "positive"]] = "sum"

    def integrand(self, instants: Instants, function: Any) -> Array:
        """Return the integrand at many instants, (N, S, p); `function` is that of `function`."""
        values = self.values(instants, function)
        if self.shape == "absolute":
            values = np.absolute(values)
        elif self.shape == "positive":
            values = np.maximum(values, 0.0)
        return np.asarray(values.sum(axis=0))
