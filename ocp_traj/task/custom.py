"""A user's own costs and limits of one task: CasADi functions of one instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.arrays import ArrayLike


@dataclass(frozen=True)
class CustomObjective:
    """A user's own cost: the integral of a CasADi function of (q, v, a, tau), each (n,), to one number.

    Parameters
    ----------
    name : str
        In reports.
    function : casadi.Function
        (q, v, a, tau), each (n,), in SI units, to one number, whose integral over time is the cost.
    weight : float
    """

    name: str
    function: Any
    weight: float = 1.0


@dataclass(frozen=True)
class CustomConstraint:
    """A user's own limit: a CasADi function of (q, v, a, tau), each (n,), to k numbers within [lower, upper].

    Parameters
    ----------
    name : str
        In reports.
    function : casadi.Function
        (q, v, a, tau), each (n,), in SI units, to k numbers.
    lower, upper : number or (k,)
    scale : float, optional
        What a violation is divided by; the larger finite bound, or 1.
    """

    name: str
    function: Any
    lower: ArrayLike = -np.inf
    upper: ArrayLike = np.inf
    scale: float | None = None
