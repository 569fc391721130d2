"""The kinematic bound: the shortest time of any motion through the waypoints with continuous velocity.

Only the waypoints, rest at both ends and the velocity and acceleration limits count; the path between the
waypoints is free. Jerk, torque and position limits can only make a motion longer.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ocp_traj.arrays import Array, read_only
from ocp_traj.deadline import Deadline
from ocp_traj.references.bounds.double_integrator import JointLimits, least_total
from ocp_traj.references.bounds.kinematic_estimate import (
    LocalOptimum,
    LocalSearch,
    local_optimum,
    stop_durations,
)
from ocp_traj.references.bounds.kinematic_proof import MARGIN, bounded_velocities, prove_lower, single_gaps
from ocp_traj.references.reference import missing_packages
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.task.preparing import merged, prepare

SPLINE_ACCURACY = 0.01
"""A timing on TOPP-RA's first grid that is longer than another motion by more than this fraction is not looked at."""

_logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class KinematicBound:
    """Lower bound and local optimum of the duration of any motion through the waypoints.

    Attributes
    ----------
    lower : float or None
        Certified, s: no motion with continuous velocity is shorter. None where nothing could be proved.
    estimate : float or None
        A local optimum of the same problem, s: a motion that takes this long exists (for zero tolerance its
        durations passed the exact test). A shorter one may exist, but none shorter than `lower`.
    certified : bool
        True when `lower` is within the wanted gap of `estimate`: the estimate is the global optimum to that gap.
    message : str
        One sentence on what was proved.
    durations : (G,) array
        Of the estimate, s.
    velocities : (K, n) array
        At the waypoints, of the estimate, rad/s. Zero for joints that need not move.
    nodes : int
        Cells the proof looked at.
    """

    lower: float | None
    estimate: float | None
    certified: bool
    message: str
    durations: Array = field(default_factory=lambda: np.empty(0))
    velocities: Array = field(default_factory=lambda: np.empty((0, 0)))
    nodes: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "durations", read_only(self.durations))
        object.__setattr__(self, "velocities", read_only(self.velocities))


def kinematic_bound(
    task: TrajectoryTask,
    *,
    gap: float = 2e-3,
    time_limit: float = 20.0,
    largest_nodes: int = 400_000,
    starts: int = 8,
    rng: np.random.Generator | None = None,
) -> KinematicBound:
    """Return the kinematic bound of a task.

    The estimate comes from a smooth problem in durations and waypoint velocities. The proof is a branch and bound
    over the proportions of the durations alone: for given durations the waypoint velocities are eliminated
    exactly, joint by joint. Beyond three gaps the bounds of runs of neighbouring gaps are found first; they cut
    the boxes, and together bound the total by a linear programme where the search does not finish. Bounds of
    durations are not looked at, so equal consecutive waypoints are one point whether their gap has one or not.

    Parameters
    ----------
    task : TrajectoryTask
    gap : float
        Relative distance of lower bound and estimate to reach.
    time_limit : float
        Seconds, up to half of them for the estimate; what is known and proved until then is returned.
    largest_nodes : int
        Cells for the proof.
    starts : int
        Starting points of the local search; the first is the motion that stops at every waypoint.
    rng : numpy.random.Generator, optional
        For the other starting points; seeded with 0 when left out.
    """
    ready = prepare(task)
    single = merged(ready.task, _repeated(ready.task))
    bound = _bound_of_points(single.task, gap, Deadline(time_limit), largest_nodes, starts, rng)
    if not len(bound.durations):
        return bound
    durations = ready.restored_durations(single.restored_durations(bound.durations))
    return replace(bound, durations=durations, velocities=bound.velocities[single.points[ready.points]])


def _repeated(task: TrajectoryTask) -> NDArray[np.bool_]:
    """Return which gaps between equal waypoints may be left out of the bound, (K - 1,).

    Their boxes are the same, and so are the limits of the gap and of the one before it, or after it at the start:
    what moves in such a gap may count to that one.
    """
    waypoints, tolerance = np.asarray(task.waypoints), np.asarray(task.tolerance)
    same: NDArray[np.bool_] = (np.diff(waypoints, axis=0) == 0).all(axis=1)
    same &= (np.diff(tolerance, axis=0) == 0).all(axis=1)
    if same.all():
        return ~same
    as_before = np.ones(task.gaps, dtype=bool)
    for name in ("velocity", "acceleration"):
        limits = task.limits.get(name)
        as_before[1:] &= (limits[1:] == limits[:-1]).all(axis=(1, 2))
    first = int(np.argmin(same))
    as_before[:first] = as_before[1 : first + 1].all()
    return same & as_before


def _bound_of_points(
    task: TrajectoryTask,
    gap: float,
    deadline: Deadline,
    largest_nodes: int,
    starts: int,
    rng: np.random.Generator | None,
) -> KinematicBound:
    """Return the kinematic bound of a task whose consecutive waypoints differ; see `kinematic_bound`."""
    if np.any(task.boundary.velocity):
        return KinematicBound(
            None, None, False, "the ends are not at rest, the bound is defined from rest to rest"
        )
    moving, limits, reason = joint_limits(task)
    if reason:
        return KinematicBound(None, None, False, reason)
    gaps, n = task.gaps, task.n
    if not moving.any():
        still = np.zeros((gaps + 1, n))
        return KinematicBound(0.0, 0.0, True, "no joint needs to move", np.zeros(gaps), still)
    rng = np.random.default_rng(0) if rng is None else rng
    tolerance = np.asarray(task.tolerance)[:, moving]
    waypoints = np.asarray(task.waypoints)[:, moving]
    boxes = (waypoints - tolerance, waypoints + tolerance) if tolerance.any() else None
    upper = _estimate(task, moving, limits, boxes, LocalSearch(starts, rng, deadline.fraction(0.5)))
    proof = prove_lower(limits, upper.total, gap, deadline, largest_nodes)
    proved = proof.lower if boxes is None else max(proof.lower, _straight(limits, *boxes))
    lower = min(proved * (1.0 - MARGIN), upper.total)
    certified = lower >= upper.total * (1.0 - gap) * (1.0 - 2 * MARGIN)
    velocities = np.zeros((gaps + 1, n))
    velocities[:, moving] = upper.velocities
    message = (
        f"the estimate is the global optimum to {100 * gap:g} %"
        if certified
        else f"proved to {100 * (1.0 - lower / upper.total):.3g} % of the estimate when the search was stopped"
    )
    return KinematicBound(lower, upper.total, certified, message, upper.durations, velocities, proof.nodes)


def gap_bounds(task: TrajectoryTask, total: float) -> Array:
    """Return a certified least duration (G,) of every gap in motions that last no longer than `total`, s."""
    moving, limits, reason = joint_limits(task)
    if reason or not moving.any():
        return np.zeros(task.gaps)
    blocks = single_gaps(limits, total, 2e-3)[0]
    return np.array([blocks[first, first + 1] for first in range(task.gaps)]) * (1.0 - MARGIN)


def joint_limits(task: TrajectoryTask) -> tuple[Array, JointLimits, str]:
    """Return which joints need to move (n,), their limits, and why there is no bound (empty if there is one)."""
    waypoints, tolerance = np.asarray(task.waypoints), np.asarray(task.tolerance)
    distance = np.diff(waypoints, axis=0)
    slack = tolerance[1:] + tolerance[:-1]
    velocity, acceleration = task.limits.get("velocity"), task.limits.get("acceleration")
    nearest, farthest = distance - slack, distance + slack
    moving = (waypoints - tolerance).max(axis=0) > (waypoints + tolerance).min(axis=0)
    rest = np.zeros((2, int(moving.sum())))
    limits = JointLimits(
        velocity[:, 1][:, moving],
        -velocity[:, 0][:, moving],
        acceleration[:, 1][:, moving],
        -acceleration[:, 0][:, moving],
        nearest[:, moving],
        farthest[:, moving],
        start=rest,
        end=rest,
    )
    if moving.any():
        for name, part in (("velocity", (0, 1)), ("acceleration", (2, 3))):
            pair = [
                (limits.fastest, limits.slowest, limits.speeding, limits.braking)[index] for index in part
            ]
            if any((side <= 0).any() for side in pair):
                return moving, limits, f"a joint that has to move has a {name} limit of 0"
        if not np.isfinite(limits.fastest).any() and not np.isfinite(limits.speeding).any():
            return moving, limits, "no velocity or acceleration limit bounds the duration"
    return moving, limits, ""


def _straight(limits: JointLimits, lowest: Array, highest: Array) -> float:
    """Return the time that the way between any two boxes takes at full speed, s: the gaps' own ways may all vanish."""
    least = 0.0
    for first in range(limits.gaps):
        for last in range(first + 1, limits.gaps + 1):
            fastest = limits.fastest[first:last].max(axis=0)
            slowest = limits.slowest[first:last].max(axis=0)
            up, down = lowest[last] - highest[first], lowest[first] - highest[last]
            least = max(least, float(np.maximum(up / fastest, down / slowest).max()))
    return least


def _estimate(
    task: TrajectoryTask,
    moving: Array,
    limits: JointLimits,
    boxes: tuple[Array, Array] | None,
    search: LocalSearch,
) -> LocalOptimum:
    """Return the best motion known: the local search's, one along a spline, or that with stops at all waypoints.

    The one along a spline through the waypoints, timed by TOPP-RA, is a start of the search, too.
    """
    deadline = search.deadline
    stops = LocalOptimum(stop_durations(limits), np.zeros((limits.gaps + 1, limits.fastest.shape[1])))
    centres = 0.5 * (limits.nearest + limits.farthest)
    through = replace(limits, nearest=centres, farthest=centres)
    timed = _along_spline(task, moving) if _is_exact(through) else None
    found = local_optimum(limits, search, boxes, timed)
    known = [_verified(limits, motion, deadline) for motion in (found,) if motion is not None]
    if timed is not None and (not known or timed.total < known[0].total * (1.0 + SPLINE_ACCURACY)):
        known.append(_verified(through, timed, deadline))
    if not known:
        _logger.warning("the local search for the kinematic bound failed; stopping at every waypoint stands in")
        known.append(_verified(limits, stops, deadline))
    return min([*known, stops], key=lambda motion: motion.total)


def _along_spline(task: TrajectoryTask, moving: Array) -> LocalOptimum | None:
    """Return the motion along a spline through the waypoints, timed by TOPP-RA on its first grid, or None."""
    from ocp_traj.references.timing.toppra_reference import FIRST_GRID, toppra_reference

    if missing_packages(("toppra",)):
        return None
    limits = Limits(velocity=task.limits.get("velocity"), acceleration=task.limits.get("acceleration"))
    bare = TrajectoryTask(np.asarray(task.waypoints), limits)
    result = toppra_reference(bare, "chord", points=FIRST_GRID)
    if result.duration is None:
        return None
    durations = np.diff(result.waypoint_times)
    node = np.searchsorted(result.times, result.waypoint_times)
    return LocalOptimum(durations, result.v[node][:, moving]) if (durations > 0).all() else None


def _is_exact(limits: JointLimits) -> bool:
    """Return whether the test of durations is exact: without boxes around waypoints, with bounded accelerations."""
    bounded = np.isfinite(limits.speeding).all() and np.isfinite(limits.braking).all()
    return bool(bounded and np.array_equal(limits.nearest, limits.farthest))


def _verified(limits: JointLimits, found: LocalOptimum, deadline: Deadline) -> LocalOptimum:
    """Return a motion with its total moved to where the exact test of its durations changes.

    Solver tolerances are gone then: a motion with these durations exists. Where the test is only necessary the answer
    stays; where it fails the total is infinite.
    """
    if not _is_exact(limits):
        return found
    proportions = found.durations / found.total
    bounded = bounded_velocities(limits, stop_durations(limits).sum())
    total = least_total(bounded, proportions, 1.01 * found.total, deadline)
    if not np.isfinite(total):
        return LocalOptimum(np.full(limits.gaps, np.inf), found.velocities)
    return LocalOptimum(proportions * total, found.velocities * found.total / total)
