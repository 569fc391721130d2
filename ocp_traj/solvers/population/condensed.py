"""What all solvers of the condensed form share: the encoding, and the way an outcome is made."""

from __future__ import annotations

import time
from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from metaheuristics import Solution
from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError
from ocp_traj.solvers.population.between_samples import KEPT, may_be_refused, refine
from ocp_traj.solvers.population.explaining import explained
from ocp_traj.solvers.solver import DEFAULT_BUDGET, Outcome, Request, Solver
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription import initial_guess
from ocp_traj.transcription.condensed.condensed import CondensedNlp


@dataclass(frozen=True)
class CondensedSolver(Solver):
    """A solver that searches the box of the condensed form.

    Parameters
    ----------
    encoding : str
        ``"durations"``, ``"log-durations"`` or ``"scaled"``; see `CondensedNlp`.
    offsets : str
        ``"spline"`` or ``"chord"``: what virtual knots are measured from; see `CondensedNlp`.
    samples : int
        Samples per gap.
    extrema : str
        ``"auto"``, ``"exact"`` or ``"sampled"``.
    """

    encoding: str = "durations"
    offsets: str = "spline"
    samples: int = 16
    extrema: str = "auto"

    def problem(
        self, task: TrajectoryTask, denser: int = 1, box: tuple[Array, Array] | None = None
    ) -> CondensedNlp:
        """Return the task as this solver sees it, with `denser` times its samples, in a box of its variables."""
        return CondensedNlp(
            task,
            encoding=self.encoding,
            offsets=self.offsets,
            samples=denser * self.samples,
            extrema=self.extrema,
            box=box,
        )

    def run(self, task: TrajectoryTask, request: Request) -> Outcome:
        """Search all joints together; see `Solver.run`."""
        if task.search.protocol == "per-joint":
            raise InputError("the solver moves all joints together, expected search.protocol 'shared', or PerJoint")
        begin = time.perf_counter()
        nlp = self.problem(task)
        start, spent, counts = self.start_candidates(nlp, request)
        build_time = time.perf_counter() - begin
        solution = self.search_between_samples(nlp, request, start, spent)
        solution = replace(
            solution,
            build_time=solution.build_time + build_time,
            evaluations=solution.evaluations + spent,
        )
        counts = {**counts, "evaluate": solution.evaluations - spent}
        answered = solution.problem
        assert isinstance(answered, CondensedNlp)
        solution, diagnosis = explained(answered, solution)
        return Outcome(answered.decode(solution.x), solution, counts, diagnosis)

    def search_between_samples(
        self, nlp: CondensedNlp, request: Request, start: Any, spent: int
    ) -> Solution:
        """Search, and go on beside the answer where the judge would refuse it for what lies between samples."""
        total = (request.budget or DEFAULT_BUDGET) - spent
        kept = int(KEPT * total) if may_be_refused(nlp.task, nlp) else 0
        if not kept:
            return self.search(nlp, request, start, spent)
        solution = self.search(nlp, replace(request, budget=total - kept), start)
        rest = replace(request, budget=total).less(solution.evaluations, solution.seconds)
        return refine(nlp.task, solution, rest, self.problem, self.search)

    def start_candidates(self, nlp: CondensedNlp, request: Request) -> tuple[Any, int, dict[str, int]]:
        """Return known candidates (k, d) or None, the evaluations spent on them, and counts of calls."""
        if request.warm_start is None:
            return None, 0, {}
        return encode_motion(nlp, request.warm_start)[None], 0, {}

    @abstractmethod
    def search(self, nlp: CondensedNlp, request: Request, start: Any = None, spent: int = 0) -> Solution:
        """Search the box of a condensed problem with what is left of the budget."""


def encode_motion(nlp: CondensedNlp, trajectory: Trajectory) -> Any:
    """Return the variables (d,) inside the box nearest to a motion of any family."""
    same = trajectory.family == nlp.task.family and len(trajectory.breakpoints) == nlp.segments + 1
    motion = trajectory if same else initial_guess(nlp.task, trajectory.segment_durations)
    return np.clip(nlp.encode(motion), nlp.lower, nlp.upper)
