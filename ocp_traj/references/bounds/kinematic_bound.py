"""The kinematic bound: the shortest time of any motion through the waypoints with continuous velocity.

Only the waypoints, rest at both ends and the velocity and acceleration limits count; the path between the
waypoints is free. Jerk, torque and position limits can only make a motion longer.
"""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ocp_traj.arrays import Array, read_only
from ocp_traj.references.bounds.branch_and_bound import SearchOutcome, prove_total
from ocp_traj.references.bounds.double_integrator import JointLimits, feasible, shortest_total
from ocp_traj.references.bounds.kinematic_estimate import LocalOptimum, local_optimum, stop_durations
from ocp_traj.task import merged, prepare

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask

MARGIN = 1e-9
"""Relative amount by which a proved bound is lowered, against rounding."""

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
        Seconds for the proof; what is proved until then is returned.
    largest_nodes : int
        Cells for the proof.
    starts : int
        Starting points of the local search; the first is the motion that stops at every waypoint.
    rng : numpy.random.Generator, optional
        For the other starting points; seeded with 0 when left out.
    """
    ready = prepare(task)
    single = merged(ready.task, _repeated(ready.task))
    bound = _bound_of_points(single.task, gap, time_limit, largest_nodes, starts, rng)
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
    time_limit: float,
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
    upper = _verified(limits, local_optimum(limits, starts, rng, boxes))
    proof = prove_lower(limits, upper.total, gap, time_limit, largest_nodes)
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
    blocks = _single_gaps(limits, total, 2e-3, np.inf)[0]
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


def _verified(limits: JointLimits, found: LocalOptimum | None) -> LocalOptimum:
    """Return the local optimum with its total moved to where the exact test of its durations changes.

    Solver tolerances are gone then: a motion with these durations exists. The motion that stops at every waypoint
    stands in where the solver found nothing. With a tolerance around waypoints, or with unlimited accelerations,
    the test is only necessary, and the solver's answer stays.
    """
    stops = stop_durations(limits)
    still = np.zeros((limits.gaps + 1, limits.fastest.shape[1]))
    fallback = LocalOptimum(stops, still)
    if found is None:
        _logger.warning(
            "the local search for the kinematic bound failed; stopping at every waypoint stands in"
        )
        found = fallback
    exact = np.array_equal(limits.nearest, limits.farthest) and np.isfinite(limits.speeding).all()
    if not (exact and np.isfinite(limits.braking).all()):
        return found
    proportions = found.durations / found.total
    bounded = bounded_velocities(limits, stops.sum())
    total = float(shortest_total(bounded, proportions[None, :], 1.01 * found.total)[0])
    if not np.isfinite(total):
        return fallback if fallback.total < found.total or not np.isfinite(found.total) else found
    return LocalOptimum(proportions * total, found.velocities * found.total / total)


def bounded_velocities(limits: JointLimits, total: float) -> JointLimits:
    """Return limits in which every velocity is finite: none above acceleration times duration is reached."""
    up = np.nan_to_num(limits.speeding.max(axis=0) * total, posinf=np.inf)
    down = np.nan_to_num(limits.braking.max(axis=0) * total, posinf=np.inf)
    reach = np.minimum(up, down)  # what was gained has to be lost again
    fastest, slowest = np.minimum(limits.fastest, reach), np.minimum(limits.slowest, reach)
    names = ("speeding", "braking", "nearest", "farthest", "start", "end")
    return JointLimits(fastest, slowest, **{name: getattr(limits, name) for name in names})


def prove_lower(
    limits: JointLimits, upper: float, gap: float, time_limit: float, largest_nodes: int
) -> SearchOutcome:
    """Return a lower bound of the total, as close to `upper` as the means allow."""
    began = time.perf_counter()
    blocks, nodes, chain = _single_gaps(limits, upper, gap, time_limit)
    target = upper * (1.0 - gap)
    if chain is not None and limits.gaps > 3:  # below, the search is faster without
        for length in (2, 3):
            for first in range(limits.gaps - length + 1):
                left = time_limit - (time.perf_counter() - began)
                outcome = _block_bound(chain, blocks, first, first + length, gap, 0.5 * left)
                nodes += outcome.nodes
                blocks[first, first + length] = outcome.lower
    known = _combine(blocks, limits.gaps)
    if chain is None or known >= target:
        return SearchOutcome(min(known, upper), nodes, known >= target)
    left = max(time_limit - (time.perf_counter() - began), 0.0)
    outcome = _search(chain, blocks, target, known, largest_nodes, left)
    return SearchOutcome(max(outcome.lower, known), nodes + outcome.nodes, outcome.complete)


def _single_gaps(
    limits: JointLimits, upper: float, gap: float, seconds: float
) -> tuple[dict[tuple[int, int], float], int, JointLimits | None]:
    """Return the bounds of single gaps, the cells used, and the joints with bounded acceleration (None if none)."""
    shortest = _speed_durations(limits)
    blocks = {(first, first + 1): float(shortest[first]) for first in range(limits.gaps)}
    accelerating = np.isfinite(limits.speeding).all(axis=0) & np.isfinite(limits.braking).all(axis=0)
    if not accelerating.any():
        return blocks, 0, None
    chain = bounded_velocities(_joints(limits, accelerating), upper)
    nodes = 0
    for first in range(limits.gaps):
        outcome = _block_bound(chain, blocks, first, first + 1, gap, seconds)
        nodes += outcome.nodes
        blocks[first, first + 1] = max(outcome.lower, blocks[first, first + 1])
    return blocks, nodes, chain


def _joints(limits: JointLimits, chosen: Any) -> JointLimits:
    names = ("fastest", "slowest", "speeding", "braking", "nearest", "farthest", "start", "end")
    return JointLimits(*(getattr(limits, name)[:, chosen] for name in names))


def _speed_durations(limits: JointLimits) -> Array:
    """Return the least duration (G,) of every gap at full speed."""
    forwards = np.where(limits.nearest > 0, limits.nearest / limits.fastest, 0.0)
    backwards = np.where(limits.farthest < 0, -limits.farthest / limits.slowest, 0.0)
    return np.asarray(np.maximum(forwards, backwards).max(axis=1))


def _block_bound(
    limits: JointLimits,
    blocks: dict[tuple[int, int], float],
    first: int,
    last: int,
    gap: float,
    seconds: float,
) -> SearchOutcome:
    """Return a lower bound of the time of a run of gaps whose inner ends may have any velocity."""
    part = limits.part(first, last)
    inner = {(a - first, b - first): value for (a, b), value in blocks.items() if first <= a and b <= last}
    known = _combine(inner, last - first)
    upper = _block_total(part, known)
    return _search(part, inner, upper * (1.0 - 0.5 * gap), known, 40_000, seconds)


def _block_total(part: JointLimits, known: float) -> float:
    """Return a total that some proportions of a run of gaps reach, by a coarse random search."""
    rng = np.random.default_rng(1)
    gaps = part.gaps
    proportions = np.ones((1, 1)) if gaps == 1 else rng.dirichlet(np.ones(gaps), 200)
    largest = max(4.0 * float(stop_durations(part).sum()), 2.0 * known)
    totals = shortest_total(part, proportions, largest, iterations=26)
    for step in 0.1 * 0.5 ** np.arange(9) if gaps > 1 else ():
        centre = proportions[np.argsort(totals)[:10]]
        moved = np.abs(np.repeat(centre, 10, axis=0) + rng.normal(size=(len(centre) * 10, gaps)) * step)
        proportions = np.concatenate([centre, moved / moved.sum(axis=1, keepdims=True)])
        totals = shortest_total(part, proportions, largest, iterations=26)
    best = float(totals.min())
    return best if np.isfinite(best) else largest


def _combine(blocks: dict[tuple[int, int], float], gaps: int) -> float:
    """Return the least total of durations that respect the bounds of all runs of gaps (a linear programme)."""
    if all(last == first + 1 for first, last in blocks):
        return sum(blocks.values()) * (1.0 - MARGIN)
    from scipy.optimize import linprog

    rows = np.zeros((len(blocks), gaps))
    for row, (first, last) in enumerate(blocks):
        rows[row, first:last] = -1.0
    answer = linprog(np.ones(gaps), A_ub=rows, b_ub=-np.array(list(blocks.values())), bounds=(0, None))
    return float(answer.fun) * (1.0 - MARGIN) if answer.status == 0 else 0.0


def _search(
    limits: JointLimits,
    blocks: dict[tuple[int, int], float],
    target: float,
    known: float,
    largest_nodes: int,
    seconds: float,
) -> SearchOutcome:
    """Run the branch and bound for a chain of gaps."""
    if known >= target:
        return SearchOutcome(known, 0, True)
    rows = np.array(
        [[first <= gap < last for gap in range(limits.gaps)] for first, last in blocks], dtype=float
    )
    needed = np.array(list(blocks.values()))

    def possible(lows: Array, highs: Array, total: Array) -> Array:
        shortest, longest = lows * total[:, None], highs * total[:, None]
        result: Array = (longest @ rows.T >= needed * (1.0 - MARGIN)).all(axis=1)
        if result.any():
            result[result] = feasible(limits, shortest[result], longest[result])
        return result

    def bound(lows: Array, highs: Array, parents: Array, goal: float) -> Array:
        bounds = np.where(possible(lows, highs, np.full(len(lows), goal)), parents, goal)
        open_cells = np.flatnonzero(bounds < goal)
        low, high = bounds[open_cells], np.full(len(open_cells), goal)
        for _ in range(3):
            middle = 0.5 * (low + high)
            alive = possible(lows[open_cells], highs[open_cells], middle)
            low, high = np.where(alive, low, middle), np.where(alive, middle, high)
        bounds[open_cells] = low
        return bounds

    ones = np.ones(limits.gaps)
    return prove_total(
        bound, 0 * ones, ones, target, start=known, largest_nodes=largest_nodes, time_limit=seconds
    )
