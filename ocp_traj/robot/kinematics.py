"""Forward kinematics as CasADi functions, from the same numbers as the inverse dynamics."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.robot.additions import Coupling
from ocp_traj.robot.links import Link


def _homogeneous(rotation: Any, translation: Any) -> Any:
    return ca.vertcat(ca.horzcat(rotation, translation), ca.DM([[0.0, 0.0, 0.0, 1.0]]))


def _joint_transform(link: Link, q: Any) -> Any:
    """Return the transform (4, 4) from the link to its parent at joint position `q`."""
    rotation, translation = ca.DM(link.rotation), ca.DM(link.translation)
    if link.prismatic:
        return _homogeneous(rotation, translation + ca.DM(link.rotation[:, 2]) * q)
    c, s = ca.cos(q), ca.sin(q)
    turn = ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))
    return _homogeneous(ca.mtimes(rotation, turn), translation)


def _pose(links: tuple[Link, ...], link: int, placement: Array, base: Array, q: Any) -> Any:
    """Return the transform (4, 4) from the base to a frame fixed to link number `link` (-1: the root)."""
    pose: Any = ca.DM(placement)
    if link >= 0:
        alignment = np.eye(4)
        alignment[:3, :3] = links[link].alignment
        pose = ca.DM(alignment.T @ placement)
    while link >= 0:
        pose = ca.mtimes(_joint_transform(links[link], q[link]), pose)
        link = links[link].parent
    inverse = np.eye(4)
    inverse[:3, :3] = base[:3, :3].T
    inverse[:3, 3] = -base[:3, :3].T @ base[:3, 3]
    return ca.SX(ca.mtimes(ca.DM(inverse), pose))


def _joint_symbols(links: tuple[Link, ...], coupling: Coupling | None) -> tuple[Any, Any]:
    """Return symbols of the robot's joint positions, and the positions of all links' joints."""
    q = ca.SX.sym("q", len(links) if coupling is None else coupling.n)
    return q, q if coupling is None else coupling.symbols(q)[0]


def pose_function(
    links: tuple[Link, ...], link: int, placement: Array, base: Array, coupling: Coupling | None = None
) -> ca.Function:
    """Return the CasADi function q (n,) -> T (4, 4), from the base frame to a frame of the robot.

    Parameters
    ----------
    links : tuple of Link
        The robot.
    link : int
        Link that carries the frame, -1 for the root.
    placement : (4, 4)
        The frame in Pinocchio's axes of its joint.
    base : (4, 4)
        The base frame in the root.
    coupling : Coupling, optional
        How the links' joints follow those of the robot.
    """
    q, positions = _joint_symbols(links, coupling)
    pose = ca.cse(ca.densify(_pose(links, link, placement, base, positions)))
    return ca.Function("forward_kinematics", [q], [pose], ["q"], ["T"])


def velocity_function(
    links: tuple[Link, ...], link: int, placement: Array, base: Array, coupling: Coupling | None = None
) -> ca.Function:
    """Return the CasADi function (q, v) -> linear velocity (3,) of a frame's origin in base axes, m/s.

    The parameters are those of `pose_function`.
    """
    q, positions = _joint_symbols(links, coupling)
    v = ca.SX.sym("v", q.numel())
    position = _pose(links, link, placement, base, positions)[:3, 3]
    velocity = ca.cse(ca.densify(ca.jtimes(position, q, v)))
    return ca.Function("frame_velocity", [q, v], [velocity], ["q", "v"], ["velocity"])
