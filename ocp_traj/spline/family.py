"""What a spline family is: which coefficients are free, and which conditions hold between its pieces."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

from ocp_traj.spline.hermite import hermite_matrix
from ocp_traj.spline.interpolation import EndConditions, extra_orders

SHORTEST = 1e-3
"""Least duration of a segment, as a fraction of an even share of its gap in the guess."""


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


@dataclass(frozen=True)
class SplinePart:
    """The pieces of a curve that are a spline of the family's degree p with p - 1 continuous derivatives.

    Parameters
    ----------
    outside : int
        Pieces before it, and as many after it, that are not.
    ends : EndConditions
        At the first and the last knot of the part.
    """

    outside: int
    ends: EndConditions


class Family(ABC):
    """A spline family; subclasses say how its pieces follow from durations and positions.

    A family is a value: two of one name are equal, and one equals its name.

    Attributes
    ----------
    name : str
        The name in case files.
    degree : int
        Highest degree of a piece.
    continuity : int
        Number of continuous derivatives everywhere.
    smoothness : str
        For people.
    takes_virtual_knots : bool
    takes_end_conditions : bool
        Whether a task may give or free end accelerations and jerks otherwise than by default.
    least_waypoints : int
    default_virtual_knots : int
        Virtual knots per gap of a task that names none.
    first_virtual_knots : int
        Virtual knots per gap from whose motion a gradient solver continues to more.
    """

    name: ClassVar[str]
    degree: ClassVar[int]
    continuity: ClassVar[int]
    smoothness: ClassVar[str] = ""
    takes_virtual_knots: ClassVar[bool] = True
    takes_end_conditions: ClassVar[bool] = True
    least_waypoints: ClassVar[int] = 2
    default_virtual_knots: ClassVar[int] = 0
    first_virtual_knots: ClassVar[int] = 0

    def __eq__(self, other: object) -> bool:
        """Whether the other is a family of this name, or the name."""
        return self.name == (other.name if isinstance(other, Family) else other)

    def __hash__(self) -> int:
        """Return the hash of the name."""
        return hash(self.name)

    def __repr__(self) -> str:
        """Return the call that makes the family."""
        return f"{type(self).__name__}()"

    def __str__(self) -> str:
        """Return the name."""
        return self.name

    @property
    def end_orders(self) -> tuple[int, ...]:
        """Orders of the derivatives that the plain spline through the waypoints has zero at its ends: 1 to (p-1)/2."""
        return tuple(range(1, (self.degree + 1) // 2))

    def default_end_orders(self, gaps: int, virtual_knots: int, jerk_limited: bool) -> tuple[int, ...]:
        """Return the orders of the derivatives that vanish at both ends of a task that says nothing of them.

        Parameters
        ----------
        gaps : int
            Between waypoints.
        virtual_knots : int
            Per gap.
        jerk_limited : bool
            Whether any joint has a limit of its jerk.
        """
        return self.end_orders

    @property
    def has_lifted_form(self) -> bool:
        """Whether the curve is a chain of integrators in each segment: p - 1 continuous derivatives of degree p."""
        return False

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

    def spline_part(self, durations: Any, positions: Any, ends: EndConditions) -> SplinePart | None:
        """Return which pieces are one spline, so that populations solve it at once; None where none are known.

        Parameters
        ----------
        durations, positions, ends
            See `pieces`; arrays whose first axis is the piece or the knot do, too.
        """
        return None

    def degrees(self, segments: int) -> tuple[int, ...]:
        """Return the degree of each of the pieces that `spline_part` and its neighbours are."""
        return (self.degree,) * segments

    def fixed_by_ends(self, ends: EndConditions) -> tuple[int, int]:
        """Return how many virtual-knot positions next to the start and to the end the end conditions decide."""
        return len(extra_orders(self.degree, ends.start)), len(extra_orders(self.degree, ends.end))

    def free_coefficients(self, segments: int) -> int:
        """Return how many coefficients of one joint the continuity conditions leave free."""
        return segments * (self.degree - self.continuity) + self.continuity + 1

    def least_share(self, virtual_knots: int, still: bool) -> float:
        """Return the least duration of a segment in the lifted form, as a fraction of an even share of its gap.

        Where knots meet, derivatives that are continuous there grow without bound, and the best motion is a limit
        that no solver reaches; without travel nothing keeps a segment from vanishing.

        Parameters
        ----------
        virtual_knots : int
            Per gap.
        still : bool
            No joint travels in the gap.
        """
        return 0.1 if virtual_knots or still else SHORTEST


def scaled_states(states: list[Any], h: Any) -> list[Any]:
    """Return q, h v, h^2 a, ... of a knot state."""
    return [state if j == 0 else state * h**j for j, state in enumerate(states)]
