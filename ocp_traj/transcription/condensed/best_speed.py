"""The cheapest uniform speed of a motion, for a population at once: an exact one-dimensional search.

At scale s of the durations, with r = 1 / s and u = r^2, every cost is a polynomial in r plus, for energies, a sum of
weight |still + damping r + moving u| over samples and joints. Without viscous friction the whole is convex in u and
its kinks are known, so one sort finds the piece the minimum lies in.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.arrays import Array

POWERS = np.arange(-1, 6)
"""Powers of r in `SpeedCost.smooth`: time has -1, squared torque -1 to 3, squared acceleration 3, squared jerk 5."""

BISECTIONS = 60
"""Halvings of the last bracket: down to rounding."""

GRID = 64
"""Points of the first look where friction makes the cost non-convex."""

GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


def row_of(power: int) -> int:
    """Return the row of `SpeedCost.smooth` that a power of r has."""
    return power + 1


@dataclass(frozen=True)
class Kinks:
    """The non-smooth part, sum_i weight_i |still_i + damping_i r + moving_i u|; arrays (entries, p)."""

    weight: Array
    still: Array
    damping: Array | None
    moving: Array

    def at(self, root: Array) -> Array:
        """Return the value at r of every candidate, (p,)."""
        inner = self.moving * root**2
        inner += self.still
        if self.damping is not None:
            inner += self.damping * root
        np.absolute(inner, out=inner)
        return np.einsum("ip,ip->p", self.weight, inner)


@dataclass(frozen=True)
class SpeedCost:
    """smooth polynomial (7, p) in r with powers `POWERS`, and kinks if there are."""

    smooth: Array
    kinks: tuple[Kinks, ...]

    def at(self, root: Array) -> Array:
        """Return the cost at r of every candidate, (p,)."""
        value: Array = (self.smooth * root ** POWERS[:, None]).sum(axis=0)
        for part in self.kinks:
            value = value + part.at(root)
        return value

    def smooth_slope(self, u: Array, candidates: Any = None) -> Array:
        """Return the derivative of the smooth part by u."""
        smooth = self.smooth if candidates is None else self.smooth[:, candidates]
        used = np.flatnonzero(self.smooth.any(axis=1) & (POWERS != 0))
        slope = np.zeros(len(u))
        for row in used:
            slope += smooth[row] * (POWERS[row] / 2) * u ** (POWERS[row] / 2 - 1)
        return slope


def cheapest_root(cost: SpeedCost, slowest: Array, fastest: Array) -> Array:
    """Return the r in [slowest, fastest] of least cost for every candidate, (p,)."""
    if any(part.damping is not None for part in cost.kinks):
        return _search_from_grid(cost, slowest, fastest)
    left, right = slowest**2, fastest**2
    slope = np.zeros(len(left))
    if cost.kinks:
        left, right, slope = _bracket(cost, left, right)
    root = np.sqrt(_bisect(cost, left, right, slope))
    ends = np.stack([slowest, np.clip(root, slowest, fastest), fastest])
    values = np.stack([cost.at(end) for end in ends])
    return ends[values.argmin(axis=0), np.arange(len(root))]


def _bracket(cost: SpeedCost, left: Array, right: Array) -> tuple[Array, Array, Array]:
    """Return the two neighbouring kinks the minimum lies between, and the slope of the kinked part there."""
    slope = np.zeros(len(left))
    places, jumps, owners = [], [], []
    for part in cost.kinks:
        at_left, at_right = part.still + part.moving * left, part.still + part.moving * right
        steep = part.weight * part.moving
        slope += np.einsum("ip,ip->p", steep, np.sign(np.where(at_left != 0, at_left, at_right)))
        entry, owner = np.nonzero(at_left * at_right < 0)
        places.append(-part.still[entry, owner] / part.moving[entry, owner])
        jumps.append(2 * np.abs(steep[entry, owner]))
        owners.append(owner)
    place, jump, owner = (np.concatenate(parts) for parts in (places, jumps, owners))
    order = np.lexsort((place, owner))
    place, jump, owner = place[order], jump[order], owner[order]
    first = np.searchsorted(owner, np.arange(len(left) + 1))
    total = np.concatenate([[0.0], np.cumsum(jump)])
    after = slope[owner] + (total[1:] - total[first[owner]])
    # The slope grows from kink to kink: those where it is still negative lie below the minimum.
    below = cost.smooth_slope(place, owner) + after < 0
    count = np.bincount(owner, weights=below, minlength=len(left)).astype(int)
    last = first[:-1] + count
    padded = np.append(place, np.nan)
    new_left = np.where(count > 0, padded[last - 1], left)
    new_right = np.where(last < first[1:], padded[last], right)
    return new_left, new_right, slope + (total[last] - total[first[:-1]])


def _bisect(cost: SpeedCost, left: Array, right: Array, slope: Array) -> Array:
    """Return where the derivative by u, smooth part plus `slope`, changes sign; an end if it does not."""
    for _ in range(BISECTIONS):
        middle = (left + right) / 2
        rising = cost.smooth_slope(middle) + slope > 0
        left, right = np.where(rising, left, middle), np.where(rising, middle, right)
    return (left + right) / 2


def _search_from_grid(cost: SpeedCost, slowest: Array, fastest: Array) -> Array:
    """Golden-section search around the best of a grid: viscous friction leaves no convexity to rely on."""
    grid = slowest + (fastest - slowest) * np.linspace(0.0, 1.0, GRID)[:, None]
    values = np.stack([cost.at(root) for root in grid])
    best, column = values.argmin(axis=0), np.arange(len(slowest))
    left, right = grid[np.maximum(best - 1, 0), column], grid[np.minimum(best + 1, GRID - 1), column]
    for _ in range(40):
        inner, outer = right - GOLDEN * (right - left), left + GOLDEN * (right - left)
        closer = cost.at(inner) < cost.at(outer)
        left, right = np.where(closer, left, inner), np.where(closer, outer, right)
    middle = (left + right) / 2
    return np.where(cost.at(middle) < values[best, column], middle, grid[best, column])
