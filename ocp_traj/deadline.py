"""When time is up: one clock for everything that shares a time limit."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Deadline:
    """A time limit that has begun to run.

    Attributes
    ----------
    seconds : float
        Allowed from now on, s; infinite where there is no limit.
    clock : callable
        Seconds since any fixed moment.
    began : float
        Its reading when the limit began to run, s.
    """

    seconds: float = math.inf
    clock: Callable[[], float] = time.perf_counter
    began: float = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "began", self.clock())

    @property
    def spent(self) -> float:
        """Seconds since the limit began to run."""
        return self.clock() - self.began

    @property
    def left(self) -> float:
        """Seconds that are left, not below 0."""
        return max(self.seconds - self.spent, 0.0)

    @property
    def passed(self) -> bool:
        """True when no time is left."""
        return self.left <= 0.0

    def fraction(self, fraction: float) -> Deadline:
        """Return a deadline for the next step, which may take this fraction of what is left."""
        return Deadline(fraction * self.left, self.clock)

    def __str__(self) -> str:
        return f"{self.seconds:.3g} s"


NO_DEADLINE = Deadline()
"""For who has all the time."""
