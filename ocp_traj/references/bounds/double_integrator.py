"""What a joint with bounded velocity and acceleration can reach: the exact test behind the kinematic bound.

In a time h, from velocity v0 to v1, a joint can travel every distance d in [d_min, d_max] and no other: the
admissible controls are a convex set and d is linear in them. d_min belongs to the profile that brakes, waits at
the lowest velocity w and speeds up again,

    d_min(h, v0, v1) = min over w >= -V of  w h + (w - v0)^2 / (2 B) + (w - v1)^2 / (2 A),

with acceleration A, deceleration B and |v1 - v0| small enough; d_max mirrors it. For fixed h the set of possible
(v0, v1) is therefore convex, and the velocities that can be reached at the end of a gap are an interval with ends
in closed form. The durations are feasible for a joint if and only if 0 survives to the end of that chain of
intervals. They are not an interval: with v0 and v1 away from zero a longer gap can be impossible (d_min > d).

For durations in a box the same is done with d_min at both ends of each h, as d_min is concave in h (a minimum of
functions linear in h); that relaxation contains every motion, and is exact where the box is a point.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ocp_traj.arrays import Array
from ocp_traj.deadline import Deadline

BoolArray: TypeAlias = npt.NDArray[np.bool_]

PADDING = 1e-11
"""Relative widening of velocity and acceleration limits, against rounding."""

SECTIONS, ROUNDS = 64, 8
"""Totals tried at once, and how often, until they agree to 48 bits."""

CLOSE = 1e-3
"""Relative distance of two totals that will do when time is up."""


@dataclass(frozen=True)
class JointLimits:
    """Limits and distances of n joints over G gaps.

    Attributes
    ----------
    fastest, slowest : (G, n) arrays
        Largest velocity forwards and backwards, both >= 0, rad/s.
    speeding, braking : (G, n) arrays
        Largest acceleration upwards and downwards, both > 0, rad/s^2.
    nearest, farthest : (G, n) arrays
        Least and largest distance to travel in each gap, rad; equal without tolerance.
    start, end : (2, n) arrays
        Least and largest velocity before the first and after the last gap; zero for rest.
    """

    fastest: Array
    slowest: Array
    speeding: Array
    braking: Array
    nearest: Array
    farthest: Array
    start: Array
    end: Array

    @property
    def gaps(self) -> int:
        """Number of gaps."""
        return len(self.fastest)

    def part(self, first: int, last: int) -> JointLimits:
        """Return gaps `first` to `last` (exclusive) alone; inner ends may have any velocity within the limits."""
        rows = slice(first, last)
        start = self.start if first == 0 else self._allowed(first)
        end = self.end if last == self.gaps else self._allowed(last)
        return replace(
            self,
            fastest=self.fastest[rows],
            slowest=self.slowest[rows],
            speeding=self.speeding[rows],
            braking=self.braking[rows],
            nearest=self.nearest[rows],
            farthest=self.farthest[rows],
            start=start,
            end=end,
        )

    def _allowed(self, waypoint: int) -> Array:
        lower = -np.minimum(self.slowest[waypoint - 1], self.slowest[waypoint])
        return np.stack([lower, np.minimum(self.fastest[waypoint - 1], self.fastest[waypoint])])


def feasible(limits: JointLimits, shortest: Array, longest: Array) -> BoolArray:
    """Return whether some motion may exist with durations in each box, (P,) bool.

    Parameters
    ----------
    limits : JointLimits
    shortest, longest : (P, G) arrays
        Boxes of durations, s. Where both agree the answer is exact (for zero tolerance); otherwise False is a
        proof and True is not.
    """
    possible = np.ones(len(shortest), dtype=bool)
    low = np.broadcast_to(limits.start[0], (len(shortest), limits.start.shape[1]))
    high = np.broadcast_to(limits.start[1], low.shape)
    for gap in range(limits.gaps):
        h = (
            [shortest[:, gap, None]]
            if longest is shortest
            else [shortest[:, gap, None], longest[:, gap, None]]
        )
        low, high, alive = _cross_gap(limits, gap, low, high, h)
        low, high = (
            np.where(alive, low, 0.0),
            np.where(alive, high, 0.0),
        )  # the row is lost, numbers stay finite
        possible &= alive.all(axis=1)
    slack = PADDING * (limits.fastest[-1] + limits.slowest[-1])
    return possible & ((low <= limits.end[1] + slack) & (high >= limits.end[0] - slack)).all(
        axis=1
    )


def _cross_gap(
    limits: JointLimits, gap: int, low: Array, high: Array, ends: list[Array]
) -> tuple[Array, Array, BoolArray]:
    """Return the interval of velocities after a gap, (P, n) twice, and whether it is not empty.

    `ends` holds the least and the largest duration of the gap, (P, 1) each, or only one where they are the same.
    """
    wide = 1.0 + PADDING
    fastest, slowest = limits.fastest[gap] * wide, limits.slowest[gap] * wide
    up, down = limits.speeding[gap] * wide, limits.braking[gap] * wide
    near, far = limits.nearest[gap], limits.farthest[gap]
    low, high = np.maximum(low, -slowest), np.minimum(high, fastest)
    alive = (low <= high) & _can_stay_behind(far, low, slowest, down, ends)
    alive &= _can_stay_behind(-near, -high, fastest, up, ends)
    top = _highest_velocity(far, low, high, fastest, slowest, up, down, ends)
    bottom = -_highest_velocity(-near, -high, -low, slowest, fastest, down, up, ends)
    return bottom, top, alive & (bottom <= top)


def _can_stay_behind(far: Array, low: Array, slowest: Array, down: Array, ends: list[Array]) -> BoolArray:
    """Return whether braking fully from velocity `low` keeps the distance at `far` or less for some h.

    That distance is concave in h, so both ends of the interval of h are enough.
    """
    braking_time = (np.maximum(low, -slowest) + slowest) / down
    least = np.full(np.broadcast_shapes(low.shape, ends[-1].shape), np.inf)
    for h in ends:
        braked = np.minimum(h, braking_time)
        least = np.minimum(least, low * braked - 0.5 * down * braked**2 - slowest * (h - braked))
    return least <= far + 1e-14 * (1.0 + np.abs(far))


def _highest_velocity(
    far: Array,
    low: Array,
    high: Array,
    fastest: Array,
    slowest: Array,
    up: Array,
    down: Array,
    ends: list[Array],
) -> Array:
    """Return the largest velocity after the gap with d_min <= far, from a velocity in [low, high]."""
    top = np.full(np.broadcast_shapes(low.shape, ends[-1].shape), -np.inf)
    for h in ends:
        h = np.maximum(h, 1e-300)
        straight = far / h + 0.5 * up * h  # reached by speeding up all the time, which starts from:
        begin = far / h - 0.5 * up * h
        square = (down * h**2 - 2.0 * (low * h - far)) / (up + down)  # time spent speeding up, squared
        rising = np.sqrt(np.maximum(square, 0.0))
        valley = low - down * (h - rising)
        touched = valley + up * rising
        room = far + slowest * h - 0.5 * (low + slowest) ** 2 / down
        waited = -slowest + np.sqrt(np.maximum(2.0 * up * room, 0.0))
        reached = np.where(valley < -slowest, waited, touched)
        impossible = np.where(valley < -slowest, room < 0, square < 0)
        reached = np.where(impossible, -np.inf, reached)
        top = np.maximum(top, np.where(low <= begin, straight, reached))
    return np.asarray(np.minimum(np.minimum(top, fastest), high + up * ends[-1]))


def shortest_total(limits: JointLimits, proportions: Array, largest: float, iterations: int = 60) -> Array:
    """Return the least total duration (P,) for each row of proportions (P, G), s; infinite above `largest`.

    From rest to rest a motion can be slowed uniformly, so the feasible totals of fixed proportions are an interval
    without upper end, and bisection finds its lower end.
    """
    low, high = np.zeros(len(proportions)), np.full(len(proportions), largest)
    known = _feasible_points(limits, proportions * largest)
    for _ in range(iterations):
        middle = 0.5 * (low + high)
        good = _feasible_points(limits, proportions * middle[:, None])
        high, low = np.where(good, middle, high), np.where(good, low, middle)
    return np.where(known, high, np.inf)


def least_total(limits: JointLimits, proportions: Array, largest: float, deadline: Deadline) -> float:
    """Return the least total duration of one row of proportions (G,), s; infinite above `largest`.

    As `shortest_total`, with many totals tried at once: long chains of gaps are slow to cross, however few the rows.
    When time is up, the least total known to be long enough is returned.
    """
    low, high = 0.0, np.inf
    totals = np.linspace(0.0, largest, SECTIONS + 1)[1:]
    for _ in range(ROUNDS):
        good = _feasible_points(limits, totals[:, None] * proportions)
        high = float(totals[good].min(initial=high))
        low = float(totals[~good & (totals < high)].max(initial=low))
        if not np.isfinite(high) or (deadline.passed and high - low < CLOSE * high):
            break
        totals = np.linspace(low, high, SECTIONS + 1)[1:-1]
    return high


def _feasible_points(limits: JointLimits, durations: Array) -> BoolArray:
    return feasible(limits, durations, durations)
