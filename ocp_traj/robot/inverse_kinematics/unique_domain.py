"""The method of unique domains: along a path compute only the branch of the domain one is in.

The surfaces det J = 0 cut the joint space into domains in each of which a pose has at most one solution
(Wenger 1992, as cited by paper C). As long as a path does not cross them, one branch of eight is enough;
`crossings.py` finds where a path does.
"""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import UnreachablePoseError
from ocp_traj.robot.inverse_kinematics.branch_choice import nearest_turns
from ocp_traj.robot.inverse_kinematics.closed_form import FACTORS, SINGULAR, ClosedForm


def domain_of(inverse: ClosedForm, q: Array) -> Array:
    """Return the signs (3,) of the domain that holds `q` (6,).

    Parameters
    ----------
    inverse : ClosedForm
    q : (6,) rad

    Raises
    ------
    UnreachablePoseError
        `q` is on a border, where there is no domain to follow.
    """
    factors = inverse.factors(q)[0]
    weakest = int(np.argmin(np.abs(factors)))
    if abs(factors[weakest]) < SINGULAR:
        raise UnreachablePoseError(
            f"start position {np.asarray(q).tolist()} is singular ({FACTORS[weakest]}: det J = 0), "
            "expected one inside a domain"
        )
    return np.sign(factors)


def follow_domain(inverse: ClosedForm, poses: Array, start: Array) -> Array:
    """Return the positions (K, 6) that reach poses (K, 4, 4) in the domain of `start` (6,).

    Angles are taken in the turn nearest to the pose before; a row is NaN where the domain has no solution.

    Parameters
    ----------
    inverse : ClosedForm
    poses : (K, 4, 4) transforms, m
    start : (6,) rad
    """
    q = inverse.branches(poses, domain_of(inverse, start)[None]).q[:, 0]
    previous = np.asarray(start, dtype=np.float64)
    for row in q:
        row[:] = nearest_turns(inverse.robot, row, previous)
        previous = np.where(np.isnan(row), previous, row)
    return q
