r"""Lower bounds of the distance of two moving bodies over a whole interval of time.

For a unit vector n, the least of n . p over body B less the largest over body A is at most their distance, whoever
proposed n. Over an interval [m - h, m + h] two bounds hold of it, joints counted between the two bodies only:

- first order: what it is at m less sum_j delta_j R_j, where |q_j(t) - q_j(m)| <= delta_j and R_j is at least the
  distance of any point of the body from the axis of joint j, at any time of the interval;
- second order: with the velocities at m, each point moves n . p by no less than
  (n + tau n x omega) . p + tau n . v0 - h^2 / 2 (sum_j R_j a_j + sum_ij R_max(i,j) v_i v_j), because
  d^2 p / dq_i dq_j = z_i x (z_j x (p - o_j)) for i <= j. The least over tau is at an end of the interval: a least of
  linear functions is concave.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ocp_traj.arrays import Array
from ocp_traj.audit.clearance.placements import Placements
from ocp_traj.collision.bodies import Convex

Index = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Stretch:
    """A motion over intervals of time, each inside one polynomial piece.

    Attributes
    ----------
    half : (k,)
        Half lengths, s.
    q, v : (k, n)
        At the middle.
    travel, speed, acceleration : (k, n)
        Bounds over the interval of |q(t) - q(middle)|, |q'| and |q''|.
    """

    half: Array
    q: Array
    v: Array
    travel: Array
    speed: Array
    acceleration: Array

    @classmethod
    def of(cls, coefficients: Array, middle: Array, half: Array) -> Stretch:
        """Bound pieces (k, n, d + 1), ascending powers of the time from their start, about their `middle` (k,)."""
        local = coefficients.copy()
        count = local.shape[2]
        for low in range(count - 1):  # repeated synthetic division: Taylor's coefficients at the middle
            for power in range(count - 2, low - 1, -1):
                local[:, :, power] += local[:, :, power + 1] * middle[:, None]
        powers = half[:, None] ** np.arange(count)
        order = np.arange(count, dtype=np.float64)
        size = np.abs(local) * powers[:, None, :]
        inverse = 1.0 / half[:, None]
        velocity = local[:, :, 1] if count > 1 else np.zeros_like(local[:, :, 0])
        return cls(
            half=half,
            q=local[:, :, 0],
            v=velocity,
            travel=size[:, :, 1:].sum(axis=2),
            speed=(size * order).sum(axis=2) * inverse,
            acceleration=(size * order * (order - 1.0)).sum(axis=2) * inverse**2,
        )


@dataclass(frozen=True)
class Frames:
    """Placements, axes and origins of all joints at the middles of intervals.

    Attributes
    ----------
    places : (k, n + 1, 4, 4)
    axes, origins : (k, n, 3)
    sliding : list of n bool
    """

    places: Array
    axes: Array
    origins: Array
    sliding: list[bool]

    @classmethod
    def of(cls, kinematics: Placements, q: Array) -> Frames:
        """Return the frames at configurations (k, n)."""
        places = kinematics.at(q)
        axes = np.einsum("kjab,jb->kja", places[:, 1:, :3, :3], kinematics.axes)
        return cls(places, axes, places[:, 1:, :3, 3], kinematics.sliding)


@dataclass(frozen=True)
class Side:
    """One body of every row: which, where, and what moves it.

    Attributes
    ----------
    bodies : sequence of Convex
        All bodies.
    number : (r,)
        Which of them.
    place : (r, 4, 4)
        Of the joint that carries it, at the middle.
    movers : (r, n)
        Joints that move it with respect to the other body's side.
    centre : (r, 3), ball : (r,)
        A ball that holds it, in the root's frame at the middle.
    """

    bodies: Sequence[Convex]
    number: Index
    place: Array
    movers: Mask
    centre: Array
    ball: Array

    def rows(self, chosen: Index | Mask) -> Side:
        """Return some of the rows."""
        return Side(
            self.bodies,
            self.number[chosen],
            self.place[chosen],
            self.movers[chosen],
            self.centre[chosen],
            self.ball[chosen],
        )

    def lowest(self, direction: Array) -> Array:
        """Return the least of direction . p over each row's body at the middle, (r,)."""
        local = np.einsum("rji,rj->ri", self.place[:, :3, :3], direction)
        values = np.empty(len(local))
        order = np.argsort(self.number, kind="stable")
        ends = np.flatnonzero(np.diff(self.number[order])) + 1
        for group in np.split(order, ends):
            if len(group):
                values[group] = self.bodies[self.number[group[0]]].lowest(local[group])
        return np.asarray(values + (direction * self.place[:, :3, 3]).sum(axis=1))

    def levers(self, frames: Frames, interval: Index, travel: Array) -> Array:
        """Return bounds over the interval of the distances of the body's points from the joints' axes, (r, n).

        Parameters
        ----------
        frames : Frames
        interval : (r,)
            Interval of each row.
        travel : (r, n)
        """
        levers = np.zeros_like(travel)
        swing = np.zeros(len(levers))
        for joint in reversed(range(len(frames.sliding))):  # what distal joints do widens the nearer levers
            if not self.movers[:, joint].any():
                continue
            if frames.sliding[joint]:
                reach = np.ones(len(levers))
            else:
                arm = self.centre - frames.origins[interval, joint]
                axis = frames.axes[interval, joint]
                along = (arm * axis).sum(axis=1)
                across = np.sqrt(np.maximum((arm * arm).sum(axis=1) - along * along, 0.0))
                reach = across + self.ball + swing
            levers[:, joint] = np.where(self.movers[:, joint], reach, 0.0)
            swing += travel[:, joint] * levers[:, joint]
        return levers

    def bend(self, levers: Array, stretch: Stretch, interval: Index) -> Array:
        """Return a bound of the acceleration of the body's points over the interval, (r,), m/s^2."""
        speed = np.where(self.movers, stretch.speed[interval], 0.0)
        total = np.cumsum(speed, axis=1)
        along = (levers * stretch.acceleration[interval]).sum(axis=1)
        return np.asarray(along + (levers * speed * (2.0 * total - speed)).sum(axis=1))

    def lowest_at_ends(self, direction: Array, frames: Frames, stretch: Stretch, interval: Index) -> Array:
        """Return the least of direction . p at both ends if all points kept their velocities, (2, r)."""
        rates = np.where(self.movers, stretch.v[interval], 0.0)
        turn, drift = np.zeros_like(direction), np.zeros_like(direction)
        for joint in np.flatnonzero(self.movers.any(axis=0)):
            axis = frames.axes[interval, joint]
            rate = rates[:, joint, None]
            if frames.sliding[joint]:
                drift += rate * axis
            else:
                turn += rate * axis
                drift += rate * np.cross(frames.origins[interval, joint], axis)
        tilt, shift = np.cross(direction, turn), (direction * drift).sum(axis=1)
        half = stretch.half[interval]
        return np.stack(
            [self.lowest(direction + tau[:, None] * tilt) + tau * shift for tau in (-half, half)]
        )


def separation(a: Side, b: Side, normal: Array) -> Array:
    """Return how far a plane with this normal (r, 3), from a to b, separates the bodies at the middle, (r,), m."""
    return b.lowest(normal) + a.lowest(-normal)


def second_order(
    a: Side,
    b: Side,
    normal: Array,
    levers: tuple[Array, Array],
    frames: Frames,
    stretch: Stretch,
    interval: Index,
) -> Array:
    """Return the second-order bound of the distance over each row's interval, (r,), m.

    Parameters
    ----------
    a, b : Side
    normal : (r, 3)
        Unit vectors from a to b.
    levers : two (r, n)
        Of a and of b.
    frames : Frames
    stretch : Stretch
    interval : (r,)
    """
    ends = b.lowest_at_ends(normal, frames, stretch, interval)
    bend = b.bend(levers[1], stretch, interval)
    if a.movers.any():
        ends = ends + a.lowest_at_ends(-normal, frames, stretch, interval)
        bend = bend + a.bend(levers[0], stretch, interval)
    else:
        ends = ends + a.lowest(-normal)
    return np.asarray(ends.min(axis=0) - 0.5 * stretch.half[interval] ** 2 * bend)
