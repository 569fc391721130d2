"""What a spline family is: which coefficients are free, and which conditions hold between its pieces."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

from ocp_traj.spline.hermite import hermite_matrix
from ocp_traj.spline.interpolation import EndConditions, extra_orders, knot_states


@dataclass(frozen=True)
class Piece:
    """One polynomial piece: its degree, its duration and its scaled end states.

    `states` are q, h v, h^2 a, ... at the start, then at the end; the polynomial in tau = (t - t_k) / h has the
    ascending coefficients ``hermite_matrix(degree) @ states``.

    Parameters
    ----------
    degree : int
    duration : number, (P, 1) array or symbol, s
    states : tuple of degree + 1 entries
    """

    degree: int
    duration: Any
    states: tuple[Any, ...]

    def coefficients(self) -> list[Any]:
        """Return the ascending coefficients in normalised time, one entry a power."""
        matrix = hermite_matrix(self.degree)
        rows = []
        for row in matrix:
            terms = [weight * state for weight, state in zip(row, self.states) if weight != 0.0]
            total = terms[0]
            for term in terms[1:]:
                total = total + term
            rows.append(total)
        return rows


class Family(ABC):
    """A spline family; subclasses say how its pieces follow from durations and positions.

    Attributes
    ----------
    name : str
        The name in case files.
    degree : int
        Highest degree of a piece.
    continuity : int
        Number of continuous derivatives everywhere.
    takes_virtual_knots : bool
    """

    name: ClassVar[str]
    degree: ClassVar[int]
    continuity: ClassVar[int]
    takes_virtual_knots: ClassVar[bool] = True

    @abstractmethod
    def pieces(self, durations: list[Any], positions: list[Any], ends: EndConditions) -> list[Piece]:
        """Return the pieces of the family's curve.

        Parameters
        ----------
        durations : list of m entries, s
            Numbers, (P, 1) arrays or symbols.
        positions : list of m + 1 entries
            Positions at the knots, each broadcasting to (P, n); ``None`` where end conditions decide it.
        ends : EndConditions
        """

    def fixed_by_ends(self, ends: EndConditions) -> tuple[int, int]:
        """Return how many virtual-knot positions next to the start and to the end the end conditions decide."""
        return len(extra_orders(self.degree, ends.start)), len(extra_orders(self.degree, ends.end))


class UniformFamily(Family):
    """Pieces of one odd degree p joined with p - 1 continuous derivatives."""

    def pieces(self, durations: list[Any], positions: list[Any], ends: EndConditions) -> list[Piece]:
        """Return the pieces of the interpolating spline (see `knot_states`)."""
        states = knot_states(self.degree, durations, positions, ends)
        return [
            Piece(self.degree, h, (*scaled_states(start, h), *scaled_states(end, h)))
            for h, start, end in zip(durations, states, states[1:])
        ]


def scaled_states(states: list[Any], h: Any) -> list[Any]:
    """Return q, h v, h^2 a, ... of a knot state."""
    return [state if j == 0 else state * h**j for j, state in enumerate(states)]
