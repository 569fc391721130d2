"""Uniform families: interpolating splines of one odd degree, as smooth as their degree allows."""

from __future__ import annotations

from typing import Any

from ocp_traj.spline.family import SHORTEST, Family, Piece, SplinePart, scaled_states
from ocp_traj.spline.interpolation import EndConditions, knot_states


class UniformFamily(Family):
    """Pieces of one odd degree p joined with p - 1 continuous derivatives."""

    @property
    def has_lifted_form(self) -> bool:
        """True, unless a subclass has pieces of its own."""
        return type(self).pieces is UniformFamily.pieces

    def pieces(self, durations: list[Any], positions: list[Any], ends: EndConditions) -> list[Piece]:
        """Return the pieces of the interpolating spline (see `knot_states`)."""
        states = knot_states(self.degree, durations, positions, ends)
        return [
            Piece(self.degree, h, (*scaled_states(start, h), *scaled_states(end, h)))
            for h, start, end in zip(durations, states, states[1:])
        ]

    def spline_part(self, durations: Any, positions: Any, ends: EndConditions) -> SplinePart | None:
        """Return the whole curve; see `Family.spline_part`."""
        return SplinePart(0, ends) if self.has_lifted_form else None


class Cubic(UniformFamily):
    """Cubic splines: C2, piecewise constant jerk (paper C; clamped, with three virtual knots per gap by default).

    End accelerations are zero by default where jerk is limited and there are knots enough for it, else free.
    """

    name = "cubic"
    degree = 3
    continuity = 2
    smoothness = "acceleration continuous; end accelerations zero by default where jerk is limited, else free"
    default_virtual_knots = 3
    first_virtual_knots = 1

    def default_end_orders(self, gaps: int, virtual_knots: int, jerk_limited: bool) -> tuple[int, ...]:
        """Return 1 and 2 where jerk is limited and the knots leave enough freedom, else 1."""
        enough = gaps * (virtual_knots + 1) > 2 and virtual_knots > 0
        return (1, 2) if jerk_limited and enough else self.end_orders

    def least_share(self, virtual_knots: int, still: bool) -> float:
        """Return the least fraction; with two knots or more the guess comes from a solution with fewer."""
        return 0.02 if virtual_knots > 1 else SHORTEST


class Quintic(UniformFamily):
    """Quintic interpolating splines: C4, end accelerations zero by default."""

    name = "quintic"
    degree = 5
    continuity = 4
    smoothness = "acceleration to snap continuous; zero end accelerations unless given"


class Septic(UniformFamily):
    """Septic interpolating splines (degree 7): C6, end accelerations and jerks zero by default (paper A)."""

    name = "septic"
    degree = 7
    continuity = 6
    smoothness = "continuous to the sixth derivative; zero end jerks unless given"
