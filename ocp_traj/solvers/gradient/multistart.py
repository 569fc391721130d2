"""A gradient solver from several starts: the closed-form timing, and random proportions of its durations."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ocp_traj.exceptions import InputError
from ocp_traj.solvers.gradient.gradient import Gradient
from ocp_traj.solvers.hybrid import join_outcomes
from ocp_traj.solvers.solver import Outcome, Request, Solver
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription import CondensedNlp, initial_guess


@dataclass(frozen=True)
class MultiStart(Solver):
    """A gradient solver run from several motions; the best answer counts.

    Parameters
    ----------
    gradient : Gradient
    starts : int
        Number of runs; the first starts from the closed-form timing (or the request's warm start).
    spread : float
        Standard deviation of the logarithm of each gap's duration in the other starts.
    jobs : int
        Processes; with more than one, each run gets an equal share of the budget beforehand.
    """

    kind: ClassVar[str] = "hybrid"

    gradient: Gradient
    starts: int = 5
    spread: float = 0.5
    jobs: int = 1

    def __post_init__(self) -> None:
        if self.starts < 1 or self.jobs < 1:
            raise InputError(f"starts is {self.starts} and jobs {self.jobs}, expected at least 1")
        if not self.spread >= 0.0:
            raise InputError(f"spread is {self.spread}, expected 0 or more")

    @classmethod
    def from_settings(cls, settings: dict[str, Any]) -> MultiStart:
        """Return the solver; ``plugin`` names the gradient solver."""
        given = dict(settings)
        return cls(Gradient(plugin=str(given.pop("plugin", "ipopt"))), **given)

    def check_available(self) -> None:
        """Raise `UnavailableError` when the gradient solver does not load."""
        self.gradient.check_available()

    def run(self, task: TrajectoryTask, request: Request) -> Outcome:
        """Solve from every start; see `Solver.run`."""
        starts = self._starts(task, request)
        if self.jobs > 1:
            return self._run_parallel(task, request, starts)
        clock = time.perf_counter()
        outcomes: list[Outcome] = []
        for start in starts:
            spent = sum(outcome.solution.evaluations for outcome in outcomes)
            left = None if request.budget is None else request.budget - spent
            seconds = (
                None if request.time_limit is None else request.time_limit - (time.perf_counter() - clock)
            )
            if outcomes and ((left is not None and left < 2) or (seconds is not None and seconds <= 0)):
                break
            outcomes.append(
                self.gradient.run(task, Request(request.seed, left, seconds, request.progress, start))
            )
        return join_outcomes(task, outcomes)

    def _starts(self, task: TrajectoryTask, request: Request) -> list[Any]:
        rng = np.random.default_rng(request.seed)
        base = initial_guess(task) if request.warm_start is None else request.warm_start
        factors = np.exp(self.spread * rng.standard_normal((self.starts - 1, task.gaps)))
        others = [initial_guess(task, durations) for durations in factors * base.segment_durations]
        return [request.warm_start, *others]

    def _run_parallel(self, task: TrajectoryTask, request: Request, starts: list[Any]) -> Outcome:
        from joblib import Parallel, delayed

        share = None if request.budget is None else max(2, request.budget // len(starts))
        allowed = len(starts) if request.budget is None else max(1, request.budget // 2)
        requests = [
            Request(request.seed, share, request.time_limit, None, start) for start in starts[:allowed]
        ]
        outcomes = Parallel(n_jobs=self.jobs)(
            delayed(_run_portable)(self.gradient, task, part) for part in requests
        )
        return join_outcomes(task, outcomes)


def _run_portable(gradient: Gradient, task: TrajectoryTask, request: Request) -> Outcome:
    """Solve in a worker; symbols cannot be sent back, so the answer is told in the condensed form's variables."""
    outcome = gradient.run(task, request)
    assert outcome.trajectory is not None  # a gradient solver always has a motion, feasible or not
    nlp = CondensedNlp(task)
    x = nlp.encode(outcome.trajectory)
    judged = nlp.evaluate(x)
    solution = replace(
        outcome.solution, problem=nlp, x=x, cost=float(judged.cost[0]), violation=judged.violation[0]
    )
    return replace(outcome, solution=solution)
