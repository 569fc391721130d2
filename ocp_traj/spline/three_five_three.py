"""3-5-3 polynomials (papers B and D): a cubic, quintics, a cubic."""

from __future__ import annotations

from typing import Any

from ocp_traj.spline.family import Family, Piece, scaled_states
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
    takes_virtual_knots = False

    def pieces(self, durations: list[Any], positions: list[Any], ends: EndConditions) -> list[Piece]:
        """Return the pieces; see `Family.pieces`."""
        start = [positions[0], ends.start[1], ends.start[2]]
        end = [positions[-1], ends.end[1], ends.end[2]]
        second = cubic_end(start, positions[1], durations[0])
        # Run the last cubic backwards in time: velocity changes sign, acceleration does not.
        mirrored = cubic_end([end[0], -end[1], end[2]], positions[-2], durations[-1])
        last_but_one = [mirrored[0], -mirrored[1], mirrored[2]]
        inner = EndConditions(
            {1: second[1], 2: second[2]},
            {1: last_but_one[1], 2: last_but_one[2]},
        )
        middle = durations[1:-1]
        states = knot_states(5, middle, positions[1:-1], inner)
        quintics = [
            Piece(5, h, (*scaled_states(left, h), *scaled_states(right, h)))
            for h, left, right in zip(middle, states, states[1:])
        ]
        first = _cubic_piece(start, second, durations[0])
        return [first, *quintics, _cubic_piece(last_but_one, end, durations[-1])]


def cubic_end(start: list[Any], position: Any, h: Any) -> list[Any]:
    """End state of the cubic with start state (q, v, a) that reaches `position` after h."""
    q, v, a = start
    change = a * h
    slope = (position - q - (v + change / 2) * h) / h
    return [position, v + change + 3 * slope, a + 6 * slope / h]


def _cubic_piece(start: list[Any], end: list[Any], h: Any) -> Piece:
    return Piece(3, h, (*scaled_states(start[:2], h), *scaled_states(end[:2], h)))
