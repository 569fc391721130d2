"""Trees of boxes of durations whose leaves the checker can refute: the evidence of a lower bound.

A shorter motion could be slowed to last exactly the duration to be proved, so boxes of durations with that sum are
split until something refutes each. All tests are the checker's own, in exact arithmetic.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from ocp_traj.proofs import checker
from ocp_traj.proofs.not_proved import NotProved

Box = tuple[list[Fraction], list[Fraction]]
Node = list[Any]

PLACES = 2**30
"""Splits lie at multiples of 1/PLACES s, so that fractions stay short."""
LARGEST_TREE = 60_000
"""Nodes, some 3 MB."""
NEAR_ZERO = Fraction(1, 20)
"""Fraction of the total that is added to a duration before the relative widths of a box are compared."""


@dataclass
class BoxSearch:
    """A depth-first search for one tree.

    Attributes
    ----------
    search : checker.Search
        Task, total of the whole motion and lemmas.
    first, last : int
        The run of gaps from `first` to before `last`.
    total : Fraction
        What their durations sum to, s.
    deadline : float
        Of `time.monotonic`.
    refute : callable, optional
        Takes a box and returns a leaf that refutes it, or None; asked instead of trying joints and lemmas.
    largest : int
        Nodes after which the search gives up.
    """

    search: checker.Search
    first: int
    last: int
    total: Fraction
    deadline: float
    refute: Callable[[list[Fraction], list[Fraction]], Node | None] | None = None
    largest: int = LARGEST_TREE
    nodes: list[Node] = field(default_factory=list)

    def run(self) -> list[Node]:
        """Return the tree, depth first.

        Raises
        ------
        NotProved
            Time or size ran out, or a box cannot be split any further.
        """
        gaps = self.search.task.gaps
        stack: list[tuple[Box, Node | None]] = [(([Fraction(0)] * gaps, [self.total] * gaps), None)]
        while stack:
            (low, high), previous = stack.pop()
            if time.monotonic() > self.deadline or len(self.nodes) > self.largest:
                raise NotProved(f"{float(self.total):.9g} s is not proved within the time and size allowed")
            if not checker.cut(low, high, self.first, self.last, self.total):
                self.nodes.append(["empty"])
                continue
            leaf = self._leaf(low, high, previous)
            if leaf is not None:
                self.nodes.append(leaf)
                continue
            gap, place = self._place(low, high)
            self.nodes.append(["split", gap + 1, float(place).hex()])
            longer = (checker.replaced(low, gap, place), list(high))
            stack += [(longer, previous), ((list(low), checker.replaced(high, gap, place)), previous)]
        return self.nodes

    def _leaf(self, low: list[Fraction], high: list[Fraction], previous: Node | None) -> Node | None:
        if self.refute is not None:
            return self.refute(low, high)
        for index, (begin, end, needed) in enumerate(self.search.lemmas):
            if self.first <= begin and end <= self.last and sum(high[begin:end]) < needed:
                return ["lemma", index + 1]
        for joint, begin, end in self._candidates():
            if checker.cannot_pass(self.search.joints[joint], begin, end, low, high):
                self._last_used = (joint, begin, end)
                return ["joint", joint + 1, begin + 1, end]
        return None

    _last_used: tuple[int, int, int] | None = None

    def _candidates(self) -> Iterator[tuple[int, int, int]]:
        """Yield joints and runs of gaps: the last one that refuted a box, then long runs before short ones."""
        if self._last_used is not None:
            yield self._last_used
        for length in range(self.last - self.first, 0, -1):
            for begin in range(self.first, self.last - length + 1):
                for joint, row in enumerate(self.search.joints):
                    if row and (joint, begin, begin + length) != self._last_used:
                        yield joint, begin, begin + length

    def _place(self, low: list[Fraction], high: list[Fraction]) -> tuple[int, Fraction]:
        """Return the gap with the widest range for its length, and its middle."""
        shift = NEAR_ZERO * self.total
        widths = {g: float((high[g] - low[g]) / (low[g] + shift)) for g in range(self.first, self.last)}
        gap = max(widths, key=widths.__getitem__)
        place = Fraction(round((low[gap] + high[gap]) / 2 * PLACES), PLACES)
        if not low[gap] < place < high[gap]:
            where = f"durations of gap {gap + 1} near {float(place):.9g} s"
            raise NotProved(f"{float(self.total):.9g} s cannot be proved: {where} are not refuted")
        return gap, place
