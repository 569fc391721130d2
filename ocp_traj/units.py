"""Units of the outside world; inside the library everything is SI (s, m, rad, N m, J)."""

from __future__ import annotations

import math

from ocp_traj.exceptions import InputError

FACTORS = {"rad": 1.0, "deg": math.pi / 180.0, "m": 1.0, "mm": 1e-3}
"""Factor to SI of every unit a case file may name."""


def factor(unit: str) -> float:
    """Return the factor that turns a value in `unit` into SI.

    Raises
    ------
    InputError
        `unit` is none of ``rad``, ``deg``, ``m``, ``mm``.
    """
    try:
        return FACTORS[unit]
    except (KeyError, TypeError):
        raise InputError(f"unit {unit!r} is unknown, expected one of {', '.join(FACTORS)}") from None
