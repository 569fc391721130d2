"""Where a Cartesian path crosses det J = 0 and so leaves the domain it started in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from ocp_traj.arrays import Array
from ocp_traj.robot.inverse_kinematics.branch_choice import nearest_turns
from ocp_traj.robot.inverse_kinematics.closed_form import FACTORS, SIGNS, ClosedForm
from ocp_traj.robot.inverse_kinematics.screws import wrap
from ocp_traj.robot.inverse_kinematics.unique_domain import domain_of

JUMP = 0.3
"""A joint that moves more than this (rad) between two poses is looked at more closely."""

_EFFECTS = {
    "ends": "the straight way crosses det J = 0 ({}) and the domain's branch ends",
    "jumps": "the straight way crosses det J = 0 ({}) and the domain's branch jumps",
    "swings": "the nearest solution lies beyond det J = 0 ({}) and the domain's branch swings far",
}


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
    effect : {"ends", "jumps", "swings"}
        On the straight way from pose to pose the domain's branch ends (beyond, the pose is out of reach), or
        jumps; or it stays continuous but passes a singularity so closely that another domain's branch is nearer at
        the next pose, and the straight motion of the joints to that one crosses det J = 0.
    """

    gap: int
    fraction: float
    factor: str
    effect: Literal["ends", "jumps", "swings"]

    def __str__(self) -> str:
        place = f"between waypoints {self.gap} and {self.gap + 1}, {100.0 * self.fraction:.1f} % of the way, "
        return place + _EFFECTS[self.effect].format(self.factor)


def find_crossings(
    inverse: ClosedForm, poses: Array, start: Array, samples: int = 16
) -> tuple[Crossing, ...]:
    """Return where the way from pose to pose leaves the domain of `start` (6,), at most one crossing a gap.

    Between poses (K, 4, 4) the tool's point moves on a line and its orientation turns about one axis. Every gap is
    sampled, and where a joint moves far between two samples the place is bisected: a jump that does not shrink is a
    crossing, and so is a branch that ceases to exist. Then all branches at the gap's end are compared.

    Parameters
    ----------
    inverse : ClosedForm
    poses : (K, 4, 4) transforms, m
    start : (6,) rad
        Reaches the first pose.
    samples : int
        Looked at in every gap.
    """
    signs = domain_of(inverse, start)
    found = (
        _on_the_straight_way(inverse, poses, gap, signs, samples)
        or _to_the_nearest(inverse, poses, gap, signs)
        for gap in range(len(poses) - 1)
    )
    return tuple(crossing for crossing in found if crossing is not None)


@dataclass(frozen=True)
class _Way:
    """The straight way between two poses, in one branch."""

    inverse: ClosedForm
    first: Array
    last: Array
    signs: Array

    def __call__(self, fractions: Array) -> Array:
        return self.inverse.branches(interpolate(self.first, self.last, fractions), self.signs[None]).q[:, 0]

    def weakest_factor(self, fraction: float) -> str:
        """Return the name of the factor nearest to zero at a fraction where the branch exists."""
        pose = interpolate(self.first, self.last, np.array([fraction]))
        margin = self.inverse.branches(pose, self.signs[None]).margin[0, 0]
        return FACTORS[int(np.argmin(margin))]


def interpolate(first: Array, last: Array, fractions: Array) -> Array:
    """Return poses (N, 4, 4) on the straight way between two poses (4, 4)."""
    import pinocchio as pin

    turn = pin.log3(first[:3, :3].T @ last[:3, :3])
    poses = np.tile(np.eye(4), (len(fractions), 1, 1))
    poses[:, :3, :3] = [first[:3, :3] @ pin.exp3(fraction * turn) for fraction in fractions]
    poses[:, :3, 3] = first[:3, 3] + fractions[:, None] * (last[:3, 3] - first[:3, 3])
    return poses


def _on_the_straight_way(
    inverse: ClosedForm, poses: Array, gap: int, signs: Array, samples: int
) -> Crossing | None:
    way = _Way(inverse, poses[gap], poses[gap + 1], signs)
    fractions = np.linspace(0.0, 1.0, samples + 1)
    q = way(fractions)
    for index in range(samples):
        if _broken(q[index], q[index + 1]):
            crossing = _bisect(way, gap + 1, float(fractions[index]), float(fractions[index + 1]))
            if crossing is not None:
                return crossing
    return None


def _broken(first: Array, second: Array) -> bool:
    """Whether two neighbouring positions are not clearly of one continuous branch."""
    return not float(np.max(np.abs(wrap(second - first)))) <= JUMP  # NaN counts as broken


def _bisect(way: _Way, gap: int, low: float, high: float) -> Crossing | None:
    """Return the first crossing between two fractions, or None if the branch turns out to be continuous."""
    pending = [(low, high)]
    while pending:
        low, high = pending.pop()
        ends = way(np.array([low, high]))
        if not _broken(ends[0], ends[1]):
            continue
        if high - low > 1e-9:
            middle = 0.5 * (low + high)
            pending += [(middle, high), (low, middle)]
            continue
        missing: npt.NDArray[np.bool_] = np.isnan(ends).max(axis=1)
        if not missing.all():
            inside = high if missing[0] else low
            return Crossing(gap, low, way.weakest_factor(inside), "ends" if missing.any() else "jumps")
    return None


def _to_the_nearest(inverse: ClosedForm, poses: Array, gap: int, signs: Array) -> Crossing | None:
    """Return a crossing if at the gap's end the branch of another domain is nearer than that of `signs`."""
    own = int(np.flatnonzero((signs == SIGNS).all(axis=1))[0])
    both = inverse.branches(poses[gap : gap + 2])
    origin = both.q[0, own]
    ends = nearest_turns(inverse.robot, both.q[1], origin)
    distance = np.sum(np.abs(ends - origin), axis=1)
    if not np.isfinite(distance).any():
        return None
    nearest = int(np.nanargmin(distance))
    if nearest == own:
        return None
    factor = int(np.flatnonzero(SIGNS[nearest] != signs)[0])
    low, high = 0.0, 1.0
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        at_middle = inverse.factors(origin + middle * (ends[nearest] - origin))[0, factor]
        low, high = (middle, high) if at_middle * signs[factor] > 0.0 else (low, middle)
    return Crossing(gap + 1, low, FACTORS[factor], "swings")
