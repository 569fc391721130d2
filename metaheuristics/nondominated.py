"""Non-dominated sorting and crowding for two objectives (cost, violation)."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np

from metaheuristics.arrays import FloatArray, IntArray


def front_numbers(cost: FloatArray, violation: FloatArray) -> IntArray:
    """Return the non-dominated front of each candidate, 0 = dominated by none.

    With two objectives, visited by rising cost (then violation), a candidate belongs to the first front whose
    last member has a larger violation; those last violations rise from front to front, so bisection finds it:
    O(p log p) (Jensen 2003, doi 10.1109/TEVC.2003.817234, sweep for two objectives).

    Parameters
    ----------
    cost, violation
        (p,) the two objectives, smaller is better.

    Returns
    -------
    IntArray
        (p,) front numbers from 0. Identical candidates share a front.
    """
    fronts = np.empty(cost.shape[0], dtype=np.intp)
    last: list[float] = []
    previous, front = (np.nan, np.nan), 0
    for i in np.lexsort((violation, cost)).tolist():
        point = (float(cost[i]), float(violation[i]))
        if point != previous:
            # The last violation of a front is its smallest: a front takes the point only if that is larger.
            front = bisect_right(last, point[1])
            if front == len(last):
                last.append(point[1])
            else:
                last[front] = point[1]
            previous = point
        fronts[i] = front
    return fronts


def find_front(first: FloatArray, second: FloatArray) -> IntArray:
    """Return the rows that no other matches or beats in both objectives, by rising first objective.

    Parameters
    ----------
    first, second
        (p,) the two objectives, smaller is better.

    Returns
    -------
    IntArray
        (f,) rows; of equal ones the first.
    """
    order = np.lexsort((second, first))
    best = np.minimum.accumulate(np.append(np.inf, second[order]))[:-1]
    return order[second[order] < best]


def crowding_distance(cost: FloatArray, violation: FloatArray, fronts: IntArray) -> FloatArray:
    """Return the crowding distance of each candidate inside its front (Deb et al. 2002, NSGA-II).

    Parameters
    ----------
    cost, violation
        (p,) the two objectives.
    fronts
        (p,) front numbers.

    Returns
    -------
    FloatArray
        (p,) sum over the objectives of the gap between the two neighbours, relative to the front's range;
        infinite at the ends of a front.
    """
    p = cost.shape[0]
    order = np.lexsort((violation, cost, fronts))
    sorted_fronts = fronts[order]
    starts = np.flatnonzero(np.r_[True, sorted_fronts[1:] != sorted_fronts[:-1]])
    ends = np.r_[starts[1:], p] - 1
    sizes = ends - starts + 1
    distance = np.zeros(p)
    for objective in (cost[order], violation[order]):
        finite = np.where(np.isfinite(objective), objective, 0.0)
        extent = np.repeat(np.abs(finite[ends] - finite[starts]), sizes)
        gap = np.zeros(p)
        gap[1:-1] = np.abs(finite[2:] - finite[:-2])
        distance += np.divide(gap, extent, out=np.zeros(p), where=extent > 0.0)
    distance[starts] = np.inf
    distance[ends] = np.inf
    result = np.empty(p)
    result[order] = distance
    return result
