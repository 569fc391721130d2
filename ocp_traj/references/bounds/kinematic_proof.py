"""The proof of the kinematic bound: branch and bound over runs of gaps, then over the whole chain."""

from __future__ import annotations

from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.deadline import NO_DEADLINE, Deadline
from ocp_traj.references.bounds.branch_and_bound import SearchOutcome, prove_total
from ocp_traj.references.bounds.double_integrator import JointLimits, feasible, shortest_total
from ocp_traj.references.bounds.kinematic_estimate import stop_durations

MARGIN = 1e-9
"""Relative amount by which a proved bound is lowered, against rounding."""


def bounded_velocities(limits: JointLimits, total: float) -> JointLimits:
    """Return limits in which every velocity is finite: none above acceleration times duration is reached."""
    up = np.nan_to_num(limits.speeding.max(axis=0) * total, posinf=np.inf)
    down = np.nan_to_num(limits.braking.max(axis=0) * total, posinf=np.inf)
    reach = np.minimum(up, down)  # what was gained has to be lost again
    fastest, slowest = np.minimum(limits.fastest, reach), np.minimum(limits.slowest, reach)
    names = ("speeding", "braking", "nearest", "farthest", "start", "end")
    return JointLimits(fastest, slowest, **{name: getattr(limits, name) for name in names})


def prove_lower(
    limits: JointLimits, upper: float, gap: float, deadline: Deadline, largest_nodes: int
) -> SearchOutcome:
    """Return a lower bound of the total, as close to `upper` as the means allow."""
    blocks, nodes, chain = single_gaps(limits, upper, gap, deadline)
    target = upper * (1.0 - gap)
    if chain is not None and limits.gaps > 3:  # below, the search is faster without
        runs = [(first, first + length) for length in (2, 3) for first in range(limits.gaps - length + 1)]
        for done, (first, last) in enumerate(runs):
            if deadline.passed:
                break
            allowed = deadline.fraction(min(0.5, 2.0 / (len(runs) - done)))
            outcome = _block_bound(chain, blocks, first, last, gap, allowed)
            nodes += outcome.nodes
            blocks[first, last] = outcome.lower
    known = _combine(blocks, limits.gaps)
    if chain is None or known >= target or deadline.passed:
        return SearchOutcome(min(known, upper), nodes, known >= target)
    outcome = _search(chain, blocks, target, known, largest_nodes, deadline)
    return SearchOutcome(max(outcome.lower, known), nodes + outcome.nodes, outcome.complete)


def single_gaps(
    limits: JointLimits, upper: float, gap: float, deadline: Deadline = NO_DEADLINE
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
        if deadline.passed:
            break
        outcome = _block_bound(chain, blocks, first, first + 1, gap, deadline)
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
    deadline: Deadline,
) -> SearchOutcome:
    """Return a lower bound of the time of a run of gaps whose inner ends may have any velocity."""
    part = limits.part(first, last)
    inner = {(a - first, b - first): value for (a, b), value in blocks.items() if first <= a and b <= last}
    known = _combine(inner, last - first)
    upper = _block_total(part, known)
    return _search(part, inner, upper * (1.0 - 0.5 * gap), known, 40_000, deadline)


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
    deadline: Deadline,
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
        bound, 0 * ones, ones, target, start=known, largest_nodes=largest_nodes, time_limit=deadline.left
    )
