"""The exact piecewise polynomial that every solver's answer becomes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ocp_traj.arrays import Array, ArrayLike, read_only
from ocp_traj.exceptions import InputError


@dataclass(frozen=True)
class Trajectory:
    """A joint motion as an exact piecewise polynomial in time.

    Parameters
    ----------
    breakpoints : (m + 1,) array
        Strictly increasing times of the polynomial pieces, s; the first is 0.
    coefficients : (m, n, degree + 1) array
        Ascending powers of ``t - breakpoints[k]``, in rad (m for prismatic joints) and s.
    waypoint_times : (K,) array
        When each waypoint is passed, s; a subset of the breakpoints. Equal waypoints that follow one another are
        one point and have the same time.
    family, case : str
        Name of the spline family and of the case, carried into files.

    Examples
    --------
    >>> parabola = Trajectory([0.0, 2.0], [[[1.0, 0.0, 0.5]]], [0.0, 2.0])  # 1 + t^2 / 2
    >>> parabola([0.0, 1.0, 2.0]).ravel().tolist()
    [1.0, 1.5, 3.0]
    >>> parabola(2.0, derivative=1).tolist()
    [2.0]
    """

    breakpoints: Array
    coefficients: Array
    waypoint_times: Array
    family: str = ""
    case: str = ""

    def __post_init__(self) -> None:
        for name in ("breakpoints", "coefficients", "waypoint_times"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        breakpoints, coefficients = self.breakpoints, self.coefficients
        if breakpoints.ndim != 1 or coefficients.ndim != 3 or coefficients.shape[0] != breakpoints.size - 1:
            raise InputError(
                f"a trajectory needs m + 1 breakpoints and (m, n, degree + 1) coefficients, "
                f"got shapes {breakpoints.shape} and {coefficients.shape}"
            )
        if not (np.isfinite(breakpoints).all() and np.isfinite(coefficients).all()):
            raise InputError("a trajectory's breakpoints and coefficients must be finite numbers")
        if breakpoints.size < 2 or not (np.diff(breakpoints) > 0).all():
            raise InputError("a trajectory's breakpoints must increase strictly")
        self._check_waypoint_times()

    def _check_waypoint_times(self) -> None:
        times, breakpoints = self.waypoint_times, self.breakpoints
        if times.ndim != 1 or times.size < 2 or not (np.isfinite(times).all() and (np.diff(times) >= 0).all()):
            raise InputError(
                "a trajectory's waypoint times must be at least two finite numbers that do not decrease"
            )
        slack = 1e-9 * (breakpoints[-1] - breakpoints[0])
        if abs(times[0] - breakpoints[0]) > slack or abs(times[-1] - breakpoints[-1]) > slack:
            raise InputError(
                f"a trajectory's waypoint times run from {times[0]:.9g} to {times[-1]:.9g} s, "
                f"expected its span, {breakpoints[0]:.9g} to {breakpoints[-1]:.9g} s"
            )

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.coefficients.shape[1])

    @property
    def degree(self) -> int:
        """Degree of the pieces."""
        return int(self.coefficients.shape[2]) - 1

    @property
    def duration(self) -> float:
        """Total duration, s."""
        return float(self.breakpoints[-1] - self.breakpoints[0])

    @property
    def segment_durations(self) -> Array:
        """Duration of every gap between waypoints, (K - 1,), s."""
        return np.diff(self.waypoint_times)

    def derivative_coefficients(self, derivative: int) -> Array:
        """Coefficients of a time derivative, (m, n, degree + 1 - derivative), at least one column."""
        coefficients = np.asarray(self.coefficients)
        for _ in range(derivative):
            if coefficients.shape[2] == 1:
                return np.zeros_like(coefficients)
            coefficients = coefficients[:, :, 1:] * np.arange(1.0, coefficients.shape[2])
        return coefficients

    def __call__(self, t: ArrayLike, derivative: int = 0) -> Array:
        """Evaluate a time derivative.

        Parameters
        ----------
        t : (N,) array or float
            Times, s; clipped to the motion's span. At a breakpoint the piece that starts there is used.
        derivative : int
            0 position, 1 velocity, 2 acceleration, 3 jerk, ...

        Returns
        -------
        (N, n) array, or (n,) for a single time.
        """
        if derivative < 0:
            raise InputError(f"derivative is {derivative}, expected 0 or more")
        times = np.clip(np.asarray(t, dtype=np.float64), self.breakpoints[0], self.breakpoints[-1])
        flat = np.atleast_1d(times)
        piece = np.clip(
            np.searchsorted(self.breakpoints, flat, side="right") - 1, 0, len(self.breakpoints) - 2
        )
        local = (flat - self.breakpoints[piece])[:, None]
        coefficients = self.derivative_coefficients(derivative)[piece]
        values = coefficients[:, :, -1].copy()
        for power in range(coefficients.shape[2] - 2, -1, -1):
            values = values * local + coefficients[:, :, power]
        return values[0] if times.ndim == 0 else values

    def gap_at(self, times: ArrayLike) -> NDArray[np.intp]:
        """Return the gap between waypoints, counted from 0, in which each time lies; the later one at a waypoint.

        Parameters
        ----------
        times : array or float
            s; before the start is the first gap, after the end the last.
        """
        later = np.searchsorted(self.waypoint_times, times, side="right")
        return np.asarray(np.clip(later - 1, 0, self.waypoint_times.size - 2))

    def scaled(self, scale: float) -> Trajectory:
        """Return the same path run uniformly slower: every duration times `scale`.

        Velocity, acceleration and jerk shrink by `scale`, its square and its cube.
        """
        if not (np.isfinite(scale) and scale > 0):
            raise InputError(f"scale is {scale}, expected a positive number")
        powers = float(scale) ** -np.arange(self.degree + 1.0)
        start = self.breakpoints[0]
        return Trajectory(
            start + (self.breakpoints - start) * scale,
            self.coefficients * powers,
            start + (self.waypoint_times - start) * scale,
            self.family,
            self.case,
        )
