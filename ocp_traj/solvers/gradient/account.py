"""What a run of a gradient solver has cost, and its course, over all calls of the plug-in."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from metaheuristics import History, Solution, Status
from ocp_traj.arrays import Array
from ocp_traj.solvers.solver import Request
from ocp_traj.transcription.nlp import Nlp


@dataclass
class Account:
    """Calls, seconds and iterations.

    Attributes
    ----------
    request : Request
        Gives the limits.
    begin : float
        Clock when the run began, s.
    counts : dict
        Calls of every function of the problem.
    """

    request: Request
    begin: float = field(default_factory=time.perf_counter)
    counts: dict[str, int] = field(default_factory=dict)
    evaluations: int = 0
    build_time: float = 0.0
    solve_time: float = 0.0
    cost: list[float] = field(default_factory=list)
    violation: list[float] = field(default_factory=list)
    at: list[int] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)

    def seconds_left(self) -> float | None:
        """Return the seconds left, None without a limit."""
        limit = self.request.time_limit
        return None if limit is None else limit - (time.perf_counter() - self.begin)

    def evaluations_left(self, most: int) -> int:
        """Return the iterations allowed: an evaluation or more each, `most` without a budget."""
        budget = self.request.budget
        return most if budget is None else max(0, min(most, budget - self.evaluations - 1))

    def exhausted(self) -> Status | None:
        """Return why nothing more may be tried, None when it may."""
        left = self.seconds_left()
        if left is not None and left <= 0:
            return Status.TIME_EXHAUSTED
        return Status.BUDGET_EXHAUSTED if self.evaluations_left(1) == 0 else None

    def record(self, stats: dict[str, Any], elapsed: float) -> None:
        """Add one call's counts and history."""
        begin = time.perf_counter() - self.begin - elapsed
        found = {name: int(value) for name, value in stats.items() if name.startswith("n_call_nlp_")}
        for name, value in found.items():
            short = name.removeprefix("n_call_")
            self.counts[short] = self.counts.get(short, 0) + value
        calls = [
            value
            for name, value in found.items()
            if name in ("n_call_nlp_f", "n_call_nlp_g", "n_call_nlp_fg")
        ]
        spent = max([*calls, 1])
        iterations = stats.get("iterations", {})
        cost = list(iterations.get("obj", ()))
        share = np.linspace(0, 1, len(cost)) if len(cost) > 1 else np.ones(len(cost))
        self.cost += cost
        self.violation += list(iterations.get("inf_pr", ()))
        self.at += [self.evaluations + round(fraction * spent) for fraction in share]
        self.seconds += [begin + fraction * elapsed for fraction in share]
        self.evaluations += spent
        self.solve_time += elapsed

    def solution(
        self, nlp: Nlp, x: Array, cost: float, violation: Array, status: Status, message: str
    ) -> Solution:
        """Return the shared interface's solution."""
        count = len(self.cost)
        history = History(
            np.array(self.at, dtype=np.intp),
            np.array(self.cost),
            np.array(self.violation),
            np.array(self.seconds),
            np.full((count, len(x)), np.nan),
            np.full(count, np.nan),
        )
        return Solution(
            nlp,
            x,
            cost,
            violation,
            status,
            message,
            self.evaluations,
            self.build_time,
            self.solve_time,
            history,
        )
