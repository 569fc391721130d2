"""Links whose inverse dynamics take fewer operations and give the same torques.

A mass on a joint's axis belongs to the link before the joint just as well, since the joint does not move it: every
link that turns can give away its mass, its first moment along the axis and its second moment along the axis. These
are the regrouped (base) parameters of Gautier and Khalil, "Direct calculation of minimum set of inertial parameters
of serial robots", IEEE Trans. Robotics and Automation 6 (1990) 368-373. And a turn about the axis that is part of a
link's placement can be added to the joint's angle.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.robot.links import Link

_ROUNDING = 1e-15


def regrouped(links: tuple[Link, ...]) -> tuple[Link, ...]:
    """Return the links with what lies on the axis of a turning joint moved to its parent; torques stay.

    Parameters
    ----------
    links : tuple of Link
        Parents before children.

    Returns
    -------
    tuple of Link
        Masses and moments may be negative: only the torques have a meaning, not the single body.
    """
    moved = list(links)
    for index in reversed(range(len(moved))):
        link = moved[index]
        if link.prismatic:
            continue
        mass, first, second = link.mass, float(link.first_moment[2]), float(link.second_moment[2, 2])
        z = np.array([0.0, 0.0, 1.0])
        moved[index] = replace(
            link,
            mass=0.0,
            first_moment=link.first_moment - first * z,
            second_moment=link.second_moment - second * np.outer(z, z),
        )
        if link.parent >= 0:
            parent, axis, origin = moved[link.parent], link.rotation[:, 2], link.translation
            across = np.outer(origin, axis)
            moved[link.parent] = replace(
                parent,
                mass=parent.mass + mass,
                first_moment=parent.first_moment + mass * origin + first * axis,
                second_moment=parent.second_moment
                + mass * np.outer(origin, origin)
                + first * (across + across.T)
                + second * np.outer(axis, axis),
            )
    return tuple(moved)


def split_rotation(rotation: Array) -> tuple[Array, float]:
    """Return (R, angle) with R turned by `angle` about its z equal to `rotation`, R with as many zeros as possible.

    Rotations that are plain already, such as exchanges of axes, come back unchanged with angle 0.
    """
    tilt = np.hypot(rotation[2, 0], rotation[2, 1])
    if tilt < _ROUNDING:
        angle = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
    else:
        angle = float(np.arctan2(rotation[2, 0], rotation[2, 1]))
    c, s = np.cos(angle), np.sin(angle)
    plain = rotation @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    whole = np.round(plain)
    plain = np.where(np.abs(plain - whole) < _ROUNDING, whole, plain)
    if np.count_nonzero(plain) < np.count_nonzero(rotation):
        return plain, angle
    return rotation, 0.0
