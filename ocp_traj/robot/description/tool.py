"""The frame that poses and payload refer to where nobody names one."""

from __future__ import annotations

from collections.abc import Iterable

FLANGES = ("tool0", "flange", "tcp", "ee_link")
"""Names of a flange, the best first; any of them may follow a prefix and an underscore."""


def default_tool(carried: Iterable[str], link: str) -> str:
    """Return the flange among the frames that the last joint carries, else that joint's link.

    Parameters
    ----------
    carried : iterable of str
        Names of the frames fixed to the last joint.
    link : str
        The joint's own link.
    """
    names = list(carried)
    for flange in FLANGES:
        for name in sorted(names, key=len):
            if name == flange or name.endswith(f"_{flange}"):
                return name
    return link
