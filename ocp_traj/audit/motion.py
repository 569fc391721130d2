"""A trajectory made ready for judging: pieces on the unit interval, each with its gap between waypoints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ocp_traj.arrays import Array
from ocp_traj.audit.numerics.exact import PAIR_ROUNDING, Pair, distance, range_of, values_at_ends
from ocp_traj.audit.numerics.polynomials import candidate_points, differentiate, evaluate
from ocp_traj.quantities import DERIVATIVES
from ocp_traj.trajectory import Trajectory

_ROUNDING = 4.0 * np.finfo(np.float64).eps
_CANCELLING = 1e-8
"""Fraction of a piece's largest value that rounding may reach before rational arithmetic takes over."""

_LARGEST_LOG = 700.0
_UNDERFLOW = -290.0
_NEGLIGIBLE = -15.0
"""Logarithms to base 10 of the smallest terms held exactly, and of a jerk too small to matter."""



@dataclass(frozen=True)
class Motion:
    """Polynomial pieces over x = (t - start) / duration in [0, 1], whatever their length in seconds.

    Attributes
    ----------
    trajectory : Trajectory
        The motion; every waypoint time is one of its breakpoints.
    gaps : (m,) int array
        Gap between waypoints that each piece lies in, from 0.
    """

    trajectory: Trajectory
    gaps: NDArray[np.int64]

    @classmethod
    def of(cls, trajectory: Trajectory) -> Motion:
        """Prepare a trajectory whose waypoint times are known."""
        nearest = nearest_index(trajectory.breakpoints, trajectory.waypoint_times)
        gaps = np.searchsorted(nearest, np.arange(len(trajectory.breakpoints) - 1), side="right") - 1
        return cls(trajectory, np.clip(gaps, 0, len(trajectory.waypoint_times) - 2))

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.trajectory.n

    @cached_property
    def starts(self) -> Array:
        """Start time of each piece, (m,), s."""
        return np.asarray(self.trajectory.breakpoints[:-1])

    @cached_property
    def durations(self) -> Array:
        """Duration of each piece, (m,), s."""
        return np.diff(self.trajectory.breakpoints)

    @cached_property
    def coefficients(self) -> tuple[Array, ...]:
        """Coefficients over x of position and its first four derivatives in x, each (m, n, .)."""
        powers = self.durations[:, None] ** np.arange(self.trajectory.degree + 1.0)
        levels = [self.trajectory.coefficients * powers[:, None, :]]
        for _ in DERIVATIVES:
            flat = levels[-1].reshape(-1, levels[-1].shape[2])
            levels.append(differentiate(flat).reshape(*levels[-1].shape[:2], -1))
        return tuple(levels)

    @cached_property
    def _found(self) -> list[tuple[Array, Array]]:
        """`candidates` and `extrema` of every order."""
        base = self.coefficients[0]
        found = candidate_points(base.reshape(-1, base.shape[2]), len(DERIVATIVES))
        points = [x.reshape(base.shape[0], base.shape[1], -1) for x in found]
        return [self._made_exact(order, x, self.values(order, x)) for order, x in enumerate(points)]

    def _made_exact(self, order: int, x: Array, values: Array) -> tuple[Array, Array]:
        """Return points and values; where terms cancel, with the range that rational arithmetic finds."""
        cancelling = np.argwhere(self.rounding(order) > _CANCELLING * np.abs(values).max(axis=2))
        if not cancelling.size:
            return x, values
        x, values = (np.concatenate([array[:, :, :1], array, array[:, :, -1:]], axis=2) for array in (x, values))
        for piece, joint in cancelling:
            start, end = self.trajectory.breakpoints[piece : piece + 2]
            exact = range_of(self.trajectory.coefficients[piece, joint], float(start), float(end), order)
            low, x[piece, joint, 0], high, x[piece, joint, -1] = exact
            values[piece, joint] = np.clip(values[piece, joint], low, high)
            values[piece, joint, [0, -1]] = low, high
        return x, values

    @property
    def candidates(self) -> list[Array]:
        """Points x that include the extrema of position, velocity, acceleration and jerk, each (m, n, C)."""
        return [x for x, _ in self._found]

    @property
    def extrema(self) -> list[Array]:
        """Values at `candidates` in SI, each (m, n, C)."""
        return [values for _, values in self._found]

    @cached_property
    def largest(self) -> Array:
        """Largest magnitude of every order and joint, (4, n)."""
        return np.array([np.abs(values).max(axis=(0, 2)) for values in self.extrema])

    @cached_property
    def travel(self) -> float:
        """Largest range of positions of any joint, rad or m."""
        positions = self.extrema[0]
        return float((positions.max(axis=(0, 2)) - positions.min(axis=(0, 2))).max())

    def values(self, order: int, x: Array) -> Array:
        """Evaluate a derivative at points x (m, n, C) of each piece and joint, SI."""
        base = self.coefficients[order]
        flat = evaluate(base.reshape(-1, base.shape[2]), x.reshape(-1, x.shape[2])).reshape(x.shape)
        return flat / self.durations[:, None, None] ** order

    def sample(self, x: Array, pieces: NDArray[np.int64], order: int) -> Array:
        """Evaluate all joints at points x (S, C) of chosen pieces (S,), giving (S, C, n), SI."""
        base = self.coefficients[order][pieces]
        values = np.repeat(base[:, None, :, -1], x.shape[1], axis=1)
        for power in range(base.shape[2] - 2, -1, -1):
            values = values * x[:, :, None] + base[:, None, :, power]
        return values / self.durations[pieces][:, None, None] ** order

    def sample_joint(
        self, x: Array, pieces: NDArray[np.int64], joints: NDArray[np.int64], order: int
    ) -> Array:
        """Evaluate one joint (S,) at points x (S, C) of chosen pieces (S,), giving (S, C), SI."""
        values = evaluate(self.coefficients[order][pieces, joints], x)
        return values / self.durations[pieces][:, None] ** order

    def noise(self, order: int) -> Array:
        """Size of a derivative that rounding the positions to doubles can make, (m, n), SI.

        Markov's inequality: on an interval of length h a polynomial of degree D and size e has derivatives up
        to (2/h)^k e T_D^(k)(1), where T_D^(k)(1) is the product over i < k of (D^2 - i^2) / (2 i + 1).
        """
        degree = self.trajectory.degree
        factor = math.prod((degree**2 - i**2) / (2 * i + 1) for i in range(order))
        per_piece = factor * (2.0 / self.durations) ** order
        size: Array = _ROUNDING * np.multiply.outer(per_piece, self.largest[0])
        return size

    def rounding(self, order: int) -> Array:
        """Return a bound on what rounding does to the extrema of a derivative, (m, n), SI.

        Values, slopes and all higher derivatives are wrong by a few units in the last place of their terms, and
        each may misplace a root of the one before: the sum over j of k! / (k - j)! is below e k!.
        """
        base = np.abs(self.coefficients[0][:, :, order:])
        powers = range(order, order + base.shape[2])
        factorials = np.exp([min(math.lgamma(power + 1.0), _LARGEST_LOG) for power in powers])
        size: Array = (base * (np.e * _ROUNDING * factorials)).sum(axis=2)
        return size / self.durations[:, None] ** order

    @cached_property
    def is_in_range(self) -> bool:
        """True where derivatives are finite numbers and no term that matters is lost to underflow."""
        if not all(np.isfinite(values).all() for values in self.extrema):
            return False
        power = np.arange(self.trajectory.degree + 1.0)
        with np.errstate(divide="ignore"):
            size = np.log10(np.abs(self.trajectory.coefficients))
        length = np.log10(self.durations)[:, None, None]
        last = len(DERIVATIVES) - 1
        lost = (size > -np.inf) & ((power * length < _UNDERFLOW) | (size + power * length < _UNDERFLOW))
        in_jerk = size + (power - last) * length + last * np.log10(np.maximum(power, 1.0))
        return not bool((lost & (in_jerk > _NEGLIGIBLE)).any())

    def ends(self, order: int) -> tuple[Pair, Pair]:
        """Values at the start and at the end of every piece, each a pair of (m, n), SI."""
        return values_at_ends(self.trajectory.coefficients, self.trajectory.breakpoints, order)

    def steps(self, order: int) -> Array:
        """Return the magnitudes of the jumps of a derivative between pieces, (m - 1, n), SI."""
        start, end = self.ends(order)
        apart = distance((start[0][1:], start[1][1:]), (end[0][:-1], end[1][:-1]))
        terms = np.abs(self.coefficients[order]).sum(axis=2) / self.durations[:, None] ** order
        rounding = PAIR_ROUNDING * (self.trajectory.degree + 1) * terms
        uncertain: Array = rounding[1:] + rounding[:-1]
        return apart + uncertain


def nearest_index(breakpoints: Array, times: Array) -> NDArray[np.int64]:
    """Return the index of the breakpoint nearest to each time, (K,)."""
    right = np.clip(np.searchsorted(breakpoints, times), 1, len(breakpoints) - 1)
    return right - (times - breakpoints[right - 1] <= breakpoints[right] - times)
