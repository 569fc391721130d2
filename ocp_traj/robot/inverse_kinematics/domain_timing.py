"""Paper C's claim measured: the time saved by one unique domain against a filter of eight branches."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from ocp_traj.arrays import Array, ArrayLike
from ocp_traj.exceptions import UnreachablePoseError
from ocp_traj.robot.inverse_kinematics.closed_form import ClosedForm
from ocp_traj.robot.inverse_kinematics.screws import wrap
from ocp_traj.robot.inverse_kinematics.three_parallel_axes import ThreeParallelAxes
from ocp_traj.robot.inverse_kinematics.unique_domain import domain_of
from ocp_traj.robot.inverse_kinematics.universal_robots import ALL_SIGNS, universal_robots_table

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot


@dataclass(frozen=True)
class DomainTiming:
    """Times of two ways to solve the same path; both gave the same positions.

    Attributes
    ----------
    form : {"python", "vectorised"}
    eight_branches : (R,)
        Processor time of each repetition with all branches and the weighted nearest rule, s.
    one_domain : (R,)
        Processor time with the branch of the current domain only, s.
    """

    form: str
    eight_branches: Array
    one_domain: Array

    @property
    def saving(self) -> float:
        """Share of time saved, from the least times, which other work disturbs least; paper C reports 0.3976."""
        return float(1.0 - self.one_domain.min() / self.eight_branches.min())


def measure_domain_timing(
    robot: Robot,
    poses: Array,
    start: ArrayLike,
    weights: ArrayLike,
    form: Literal["python", "vectorised"] = "python",
    repeats: int = 10,
) -> DomainTiming:
    """Time the inverse kinematics of a path of a UR arm with eight branches and with one.

    Parameters
    ----------
    robot : Robot
        A UR arm.
    poses : (K, 4, 4)
        From its base to its tool.
    start : (6,)
        Near the first position, names the domain.
    weights : (6,)
        Of the nearest rule.
    form : {"python", "vectorised"}
        Plain Python, one pose at a time as in paper C, or NumPy over the whole path.
    repeats : int

    Raises
    ------
    UnreachablePoseError
        The two ways disagree: the path leaves its domain or the robot's reach.
    """
    first = np.asarray(start, dtype=np.float64)
    scale = np.asarray(weights, dtype=np.float64)
    make = _python_ways if form == "python" else _vectorised_ways
    eight, one = make(robot, poses, first, scale)
    difference = wrap(np.asarray(eight()) - np.asarray(one()))
    if not float(np.max(np.abs(difference))) < 1e-9:
        raise UnreachablePoseError(
            "the nearest branch is not that of one domain along this path, expected a path within one"
        )
    times = np.array([[_seconds(eight), _seconds(one)] for _ in range(repeats)])
    return DomainTiming(form, times[:, 0], times[:, 1])


def _seconds(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin


Way = Callable[[], ArrayLike]


def _python_ways(robot: Robot, poses: Array, start: Array, weights: Array) -> tuple[Way, Way]:
    table = universal_robots_table(robot)
    usual = robot.with_changes(base="base", tool="tool0")
    before = np.linalg.inv(usual.base_placement) @ robot.base_placement
    after = np.linalg.inv(robot.pose(start)) @ robot.pose(start, "tool0")
    rows = [(before @ pose @ after).tolist() for pose in poses]
    first, scale = start.tolist(), weights.tolist()
    opening = table.nearest(rows[0], first, scale)
    signs = next(k for k in ALL_SIGNS if opening is not None and table.solve(rows[0], k) == opening)

    def eight() -> list[tuple[float, ...]]:
        path, previous = [], first
        for row in rows:
            q = table.nearest(row, previous, scale)
            previous = (np.nan,) * 6 if q is None else q
            path.append(previous)
        return path

    def one() -> list[tuple[float, ...]]:
        return [table.solve(row, signs) or (np.nan,) * 6 for row in rows]

    return eight, one


def _vectorised_ways(robot: Robot, poses: Array, start: Array, weights: Array) -> tuple[Way, Way]:
    inverse = ThreeParallelAxes(robot)
    signs = domain_of(inverse, start)[None]
    return (
        lambda: _nearest_path(inverse, poses, start, weights),
        lambda: inverse.branches(poses, signs).q[:, 0],
    )


def _nearest_path(inverse: ClosedForm, poses: Array, start: Array, weights: Array) -> Array:
    """Return positions (K, 6) by the weighted nearest rule: all steps at once, then one walk."""
    q = inverse.branches(poses).q
    step = np.abs(wrap(q[1:, None, :, :] - q[:-1, :, None, :])) @ weights
    following = np.argmin(np.where(np.isnan(step), np.inf, step), axis=2).tolist()
    opening = np.abs(wrap(q[0] - start)) @ weights
    chosen = [int(np.argmin(np.where(np.isnan(opening), np.inf, opening)))]
    for choices in following:
        chosen.append(choices[chosen[-1]])
    return q[np.arange(len(q)), chosen]
