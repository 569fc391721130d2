"""A gradient solver from several starts: the closed-form timing, and random proportions of its durations."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ocp_traj.exceptions import InputError
from ocp_traj.solvers.gradient.gradient import Gradient
from ocp_traj.solvers.gradient.starts import DURATION_SPREAD, random_factors
from ocp_traj.solvers.outcomes import join_outcomes, run_from_each
from ocp_traj.solvers.solver import SMALLEST_BUDGET, Outcome, Request, Solver
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
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
    spread: float = DURATION_SPREAD
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
        begin = time.perf_counter()
        base = initial_guess(task) if request.warm_start is None else request.warm_start
        factors = random_factors(task, np.random.default_rng(request.seed), self.starts - 1, self.spread)
        others = [initial_guess(task, each * base.segment_durations) for each in factors]
        starts = [request.warm_start, *others]
        if self.jobs > 1:
            return self._run_parallel(task, request, starts)
        return join_outcomes(task, run_from_each(self.gradient, task, request, starts, begin=begin))

    def _run_parallel(self, task: TrajectoryTask, request: Request, starts: list[Trajectory | None]) -> Outcome:
        from joblib import Parallel, delayed

        share = None if request.budget is None else max(SMALLEST_BUDGET, request.budget // len(starts))
        allowed = len(starts) if request.budget is None else max(1, request.budget // SMALLEST_BUDGET)
        requests = [
            replace(request, budget=share, progress=None, warm_start=start) for start in starts[:allowed]
        ]
        outcomes = Parallel(n_jobs=self.jobs)(
            delayed(_run_portable)(self.gradient, task, part) for part in requests
        )
        return join_outcomes(task, outcomes)


def _run_portable(gradient: Gradient, task: TrajectoryTask, request: Request) -> Outcome:
    """Solve in a worker; symbols cannot be sent back, so the answer is given in the condensed form's variables."""
    outcome = gradient.run(task, request)
    assert outcome.trajectory is not None  # a gradient solver always has a motion, feasible or not
    nlp = CondensedNlp(task)
    x = nlp.encode(outcome.trajectory)
    judged = nlp.evaluate(x)
    solution = replace(
        outcome.solution, problem=nlp, x=x, cost=float(judged.cost[0]), violation=judged.violation[0]
    )
    return replace(outcome, solution=solution)
