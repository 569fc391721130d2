"""Least durations of runs of neighbouring gaps, proved first: they cut the boxes of the whole motion."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from ocp_traj.proofs import checker
from ocp_traj.proofs.box_search import BoxSearch
from ocp_traj.proofs.not_proved import NotProved

LONGEST = 3
"""Gaps of the longest run."""
STEPS = 10
"""Halvings of the interval in which a run's least duration is looked for."""
LARGEST_LEMMA = 150
"""Nodes of the tree of a lemma."""


def prove_lemmas(search: checker.Search, deadline: float) -> list[dict[str, Any]]:
    """Return lemmas with their trees, shortest runs first, and add them to the search.

    Parameters
    ----------
    search : checker.Search
    deadline : float
        Of `time.monotonic`; runs for which time is short are left out.
    """
    lemmas = []
    for length in range(1, min(LONGEST, search.task.gaps - 1) + 1):
        for first in range(search.task.gaps - length + 1):
            lemma = _longest_proved(search, first, first + length, deadline)
            if lemma is not None:
                total = Fraction(float.fromhex(lemma["total"]))
                search.lemmas.append((first, first + length, total))
                lemmas.append(lemma)
    return lemmas


def _longest_proved(search: checker.Search, first: int, last: int, deadline: float) -> dict[str, Any] | None:
    """Return the lemma with the longest duration that bisection finds, or None."""
    singles = [needed for begin, end, needed in search.lemmas if first <= begin < last and end == begin + 1]
    known = sum(singles, Fraction(0)) if last > first + 1 else Fraction(0)
    low, high = float(known), float(search.total)
    best = None
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        attempt = BoxSearch(search, first, last, Fraction(middle), deadline, largest=LARGEST_LEMMA)
        try:
            nodes = attempt.run()
        except NotProved:
            high = middle
            continue
        low = middle
        best = {"first": first + 1, "last": last, "total": middle.hex(), "tree": nodes}
    return best
