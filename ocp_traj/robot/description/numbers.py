"""Numbers in the attributes of XML elements."""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element

from ocp_traj.exceptions import RobotError


def number(element: Element, attribute: str, default: float | None, where: str, *, finite: bool = True) -> float:
    """Return an attribute as a number, `default` where it is not there.

    Parameters
    ----------
    element : Element
    attribute : str
    default : float or None
        None: it has to be there.
    where : str
        What the element belongs to, for messages.
    finite : bool
        Whether infinity is refused; nan always is.

    Raises
    ------
    RobotError
        The attribute is missing or is no number.
    """
    text = element.get(attribute)
    if text is None:
        if default is None:
            raise RobotError(f"{where}: <{element.tag}> has no {attribute}, expected a number")
        return default
    value = _parsed(text)
    if math.isnan(value) or (finite and math.isinf(value)):
        kind = "finite number" if finite else "number"
        raise RobotError(f"{where}: <{element.tag} {attribute}={text[:40]!r}> given, expected a {kind}")
    return value


def numbers(element: Element, attribute: str, count: int, where: str) -> list[float] | None:
    """Return an attribute as `count` finite numbers, None where it is not there.

    Raises
    ------
    RobotError
        There are more or fewer, or one is no finite number.
    """
    text = element.get(attribute)
    if text is None:
        return None
    values = [_parsed(word) for word in text.split()]
    if len(values) != count or not all(map(math.isfinite, values)):
        raise RobotError(
            f"{where}: <{element.tag} {attribute}={text[:60]!r}> given, expected {count} finite numbers"
        )
    return values


def _parsed(text: str) -> float:
    """Return the number a text stands for, nan for none; what Python alone reads, 1_0 for instance, is none."""
    try:
        return float(text) if text.isascii() and "_" not in text else math.nan
    except ValueError:
        return math.nan
