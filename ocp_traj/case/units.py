"""Units of a case file's joints: one for all, or one a joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.case.section import Section, describe
from ocp_traj.exceptions import did_you_mean
from ocp_traj.units import FACTORS

if TYPE_CHECKING:
    from ocp_traj.robot import Robot

_LENGTHS = ("m", "mm")


def joint_factors(section: Section, n: int, robot: Robot | None) -> Array:
    """Return the factors to SI, (n,), of a table's ``unit``: SI where it has none.

    Raises
    ------
    CaseError
        The unit is unknown, the list has not n units, or a unit does not fit the kind of a joint.
    """
    if "unit" not in section:
        return np.ones(n)
    given = section.data["unit"]
    units = given if isinstance(given, list) else [given] * n
    if len(units) != n:
        raise section.error("unit", f"{len(units)} given, expected one, or {n}: one a joint")
    for index, unit in enumerate(units):
        if not isinstance(unit, str) or unit not in FACTORS:
            hint = did_you_mean(unit, FACTORS) if isinstance(unit, str) else ""
            raise section.error("unit", f"{describe(unit)} given, expected one of {', '.join(FACTORS)}{hint}")
        if robot is None:
            continue
        slides = robot.joint_types[index] == "prismatic"
        if slides != (unit in _LENGTHS):
            kind, expected = ("slides", "'m' or 'mm'") if slides else ("turns", "'rad' or 'deg'")
            raise section.error(
                "unit",
                f"{unit!r} does not fit joint {index + 1}, which {kind}: expected a list with {expected}",
            )
    return np.array([FACTORS[unit] for unit in units])
