"""What a problem says about a batch of candidates."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from metaheuristics.arrays import FloatArray, freeze


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Costs and constraint violations of p candidates.

    Parameters
    ----------
    cost
        (p,) the value to minimise, in the problem's own unit.
    violation
        (p, m) how far each constraint row is broken, scaled by its limit, never negative, 0 where it is
        kept. Left out: no constraints, (p, 0).

    Raises
    ------
    ValueError
        If the shapes do not fit each other, or a violation is negative.

    Notes
    -----
    NaN and infinity are allowed here: they are what the problem answered. `scores` turns them into the
    worst possible candidate.
    """

    cost: FloatArray
    violation: FloatArray
    _scores: Any = field(init=False, repr=False)

    def __init__(self, cost: npt.ArrayLike, violation: npt.ArrayLike | None = None) -> None:
        costs = np.asarray(cost, dtype=np.float64)
        if costs.ndim != 1:
            raise ValueError(f"The cost has shape {costs.shape}, expected one number a candidate, (p,).")
        p = costs.shape[0]
        rows = np.empty((p, 0)) if violation is None else np.asarray(violation, dtype=np.float64)
        if rows.ndim != 2 or rows.shape[0] != p:
            raise ValueError(f"The violation has shape {rows.shape}, expected ({p}, m) for {p} candidates.")
        if rows.shape[1] and (rows < 0.0).any():
            raise ValueError(f"The smallest violation is {np.nanmin(rows)}, expected 0 or more (0 = kept).")
        object.__setattr__(self, "cost", costs)
        object.__setattr__(self, "violation", rows)
        object.__setattr__(self, "_scores", None)

    @property
    def total_violation(self) -> FloatArray:
        """(p,) sum over the constraint rows; 0 for a feasible candidate."""
        if not self.violation.shape[1]:
            return np.zeros(self.cost.shape[0])
        return self.violation.sum(axis=1)

    @property
    def scores(self) -> tuple[FloatArray, FloatArray]:
        """Cost and total violation with every broken candidate made the worst.

        Returns
        -------
        cost, violation
            (p,) each. A candidate whose cost or violation is NaN or infinite (of either sign: a cost of minus
            infinity is a broken evaluation, not a triumph) gets infinity in both.
        """
        # Kept by hand: functools.cached_property takes a lock, which costs as much as the work itself.
        if self._scores is None:
            if self.violation.shape[1]:
                scores = score(self.cost, self.total_violation)
            elif np.count_nonzero(np.isfinite(self.cost)) == self.cost.shape[0]:
                scores = self.cost, list_zeros(self.cost.shape[0])
            else:
                scores = score(self.cost, list_zeros(self.cost.shape[0]))
            object.__setattr__(self, "_scores", scores)
        return self._scores


@lru_cache(maxsize=64)
def list_zeros(p: int) -> FloatArray:
    """Return the total violation (p,) of candidates without constraints, read-only and kept."""
    return freeze(np.zeros(p))


def score(cost: FloatArray, violation: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return cost and total violation (p,) with infinity in both where either is not finite."""
    fine = np.isfinite(cost)
    fine &= np.isfinite(violation)
    # Counting is four times faster than fine.all() for a small batch.
    if np.count_nonzero(fine) == cost.shape[0]:
        return cost, violation
    broken = ~fine
    return np.where(broken, np.inf, cost), np.where(broken, np.inf, violation)
