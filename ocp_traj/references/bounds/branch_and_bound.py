"""Branch and bound over the proportions of durations, shared by both certificates.

From rest to rest a feasible motion stays feasible when it is slowed uniformly. So for proportions p of the total
duration there is a least total T(p), and the best total is the minimum of T over the simplex: one dimension less
than durations. A cell is a box of proportions cut by the simplex; its bound is the largest total for which no
motion with proportions in the cell exists.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ocp_traj.arrays import Array

BATCH = 4096
"""Cells looked at in one go, of up to `BATCH_GAPS` gaps; fewer where there are more gaps, so that time is kept."""

BATCH_GAPS = 16

CellBound = Callable[[Array, Array, Array, float], Array]
"""Takes (P, G) lower and (P, G) upper proportions, (P,) known bounds and the target; returns (P,) bounds."""


@dataclass(frozen=True)
class SearchOutcome:
    """Result of a search.

    Attributes
    ----------
    lower : float
        No cell has a smaller total than this.
    nodes : int
        Cells looked at.
    complete : bool
        True when every cell was shown to reach the target.
    """

    lower: float
    nodes: int
    complete: bool


def prove_total(
    bound: CellBound,
    low: Array,
    high: Array,
    target: float,
    *,
    start: float = 0.0,
    largest_nodes: int = 400_000,
    time_limit: float = np.inf,
) -> SearchOutcome:
    """Split cells until each is shown to need at least `target`, or until the means are used up.

    Parameters
    ----------
    bound : CellBound
    low, high : (G,) arrays
        First cell, proportions.
    target : float
        Total duration to be proved as a lower bound, s.
    start : float
        A lower bound already known, s.
    largest_nodes, time_limit
        Cells, and seconds, after which the search stops with what it has.
    """
    began = time.perf_counter()
    lows, highs, empty = _cut_by_simplex(low[None, :], high[None, :])
    if empty[0]:
        return SearchOutcome(target, 0, True)
    bounds = bound(lows, highs, np.array([start]), target)
    nodes, batch = 1, max(1, min(BATCH, BATCH * BATCH_GAPS // len(low)))
    while True:
        open_cells = bounds < target
        if not open_cells.any():
            return SearchOutcome(target, nodes, True)
        lows, highs, bounds = lows[open_cells], highs[open_cells], bounds[open_cells]
        if nodes >= largest_nodes or time.perf_counter() - began > time_limit:
            return SearchOutcome(float(bounds.min()), nodes, False)
        order = np.argsort(bounds, kind="stable")
        chosen, kept = order[:batch], order[batch:]
        new_lows, new_highs, parents = _split(lows[chosen], highs[chosen])
        new_bounds = bound(new_lows, new_highs, bounds[chosen][parents], target)
        nodes += len(new_bounds)
        lows = np.concatenate([lows[kept], new_lows])
        highs = np.concatenate([highs[kept], new_highs])
        bounds = np.concatenate([bounds[kept], new_bounds])


def _cut_by_simplex(lows: Array, highs: Array) -> tuple[Array, Array, npt.NDArray[np.bool_]]:
    """Tighten boxes by sum(p) = 1; returns lower, upper and which boxes are empty."""
    for _ in range(2):
        lows = np.maximum(lows, 1.0 - (highs.sum(axis=1, keepdims=True) - highs) - 1e-15)
        highs = np.minimum(highs, 1.0 - (lows.sum(axis=1, keepdims=True) - lows) + 1e-15)
    return lows, highs, np.asarray((lows > highs).any(axis=1))


def _split(lows: Array, highs: Array) -> tuple[Array, Array, npt.NDArray[np.int_]]:
    """Halve every box at its longest side, for its distance from zero; return children and their parents."""
    side = np.argmax((highs - lows) / (lows + 0.05), axis=1)
    rows = np.arange(len(lows))
    middle = 0.5 * (lows[rows, side] + highs[rows, side])
    left_high, right_low = highs.copy(), lows.copy()
    left_high[rows, side] = middle
    right_low[rows, side] = middle
    children = (np.concatenate([lows, right_low]), np.concatenate([left_high, highs]))
    new_lows, new_highs, empty = _cut_by_simplex(*children)
    parents = np.concatenate([rows, rows])
    return new_lows[~empty], new_highs[~empty], parents[~empty]
