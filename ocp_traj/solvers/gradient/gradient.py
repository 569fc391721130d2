"""Gradient solvers: CasADi's nlpsol plug-ins on the lifted form, continued, refined and made exact."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar

from metaheuristics import Solution, Status
from ocp_traj.exceptions import UnavailableError
from ocp_traj.solvers.gradient.account import Account
from ocp_traj.solvers.gradient.attempt import attempt, build_nlp
from ocp_traj.solvers.gradient.diagnosis import certain_conflict
from ocp_traj.solvers.gradient.plugins import unavailable_reason
from ocp_traj.solvers.gradient.recovery import recover
from ocp_traj.solvers.gradient.settings import GradientSettings, Tuning
from ocp_traj.solvers.solver import Outcome, Request, Solver
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.guess import initial_guess


@dataclass(frozen=True)
class Gradient(GradientSettings, Solver):
    """An nlpsol plug-in; see `GradientSettings` for its parameters."""

    kind: ClassVar[str] = "gradient"

    @classmethod
    def from_settings(cls, settings: dict[str, Any]) -> Gradient:
        """Return the solver; names of `Tuning` reach its tuning."""
        known = {entry.name for entry in fields(Tuning)}
        solver = super().from_settings({key: settings[key] for key in settings if key not in known})
        tuning = Tuning(**{key: settings[key] for key in settings if key in known})
        return replace(solver, tuning=tuning)

    def run(self, task: TrajectoryTask, request: Request) -> Outcome:
        """Solve a task: few knots first, then all, then the points between samples; explain a failure."""
        self.check_available()
        account = Account(request)
        conflict = certain_conflict(task)
        if conflict:
            nlp = build_nlp(task, initial_guess(task), self, account)
            spent, message = account.totals(nlp.dimension), "No motion is possible."
            nothing = Solution.failed(nlp, message, status=Status.INFEASIBLE, **spent)
            return Outcome(None, nothing, account.counts, conflict)
        answer = attempt(task, request.warm_start, self, account, continued=request.warm_start is None)
        diagnosis = ""
        if not answer.solved:
            answer, diagnosis = recover(task, answer, self, account)
        solution = Solution(
            problem=answer.nlp,
            x=answer.x,
            cost=answer.cost,
            violation=answer.violation,
            status=answer.status,
            message=answer.message,
            **account.totals(answer.nlp.dimension),
        )
        return Outcome(answer.trajectory, solution, account.counts, diagnosis)

    def check_available(self) -> None:
        """Raise `UnavailableError` when the plug-in does not load, or does not solve a small problem."""
        reason = unavailable_reason(self.plugin)
        if reason:
            raise UnavailableError(f"solver {self.plugin!r} cannot be used: {reason}")
