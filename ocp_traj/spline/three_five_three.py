"""3-5-3 polynomials (papers B and D): a cubic, quintics, a cubic."""

from __future__ import annotations

from typing import Any

from ocp_traj.spline.family import Family, Piece, SplinePart, scaled_states
from ocp_traj.spline.interpolation import EndConditions, knot_states


class ThreeFiveThree(Family):
    """Cubic, quintic..., cubic through at least four waypoints.

    Position, velocity and acceleration are given at both ends and continuous everywhere; where two quintics meet,
    jerk and snap are continuous too (C4). The first cubic is fixed by the start state and the second waypoint, the
    last one likewise, so velocity and acceleration at the second and the last but one waypoint follow from the
    first and the last duration alone (derived, not copied: B's Eq 28 and 31 and D's Eq 6 are misprinted).
    """

    name = "3-5-3"
    degree = 5
    continuity = 2
    smoothness = "cubic, quintics, cubic; needs at least four waypoints"
    takes_virtual_knots = False
    takes_end_conditions = False
    least_waypoints = 4

    def pieces(self, durations: list[Any], positions: list[Any], ends: EndConditions) -> list[Piece]:
        """Return the pieces; see `Family.pieces`."""
        inner = self.spline_part(durations, positions, ends).ends
        states = knot_states(5, durations[1:-1], positions[1:-1], inner)
        quintics = [
            Piece(5, h, (*scaled_states(left, h), *scaled_states(right, h)))
            for h, left, right in zip(durations[1:-1], states, states[1:])
        ]
        second, last_but_one = [positions[1], inner.start[1]], [positions[-2], inner.end[1]]
        first = _cubic_piece([positions[0], ends.start[1]], second, durations[0])
        return [first, *quintics, _cubic_piece(last_but_one, [positions[-1], ends.end[1]], durations[-1])]

    def spline_part(self, durations: Any, positions: Any, ends: EndConditions) -> SplinePart:
        """Return the quintics, with the velocities and accelerations of the cubics beside them."""
        v, a = cubic_end([positions[0], ends.start[1], ends.start[2]], positions[1], durations[0])
        # Run the last cubic backwards in time: velocity changes sign, acceleration does not.
        w, b = cubic_end([positions[-1], -ends.end[1], ends.end[2]], positions[-2], durations[-1])
        return SplinePart(1, EndConditions({1: v, 2: a}, {1: -w, 2: b}))

    def degrees(self, segments: int) -> tuple[int, ...]:
        """Return 3, 5, ..., 5, 3."""
        return (3, *(5,) * (segments - 2), 3)


def cubic_end(start: list[Any], position: Any, h: Any) -> tuple[Any, Any]:
    """End velocity and acceleration of the cubic with start state (q, v, a) that reaches `position` after h."""
    q, v, a = start
    change = a * h
    slope = (position - q - (v + change / 2) * h) / h
    return v + change + 3 * slope, a + 6 * slope / h


def _cubic_piece(start: list[Any], end: list[Any], h: Any) -> Piece:
    return Piece(3, h, (*scaled_states(start, h), *scaled_states(end, h)))
