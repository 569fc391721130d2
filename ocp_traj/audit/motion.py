"""A trajectory made ready for judging: pieces on the unit interval, each with its gap between waypoints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ocp_traj.arrays import Array
from ocp_traj.audit.polynomials import candidate_points, differentiate, evaluate
from ocp_traj.quantities import DERIVATIVES
from ocp_traj.trajectory import Trajectory

_ROUNDING = 4.0 * np.finfo(np.float64).eps


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
        middles = 0.5 * (trajectory.breakpoints[1:] + trajectory.breakpoints[:-1])
        gaps = np.searchsorted(trajectory.waypoint_times, middles, side="right") - 1
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
    def candidates(self) -> list[Array]:
        """Points x that include the extrema of position, velocity, acceleration and jerk, each (m, n, C)."""
        base = self.coefficients[0]
        found = candidate_points(base.reshape(-1, base.shape[2]), len(DERIVATIVES))
        return [points.reshape(base.shape[0], base.shape[1], -1) for points in found]

    @cached_property
    def extrema(self) -> list[Array]:
        """Values at `candidates` in SI, each (m, n, C)."""
        return [self.values(order, self.candidates[order]) for order in range(len(DERIVATIVES))]

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
        return _ROUNDING * np.multiply.outer(per_piece, self.largest[0])

    def ends(self, order: int) -> tuple[Array, Array]:
        """Values at the start and at the end of every piece, each (m, n), SI."""
        base = self.coefficients[order]
        scale = self.durations[:, None] ** order
        return base[:, :, 0] / scale, base.sum(axis=2) / scale
