"""The method of unique domains: along a path compute only the branch of the domain one is in.

The surfaces det J = 0 cut the joint space into domains in each of which a pose has at most one solution
(Wenger 1992, as cited by paper C). As long as a path does not cross them, one branch of eight is enough. A
path that does cross leaves the domain: its branch then jumps or ends, which is found here by bisection
between the poses.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ocp_traj.arrays import Array
from ocp_traj.exceptions import UnreachablePoseError
from ocp_traj.robot.inverse_kinematics.branch_choice import nearest_turns
from ocp_traj.robot.inverse_kinematics.closed_form import FACTORS, SINGULAR, ClosedForm
from ocp_traj.robot.inverse_kinematics.screws import wrap

JUMP = 0.3
"""A joint that moves more than this (rad) between two poses is looked at more closely."""


@dataclass(frozen=True)
class Crossing:
    """A place where a path leaves a domain.

    Attributes
    ----------
    gap : int
        Gap between two poses, counted from 1.
    fraction : float
        How far along the gap, 0 to 1.
    factor : str
        Which factor of det J vanishes: "shoulder", "elbow" or "wrist".
    ends : bool
        The branch ends there (beyond, the pose is out of reach); otherwise it jumps.
    """

    gap: int
    fraction: float
    factor: str
    ends: bool

    def __str__(self) -> str:
        what = "ends" if self.ends else "jumps"
        return (
            f"between waypoints {self.gap} and {self.gap + 1}, {100.0 * self.fraction:.1f} % of the way, "
            f"the path crosses det J = 0 ({self.factor}) and the domain's branch {what}"
        )


def domain_of(inverse: ClosedForm, q: Array) -> Array:
    """Return the signs (3,) of the domain that holds `q` (6,).

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
    signs: Array = np.sign(factors)
    return signs


def follow_domain(inverse: ClosedForm, poses: Array, start: Array) -> Array:
    """Return the positions (K, 6) that reach poses (K, 4, 4) in the domain of `start` (6,).

    Angles are taken in the turn nearest to the pose before; a row is NaN where the domain has no solution.
    """
    q = inverse.branches(poses, domain_of(inverse, start)[None]).q[:, 0]
    previous = np.asarray(start, dtype=np.float64)
    for row in q:
        row[:] = nearest_turns(inverse.robot, row, previous)
        previous = np.where(np.isnan(row), previous, row)
    return q


def find_crossings(
    inverse: ClosedForm, poses: Array, start: Array, samples: int = 16
) -> tuple[Crossing, ...]:
    """Return where the straight way from pose to pose leaves the domain of `start`, once a gap.

    Between poses (K, 4, 4) the tool's point moves on a line and its orientation turns about one axis. Every
    gap is sampled, and where a joint moves far between two samples the place is bisected: a jump that does
    not shrink is a crossing, and so is a branch that ceases to exist.
    """
    signs = domain_of(inverse, start)[None]
    crossings = []
    for gap in range(len(poses) - 1):
        fractions = np.linspace(0.0, 1.0, samples + 1)
        way = _Way(inverse, poses[gap], poses[gap + 1], signs)
        q = way(fractions)
        for index in range(samples):
            if _broken(q[index], q[index + 1]):
                crossing = _bisect(way, gap + 1, fractions[index], fractions[index + 1])
                if crossing is not None:
                    crossings.append(crossing)
                    break
    return tuple(crossings)


@dataclass(frozen=True)
class _Way:
    """The straight way between two poses, in one branch."""

    inverse: ClosedForm
    first: Array
    last: Array
    signs: Array

    def __call__(self, fractions: Array) -> Array:
        return self.inverse.branches(interpolate(self.first, self.last, fractions), self.signs).q[:, 0]

    def weakest_factor(self, fraction: float) -> str:
        """Return the name of the factor nearest to zero among those of branches that exist."""
        pose = interpolate(self.first, self.last, np.array([fraction]))
        margin = self.inverse.branches(pose, self.signs).margin[0, 0]
        return FACTORS[int(np.argmin(margin))]


def interpolate(first: Array, last: Array, fractions: Array) -> Array:
    """Return poses (N, 4, 4) on the straight way between two poses (4, 4)."""
    import pinocchio as pin

    turn = pin.log3(first[:3, :3].T @ last[:3, :3])
    poses = np.tile(np.eye(4), (len(fractions), 1, 1))
    poses[:, :3, :3] = [first[:3, :3] @ pin.exp3(fraction * turn) for fraction in fractions]
    poses[:, :3, 3] = first[:3, 3] + fractions[:, None] * (last[:3, 3] - first[:3, 3])
    return poses


def _broken(first: Array, second: Array) -> bool:
    """Whether two neighbouring positions are not clearly of one continuous branch."""
    return not float(np.max(np.abs(wrap(second - first)))) <= JUMP  # NaN counts as broken


def _bisect(way: _Way, gap: int, low: float, high: float) -> Crossing | None:
    """Return the crossing between two fractions, or None if the branch turns out to be continuous."""
    pending = [(low, high)]
    while pending:
        low, high = pending.pop()
        ends = way(np.array([low, high]))
        if not _broken(ends[0], ends[1]):
            continue
        if high - low < 1e-9:
            missing: npt.NDArray[np.bool_] = np.isnan(ends).max(axis=1)
            if missing.all():
                return Crossing(gap, low, "elbow", ends=True)
            inside = low if missing[1] else high
            return Crossing(gap, low, way.weakest_factor(inside), ends=bool(missing.any()))
        middle = 0.5 * (low + high)
        pending += [(middle, high), (low, middle)]
    return None
