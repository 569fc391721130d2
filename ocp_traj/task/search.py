"""What population methods need besides the task."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ocp_traj.arrays import ArrayLike
from ocp_traj.exceptions import TaskError
from ocp_traj.task.checks import expand_interval, numbers


@dataclass(frozen=True)
class Search:
    """What population methods need besides the task.

    Parameters
    ----------
    duration : (2,) bounds of the duration of one gap, s
    protocol : ``"shared"`` durations for all joints, or ``"per-joint"`` (papers B and D)
    offset : half-width of the box of virtual-knot offsets, in units of the local travel
    """

    duration: ArrayLike = (0.05, 10.0)
    protocol: str = "shared"
    offset: float = 0.1

    def expanded(self) -> Search:
        """Return the settings with checked values."""
        duration = expand_interval("search.duration", self.duration, (2,))
        if not (duration[0] > 0 and np.isfinite(duration[1])):
            raise TaskError("search.duration", "expected two finite positive numbers")
        offset = numbers("search.offset", self.offset)
        if offset.ndim or not (np.isfinite(offset) and offset > 0):
            raise TaskError("search.offset", f"{self.offset!r} given, expected a finite positive number")
        if self.protocol not in ("shared", "per-joint"):
            raise TaskError(
                "search.protocol", f"{self.protocol!r} is unknown, expected 'shared' or 'per-joint'"
            )
        return replace(self, duration=duration, offset=float(offset))
