"""Inverse dynamics as a CasADi function: recursive Newton-Euler over the numbers of a pin.Model.

Source: Luh, Walker, Paul, "On-line computational scheme for mechanical manipulators", J. Dyn. Sys. Meas.
Control 102 (1980) 69-76. The body equations are written with the matrix S = [wd]x + [w]x[w]x, which carries
the acceleration of every point of a body (a + S r), so the force is m a + S (m c) and the moment is the
axial vector of S E minus its transpose, where E is the body's second moment; this takes fewer operations than
the usual form with w x (I w).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import casadi as ca

from ocp_traj.arrays import Array
from ocp_traj.robot.additions import Coupling, Friction
from ocp_traj.robot.links import Link
from ocp_traj.robot.regrouping import regrouped, split_rotation


def _to_link(link: Link, q: Any, vector: Any) -> Any:
    """Express a vector given in the parent's axes in the axes of the link at joint position `q`."""
    at_zero = ca.mtimes(ca.DM(link.rotation.T), vector)
    if link.prismatic:
        return at_zero
    c, s = ca.cos(q), ca.sin(q)
    x, y, z = at_zero[0], at_zero[1], at_zero[2]
    return ca.vertcat(c * x + s * y, c * y - s * x, z)


def _to_parent(link: Link, q: Any, vector: Any) -> Any:
    """Express a vector given in link axes in the axes of the parent."""
    if not link.prismatic:
        c, s = ca.cos(q), ca.sin(q)
        x, y, z = vector[0], vector[1], vector[2]
        vector = ca.vertcat(c * x - s * y, s * x + c * y, z)
    return ca.mtimes(ca.DM(link.rotation), vector)


def _point_matrix(w: Any, dw: Any) -> Any:
    """Return S = [dw]x + [w]x[w]x of a body with angular velocity `w` and acceleration `dw`."""
    xx, yy, zz = w[0] * w[0], w[1] * w[1], w[2] * w[2]
    xy, xz, yz = w[0] * w[1], w[0] * w[2], w[1] * w[2]
    return ca.vertcat(
        ca.horzcat(-(yy + zz), xy - dw[2], xz + dw[1]),
        ca.horzcat(xy + dw[2], -(xx + zz), yz - dw[0]),
        ca.horzcat(xz - dw[1], yz + dw[0], -(xx + yy)),
    )


def _origin(link: Link, q: Any) -> Any:
    """Return the origin of the link in its parent."""
    if link.prismatic:
        return ca.DM(link.translation) + ca.DM(link.rotation[:, 2]) * q
    return ca.DM(link.translation)


def newton_euler(links: tuple[Link, ...], gravity: Array, q: Any, v: Any, a: Any) -> Any:
    """Return the joint torques (n,) of CasADi expressions `q`, `v`, `a` (n,), armature included.

    Parameters
    ----------
    links : tuple of Link
        Parents before children.
    gravity : (3,)
        In the root's axes, m/s^2.
    q, v, a : CasADi columns or lists of n
        rad, rad/s, rad/s^2 (m for prismatic joints).
    """
    zero = ca.DM.zeros(3, 1)
    spins: list[Any] = []
    points: list[Any] = []
    accelerations: list[Any] = []
    forces: list[Any] = []
    moments: list[Any] = []
    for index, link in enumerate(links):
        if link.parent < 0:
            w, dw, base = zero, zero, ca.DM(-gravity)
        else:
            w, dw = spins[link.parent]
            base = accelerations[link.parent] + ca.mtimes(points[link.parent], _origin(link, q[index]))
        w, dw = _to_link(link, q[index], w), _to_link(link, q[index], dw)
        acceleration = _to_link(link, q[index], base)
        if link.prismatic:
            coriolis = 2.0 * v[index]
            acceleration += ca.vertcat(coriolis * w[1], -coriolis * w[0], a[index])
        else:
            dw = dw + ca.vertcat(w[1] * v[index], -w[0] * v[index], a[index])
            w = w + ca.vertcat(0, 0, v[index])
        point = _point_matrix(w, dw)
        first = ca.DM(link.first_moment)
        product = ca.mtimes(point, ca.DM(link.second_moment))
        axial = ca.vertcat(
            product[2, 1] - product[1, 2], product[0, 2] - product[2, 0], product[1, 0] - product[0, 1]
        )
        spins.append((w, dw))
        points.append(point)
        accelerations.append(acceleration)
        forces.append(link.mass * acceleration + ca.mtimes(point, first))
        moments.append(axial + ca.cross(first, acceleration))
    return _joint_torques(links, q, a, forces, moments)


def _joint_torques(links: tuple[Link, ...], q: Any, a: Any, forces: list[Any], moments: list[Any]) -> Any:
    """Return the torques that carry the bodies' forces and moments, summed from the tips to the root."""
    torques: list[Any] = [0.0] * len(links)
    for index in reversed(range(len(links))):
        link = links[index]
        along_axis = forces[index][2] if link.prismatic else moments[index][2]
        torques[index] = along_axis + link.armature * a[index]
        if link.parent >= 0:
            force = _to_parent(link, q[index], forces[index])
            moment = _to_parent(link, q[index], moments[index])
            forces[link.parent] = forces[link.parent] + force
            moments[link.parent] = moments[link.parent] + moment + ca.cross(_origin(link, q[index]), force)
    return ca.vertcat(*torques)


def _plain_placements(links: tuple[Link, ...], q: Any) -> tuple[tuple[Link, ...], list[Any]]:
    """Return links with plain rotations, and the joint positions that make up for it."""
    turned, angles = [], []
    for index, link in enumerate(links):
        rotation, angle = (link.rotation, 0.0) if link.prismatic else split_rotation(link.rotation)
        turned.append(replace(link, rotation=rotation))
        angles.append(q[index] + angle if angle else q[index])
    return tuple(turned), angles


def inverse_dynamics_function(
    links: tuple[Link, ...], gravity: Array, friction: Friction, coupling: Coupling | None = None
) -> ca.Function:
    """Return the CasADi function (q, v, a) -> tau of a robot, each (n,), with armature and friction.

    The bodies' parameters are regrouped first, which takes a quarter of the operations away (UR5).
    """
    n = friction.viscous.size
    q, v, a = ca.SX.sym("q", n), ca.SX.sym("v", n), ca.SX.sym("a", n)
    states = (q, v, a) if coupling is None else coupling.symbols(q, v, a)
    turned, angles = _plain_placements(regrouped(links), states[0])
    tau = newton_euler(turned, gravity, angles, *states[1:])
    if coupling is not None:
        tau = ca.mtimes(ca.DM(coupling.matrix.T), tau)
    tau = tau + ca.DM(friction.viscous) * v + ca.DM(friction.coulomb) * ca.sign(v)
    return ca.Function("inverse_dynamics", [q, v, a], [ca.cse(tau)], ["q", "v", "a"], ["tau"])
