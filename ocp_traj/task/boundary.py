"""Start and end of a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ocp_traj.arrays import ArrayLike, read_only
from ocp_traj.exceptions import TaskError
from ocp_traj.quantities import RATES
from ocp_traj.spline import Family
from ocp_traj.task.checks import numbers


@dataclass(frozen=True)
class Boundary:
    """Start and end of the motion: (2, n) rows [start, end]; ``None`` leaves a derivative free.

    ``"default"`` is the family's own: acceleration free for cubic and zero otherwise, jerk zero for septic and
    free otherwise (see `Family.end_orders`).

    Parameters
    ----------
    velocity : number, (n,) or (2, n) array, rad/s (m/s)
    acceleration : the same, ``None`` or ``"default"``, rad/s^2 (m/s^2)
    jerk : the same, ``None`` or ``"default"``, rad/s^3 (m/s^3)
    """

    velocity: ArrayLike = 0.0
    acceleration: ArrayLike | None | Literal["default"] = "default"
    jerk: ArrayLike | None | Literal["default"] = "default"

    def expanded(self, family: Family, n: int) -> Boundary:
        """Return boundary conditions with (2, n) arrays, or None where free."""
        values: dict[str, Any] = {}
        for order, name in enumerate(RATES, start=1):
            given = getattr(self, name)
            default = 0.0 if order in family.end_orders else None
            value = default if isinstance(given, str) else given
            if value is None:
                values[name] = None
                continue
            array = numbers(f"boundary.{name}", value)
            if array.ndim == 0:
                array = np.full((2, n), array)
            if array.shape != (2, n) or not np.isfinite(array).all():
                raise TaskError(f"boundary.{name}", f"expected two rows (start, end) of {n} finite numbers")
            values[name] = read_only(array)
        if values["velocity"] is None:
            raise TaskError("boundary.velocity", "must be given, it cannot be free")
        return Boundary(**values)

    @property
    def is_rest(self) -> bool:
        """True when the motion starts and ends at rest (zero velocity; given accelerations and jerks zero)."""
        given = [value for value in (self.velocity, self.acceleration, self.jerk) if value is not None]
        return all(not np.any(value) for value in given)
