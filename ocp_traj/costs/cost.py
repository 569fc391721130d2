"""What a cost term is: the integral over the motion of a function of one instant."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from ocp_traj.limits.limit import SymbolicSample

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask


class Term(ABC):
    """A term of the cost.

    Attributes
    ----------
    name : str
        The weight's name in a case file.
    """

    name: ClassVar[str]

    def weight(self, task: TrajectoryTask) -> float:
        """Return the term's weight in the task."""
        value: float = getattr(task.objective, self.name)
        return value


class SquaredDerivative(Term):
    """Integral of the sum over joints of a squared derivative, exact on polynomials.

    Attributes
    ----------
    order : int
        2 acceleration, 3 jerk.
    """

    order: ClassVar[int]


class SampledTerm(Term):
    """Integral of a function of (q, v, a, tau), by a quadrature over samples.

    Attributes
    ----------
    shape : str
        How the values of `expression` become the integrand: their ``"sum"``, the sum of their ``"absolute"``
        values, or the sum of their ``"positive"`` parts. The kinks of the last two are kept exactly by one slack
        a sample and value, never smoothed.
    """

    shape: ClassVar[Literal["sum", "absolute", "positive"]] = "sum"

    @abstractmethod
    def expression(self, sample: SymbolicSample) -> Any:
        """Return the values as an SX column."""
