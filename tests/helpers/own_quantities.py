"""What a package outside adds: a limit of every joint's power and two costs, each with the judge's own measure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import casadi as ca
import numpy as np

from ocp_traj.audit.measures import COST_MEASURES, LIMIT_MEASURES
from ocp_traj.costs import INSTANT_COSTS, InstantCost
from ocp_traj.instant import Instant
from ocp_traj.limits import INSTANT_LIMITS, JointLimit
from ocp_traj.quantities import COSTS, JOINT_LIMITS, Quantity, SpeedLaw
from ocp_traj.task import TrajectoryTask


class PowerLimit(JointLimit):
    """Lower and upper mechanical power of every joint, W."""

    name = "power"

    def value(self, instant: Instant) -> Any:
        """Return tau qdot."""
        return instant.tau * instant.v


class SquaredSpeed(InstantCost):
    """Integral of the squared speeds of all joints."""

    name = "squared_speed"

    def expression(self, instant: Instant) -> Any:
        """Return the sum of squares."""
        return ca.sumsqr(instant.v)

    def scaling(self, task: TrajectoryTask) -> SpeedLaw:
        """Return that it goes with the square of the uniform speed."""
        return SpeedLaw(speed=2)


class Braking(InstantCost):
    """Integral of the power that braking joints would give back, J."""

    name = "braking"
    shape = "positive"

    def expression(self, instant: Instant) -> Any:
        """Return the power taken from every joint."""
        return -instant.tau * instant.v


@contextmanager
def registered() -> Iterator[None]:
    """Add everything, and take it away again."""
    limit, costs = PowerLimit(), [SquaredSpeed(), Braking()]
    JOINT_LIMITS["power"] = Quantity("power", "W", order=2, needs_inertia=True)
    COSTS["squared_speed"] = Quantity("squared_speed", "rad^2/s", "m^2/s", order=1)
    COSTS["braking"] = Quantity("braking", "J", order=2, needs_inertia=True)
    INSTANT_LIMITS.append(limit)
    INSTANT_COSTS.extend(costs)
    LIMIT_MEASURES["power"] = lambda task, q, v, a, tau: tau * v
    COST_MEASURES["squared_speed"] = lambda task, q, v, a, tau: v**2
    COST_MEASURES["braking"] = lambda task, q, v, a, tau: np.maximum(-tau * v, 0.0)
    try:
        yield
    finally:
        INSTANT_LIMITS.remove(limit)
        for cost in costs:
            INSTANT_COSTS.remove(cost)
        for table, name in (
            *((JOINT_LIMITS, "power"), (LIMIT_MEASURES, "power")),
            *((table, cost.name) for table in (COSTS, COST_MEASURES) for cost in costs),
        ):
            del table[name]  # type: ignore[attr-defined]


def run(request: Mapping[str, Any]) -> dict[str, Any]:
    """Execute one run of a comparison with everything registered."""
    from ocp_traj.comparison.runs.runner import solve_case

    with registered():
        return solve_case(request)
