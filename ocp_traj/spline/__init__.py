"""Spline families, each defined once and used numerically, in batches and symbolically.

A new family is one file with a `Family` subclass, and one line here.
"""

from __future__ import annotations

from ocp_traj.exceptions import UnknownNameError
from ocp_traj.spline.cubic import Cubic
from ocp_traj.spline.family import Family, Piece, UniformFamily
from ocp_traj.spline.interpolation import EndConditions
from ocp_traj.spline.quintic import Quintic
from ocp_traj.spline.septic import Septic
from ocp_traj.spline.three_five_three import ThreeFiveThree

FAMILIES: dict[str, Family] = {
    family.name: family for family in (Cubic(), Quintic(), Septic(), ThreeFiveThree())
}


def get_family(name: str) -> Family:
    """Return the family of that name.

    Parameters
    ----------
    name : str
        As in case files.

    Raises
    ------
    UnknownNameError
        There is none; the message lists those there are.

    Examples
    --------
    >>> get_family("septic").degree
    7
    """
    try:
        return FAMILIES[name]
    except KeyError:
        raise UnknownNameError(
            f"spline family {name!r} is unknown, expected one of {', '.join(FAMILIES)}"
        ) from None


__all__ = ["FAMILIES", "EndConditions", "Family", "Piece", "UniformFamily", "get_family"]
