"""What the methods that time a fixed path give back."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ocp_traj.arrays import Array, read_only

_EMPTY = np.empty(0)


@dataclass(frozen=True)
class ReferenceResult:
    """The timing of a fixed path by one method.

    Attributes
    ----------
    method : ``"toppra"`` or ``"convex"``
    path : ``"uniform"``, ``"chord"`` or ``"spline"``
        The path that was timed; a duration means nothing without it.
    duration : float or None
        s; None when no timing was found, then `reason` says why.
    reason : str
        One sentence on the failure, or on what a time limit left undone; empty otherwise.
    s : (N + 1,) array
        Grid over the path's arc length, scaled to [0, 1].
    speed : (N + 1,) array
        sdot, 1/s.
    acceleration : (N,) array
        sddot, 1/s^2, constant in every cell.
    q, v : (N + 1, n) arrays
        Positions and velocities at the grid, rad and rad/s.
    times : (N + 1,) array
        When each grid point is passed, s.
    waypoint_times : (K,) array
        When each waypoint is passed, s.
    active : tuple of N str
        The limit that holds the motion back in every cell, for instance ``"torque, joint 2"``; empty where none does.
    multipliers : (N,) array
        Multiplier of that limit where the method has duals (seconds gained per relative loosening of the limit).
    objective : float or None
        Value of the minimised objective where it is not the duration alone.
    points : int
        Number of cells asked for; the grid has at least as many.
    largest_ratio : float
        Largest value over limit at the grid points, over velocity, acceleration and torque.
    solve_time, build_time : float
        Seconds spent in the solver and before it.
    """

    method: str
    path: str
    duration: float | None
    reason: str = ""
    s: Array = field(default_factory=lambda: _EMPTY)
    speed: Array = field(default_factory=lambda: _EMPTY)
    acceleration: Array = field(default_factory=lambda: _EMPTY)
    q: Array = field(default_factory=lambda: _EMPTY)
    v: Array = field(default_factory=lambda: _EMPTY)
    times: Array = field(default_factory=lambda: _EMPTY)
    waypoint_times: Array = field(default_factory=lambda: _EMPTY)
    active: tuple[str, ...] = ()
    multipliers: Array = field(default_factory=lambda: _EMPTY)
    objective: float | None = None
    points: int = 0
    largest_ratio: float = 0.0
    build_time: float = 0.0
    solve_time: float = 0.0

    def __post_init__(self) -> None:
        for name in ("s", "speed", "acceleration", "q", "v", "times", "waypoint_times", "multipliers"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def found(self) -> bool:
        """True when a timing was found."""
        return self.duration is not None


def cell_durations(s: Array, x: Array) -> Array:
    """Return the time (N,) spent in every cell when x = sdot^2 is linear in s; infinite where x is 0 at both ends."""
    speeds = np.sqrt(np.maximum(x[:-1], 0.0)) + np.sqrt(np.maximum(x[1:], 0.0))
    durations = np.full(len(s) - 1, np.inf)
    np.divide(2.0 * np.diff(s), speeds, out=durations, where=speeds > 0)
    return durations
