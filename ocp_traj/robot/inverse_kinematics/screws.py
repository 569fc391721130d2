"""Joint axes of a robot at zero, and the rotations and trigonometric equations closed forms are made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.arrays import Array, read_only

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot

PARALLEL = 1e-9
"""Two unit directions whose cross product is shorter than this are parallel."""
INTERSECT = 1e-8
"""Two lines closer than this, in m, intersect."""


@dataclass(frozen=True)
class Screws:
    """The axes of a robot of revolute joints at q = 0, in base axes.

    Attributes
    ----------
    directions : (n, 3)
    points : (n, 3)
        One point of each axis, m.
    home_inverse : (4, 4)
        Inverse of the pose of the tool at zero.
    """

    directions: Array
    points: Array
    home_inverse: Array

    def parallel(self, first: int, second: int) -> bool:
        """Whether two axes (counted from 0) are parallel."""
        cross = np.cross(self.directions[first], self.directions[second])
        return bool(np.linalg.norm(cross) < PARALLEL)

    def intersection(self, first: int, second: int) -> Array | None:
        """Return the point (3,) where two axes meet, None if they are parallel or miss each other."""
        if self.parallel(first, second):
            return None
        u, w = self.directions[first], self.directions[second]
        between = self.points[second] - self.points[first]
        along, _, _, _ = np.linalg.lstsq(np.column_stack([u, -w]), between, rcond=None)
        on_first = self.points[first] + along[0] * u
        on_second = self.points[second] + along[1] * w
        meets = np.linalg.norm(on_first - on_second) < INTERSECT
        return 0.5 * (on_first + on_second) if meets else None


def screws_of(robot: Robot) -> Screws:
    """Return the axes of a robot at zero."""
    import pinocchio as pin

    model = robot.bare_model
    data = model.createData()
    pin.forwardKinematics(model, data, np.zeros(robot.n))
    to_base = np.linalg.inv(robot.base_placement)
    directions, points = [], []
    for index, link in enumerate(robot.links):
        placement = data.oMi[index + 1]
        directions.append(to_base[:3, :3] @ placement.rotation @ link.alignment[:, 2])
        points.append((to_base @ np.append(placement.translation, 1.0))[:3])
    home = robot.pose(np.zeros(robot.n))
    return Screws(np.array(directions), np.array(points), read_only(np.linalg.inv(home)))


def rotate(axis: Array, angle: Array, vector: Array) -> Array:
    """Return `vector` (..., 3) turned about the constant unit `axis` (3,) by `angle` (...)."""
    along = vector @ axis
    across = vector - along[..., None] * axis
    return (
        along[..., None] * axis
        + np.cos(angle)[..., None] * across
        + np.sin(angle)[..., None] * np.cross(axis, across)
    )


def angle_about(axis: Array, start: Array, end: Array) -> Array:
    """Return the angle (...) about `axis` (3,) that turns `start` (..., 3) towards `end` (..., 3)."""
    first = start - (start @ axis)[..., None] * axis
    second = end - (end @ axis)[..., None] * axis
    sine = np.sum(np.cross(first, second) * axis, axis=-1)
    return np.arctan2(sine, np.sum(first * second, axis=-1))


def solve_trigonometric(a: Array, b: Array, c: Array, sign: Array) -> tuple[Array, Array]:
    """Solve a cos x + b sin x = c for the root on the side `sign` of the direction (a, b).

    Returns
    -------
    root : array
        x; where no root exists, the nearest angle.
    margin : array
        sin of the angle between root and (a, b): 0 where the two roots meet, NaN where there is none.
    """
    length = np.hypot(a, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = np.where(length > 0.0, c / length, np.inf)
    # Rounding may push a double root beyond 1; it is a root still, with margin zero.
    cosine = np.where(np.abs(np.abs(cosine) - 1.0) < 1e-12, np.sign(cosine), cosine)
    clipped = np.clip(cosine, -1.0, 1.0)
    margin = np.where(np.abs(cosine) <= 1.0, np.sqrt(1.0 - clipped * clipped), np.nan)
    return np.arctan2(b, a) + sign * np.arccos(clipped), margin


def wrap(angle: Array) -> Array:
    """Return angles in (-pi, pi]."""
    return angle - 2.0 * np.pi * np.ceil((angle - np.pi) / (2.0 * np.pi))
