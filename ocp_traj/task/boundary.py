"""Start and end of a motion."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ocp_traj.arrays import ArrayLike, read_only
from ocp_traj.exceptions import TaskError
from ocp_traj.quantities import RATES
from ocp_traj.task.checks import numbers


@dataclass(frozen=True)
class Boundary:
    """Start and end of the motion: (2, n) rows [start, end]; ``None`` leaves a derivative free.

    ``"default"`` is the family's own (see `Family.default_end_orders`): acceleration zero, but free for a cubic
    without a jerk limit, without virtual knots, or with two waypoints and one knot; jerk zero for septic, else free.

    Parameters
    ----------
    velocity : number, (n,) or (2, n) array, rad/s (m/s)
    acceleration : the same, ``None`` or ``"default"``, rad/s^2 (m/s^2)
    jerk : the same, ``None`` or ``"default"``, rad/s^3 (m/s^3)
    """

    velocity: ArrayLike = 0.0
    acceleration: ArrayLike | None | Literal["default"] = "default"
    jerk: ArrayLike | None | Literal["default"] = "default"

    def expanded(self, end_orders: Collection[int], n: int) -> Boundary:
        """Return boundary conditions with (2, n) arrays, or None where free.

        Parameters
        ----------
        end_orders : collection of int
            Orders of the derivatives that are zero by default.
        n : int
            Joints.
        """
        values: dict[str, Any] = {}
        for order, name in enumerate(RATES, start=1):
            given = getattr(self, name)
            default = 0.0 if order in end_orders else None
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
