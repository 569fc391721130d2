"""What a run of a gradient solver has cost, and its course, over all calls of the plug-in."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from metaheuristics import History, Status
from ocp_traj.solvers.solver import SMALLEST_BUDGET, Request


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

    @property
    def left(self) -> Request:
        """The request with what is left of budget and time."""
        return self.request.less(self.evaluations, time.perf_counter() - self.begin)

    def evaluations_left(self, most: int) -> int:
        """Return the iterations allowed: an evaluation or more each, `most` without a budget."""
        budget = self.left.budget
        return most if budget is None else max(0, min(most, budget - 1))

    def exhausted(self) -> Status | None:
        """Return why nothing more may be tried, None when it may."""
        return self.left.exhausted(SMALLEST_BUDGET)

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

    def totals(self, dimension: int) -> dict[str, Any]:
        """Return the fields of a `Solution` that say what the run has cost: evaluations, seconds, history.

        Parameters
        ----------
        dimension : int
            Number of variables d.
        """
        history = History.of(
            self.cost,
            evaluations=self.at,
            dimension=dimension,
            violation=self.violation,
            seconds=self.seconds,
        )
        spent = {name: getattr(self, name) for name in ("evaluations", "build_time", "solve_time")}
        return {**spent, "history": history}
