"""Spline families, each defined once and used numerically, in batches and symbolically.

A new family is one file with a `Family` subclass, and one line here; a task takes one from anywhere.
"""

from __future__ import annotations

from typing import overload

from ocp_traj.exceptions import TaskError, UnknownNameError, did_you_mean
from ocp_traj.spline.family import Family, Piece, SplinePart
from ocp_traj.spline.interpolation import EndConditions
from ocp_traj.spline.three_five_three import ThreeFiveThree
from ocp_traj.spline.uniform import Cubic, Quintic, Septic, UniformFamily

FAMILIES: dict[str, Family] = {
    family.name: family for family in (Cubic(), Quintic(), Septic(), ThreeFiveThree())
}


def get_family(family: Family | str) -> Family:
    """Return the family of that name, or the family itself.

    Parameters
    ----------
    family : Family or str
        Names are those in case files.

    Raises
    ------
    UnknownNameError
        There is none; the message lists those there are.

    Examples
    --------
    >>> get_family("septic").degree
    7
    """
    if isinstance(family, Family):
        return family
    if not isinstance(family, str) or family not in FAMILIES:
        hint = did_you_mean(str(family), FAMILIES)
        raise UnknownNameError(
            f"spline family {family!r} is unknown, expected one of {', '.join(FAMILIES)}{hint}"
        )
    return FAMILIES[family]


class FamilyField:
    """Field of a task: given a family or its name, it holds the family.

    Parameters
    ----------
    default : str
        Name of the family a task has when none is given.
    """

    def __init__(self, default: str) -> None:
        self.default = default

    @overload
    def __get__(self, task: None, owner: type) -> str: ...
    @overload
    def __get__(self, task: object, owner: type) -> Family: ...
    def __get__(self, task: object | None, owner: type) -> Family | str:
        """Return the family of a task."""
        return self.default if task is None else task.__dict__["family"]

    def __set__(self, task: object, family: Family | str) -> None:
        """Set the family of a task; raise `TaskError` where the name is unknown."""
        try:
            task.__dict__["family"] = get_family(family)
        except UnknownNameError as error:
            raise TaskError("spline.family", str(error).removeprefix("spline family ")) from None


class KnotsField:
    """Field of a task: virtual knots per gap; None takes the default of the task's family, set before."""

    @overload
    def __get__(self, task: None, owner: type) -> None: ...
    @overload
    def __get__(self, task: object, owner: type) -> int: ...
    def __get__(self, task: object | None, owner: type) -> int | None:
        """Return the virtual knots of a task."""
        return None if task is None else task.__dict__["virtual_knots"]

    def __set__(self, task: object, count: int | None) -> None:
        """Set the virtual knots of a task."""
        default = task.__dict__["family"].default_virtual_knots
        task.__dict__["virtual_knots"] = default if count is None else count


__all__ = [
    "FAMILIES",
    "EndConditions",
    "Family",
    "Piece",
    "SplinePart",
    "UniformFamily",
    "get_family",
]
