"""What can be limited and what can be priced: one row per quantity, read by everything that names one.

A case file, the solvers, the judge and the pictures all ask these tables; a quantity of one's own is a row added to
`JOINT_LIMITS` or `COSTS`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Quantity:
    """One limited or priced quantity.

    Attributes
    ----------
    name : str
        In case files, reports and messages.
    unit : str
        SI, of a rotary joint.
    prismatic_unit : str
        SI, of a prismatic joint; empty where it is the same.
    order : int
        Highest derivative of the position it depends on. Of a limited quantity, what motion adds falls with this power
        of a uniform slowing; a jump of a lower derivative makes it infinite.
    needs_inertia : bool
        Whether it needs a robot with inertia.
    from_robot : bool
        Whether a robot description has a limit of it.
    """

    name: str
    unit: str
    prismatic_unit: str = ""
    order: int = 0
    needs_inertia: bool = False
    from_robot: bool = False

    @property
    def units(self) -> str:
        """The unit, and that of prismatic joints in brackets where it is another one."""
        return f"{self.unit} ({self.prismatic_unit})" if self.prismatic_unit else self.unit

    @property
    def symbol(self) -> str:
        """The unit with raised exponents, for pictures."""
        return self.unit.replace("^2", "²").replace("^3", "³").replace("^5", "⁵")


@dataclass(frozen=True)
class SpeedLaw:
    """How a value goes with the uniform speed r = 1 / slowing of a motion from rest to rest.

    It is proportional to r**speed times the torque to the power `torque`; the torque itself is gravity and Coulomb
    friction, plus viscous friction times r, plus the inertial torque times r^2.

    Attributes
    ----------
    speed, torque : int
    factors : (n,) array, optional
        Of a sum over joints: what each joint's value is multiplied with.
    """

    speed: int = 0
    torque: int = 0
    factors: Any = None


def _table(*rows: Quantity) -> dict[str, Quantity]:
    return {row.name: row for row in rows}


JOINT_LIMITS = _table(
    Quantity("position", "rad", "m", order=0, from_robot=True),
    Quantity("velocity", "rad/s", "m/s", order=1, from_robot=True),
    Quantity("acceleration", "rad/s^2", "m/s^2", order=2, from_robot=True),
    Quantity("jerk", "rad/s^3", "m/s^3", order=3, from_robot=True),
    Quantity("torque", "N m", "N", order=2, needs_inertia=True, from_robot=True),
    Quantity("torque_rate", "N m/s", "N/s", order=3, needs_inertia=True),
)
"""Quantities of a joint that can be limited."""

FRAME_LIMITS = _table(Quantity("cartesian_speed", "m/s", order=1))
"""Quantities of a frame that can be limited."""

COSTS = _table(
    Quantity("time", "s"),
    Quantity("energy", "J", order=2, needs_inertia=True),
    Quantity("energy_without_regeneration", "J", order=2, needs_inertia=True),
    Quantity("torque", "s", order=2, needs_inertia=True),
    Quantity("acceleration", "rad^2/s^3", "m^2/s^3", order=2),
    Quantity("jerk", "rad^2/s^5", "m^2/s^5", order=3),
    Quantity("motor_loss", "J", order=2, needs_inertia=True),
)
"""Integrals over the motion that can be priced."""

DERIVATIVES = ("position", "velocity", "acceleration", "jerk")
"""Names of the position and its derivatives, by order."""

RATES = DERIVATIVES[1:]
"""Names of the derivatives that are limited in every direction and may be given at the ends."""

KINEMATIC_POWERS = {
    name: row.order
    for name, row in {**JOINT_LIMITS, **FRAME_LIMITS}.items()
    if row.order and not row.needs_inertia
}
"""Limits whose ratio is exactly inverse to this power of a uniform slowing."""


def limited_quantity(name: str) -> Quantity | None:
    """Return the row of a limit, None for a user's own constraint."""
    return JOINT_LIMITS.get(name) or FRAME_LIMITS.get(name)
