"""Least durations of runs of neighbouring gaps, proved first: they cut the boxes of the whole motion."""

from __future__ import annotations

import time
from fractions import Fraction
from typing import Any

from ocp_traj.proofs import checker
from ocp_traj.proofs.box_search import BoxSearch
from ocp_traj.proofs.not_proved import NotProved

LONGEST = 3
"""Gaps of the longest run."""
STEPS = 10
"""Halvings of the interval in which a run's least duration is looked for."""
SECONDS = 0.02
"""Fraction of the time left that one attempt may take."""


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
    known = sum((needed for begin, end, needed in search.lemmas if first <= begin < end <= last
                 and end == begin + 1), Fraction(0))  # fmt: skip
    low, high = float(known), float(search.total)
    best = None
    for _ in range(STEPS):
        middle = 0.5 * (low + high) if best is not None or known else 0.5 * high
        seconds = SECONDS * max(deadline - time.monotonic(), 0.0)
        attempt = BoxSearch(search, first, last, Fraction(middle), time.monotonic() + seconds)
        try:
            nodes = attempt.run()
        except NotProved:
            high = middle
            continue
        low = middle
        best = {"first": first + 1, "last": last, "total": middle.hex(), "tree": nodes}
    return best
