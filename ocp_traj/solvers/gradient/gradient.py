"""Gradient solvers: CasADi's nlpsol plug-ins on the lifted form, continued, refined and made exact."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from itertools import islice
from typing import Any, ClassVar

from metaheuristics import Solution, Status
from ocp_traj.exceptions import UnavailableError
from ocp_traj.solvers.gradient.account import Account
from ocp_traj.solvers.gradient.attempt import attempt, build_nlp
from ocp_traj.solvers.gradient.held import attempt_held, gives_durations
from ocp_traj.solvers.gradient.plugin_call import ACCEPTABLE, Answer
from ocp_traj.solvers.gradient.plugins import unavailable_reason
from ocp_traj.solvers.gradient.ranking import best_answer, is_feasible
from ocp_traj.solvers.gradient.reasons.diagnosis import certain_conflict
from ocp_traj.solvers.gradient.recovery import recover
from ocp_traj.solvers.gradient.settings import GradientSettings, Tuning
from ocp_traj.solvers.gradient.starts import further_starts
from ocp_traj.solvers.solver import Outcome, Request, Solver
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.guess import initial_guess

NEARLY_KEPT = 1e-3
"""Excess in a row up to which an answer that did not converge is shown to the audit."""


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
        """Solve a task from one start, or from several that compete; mend or explain a failure."""
        self.check_available()
        account = Account(request)
        conflict = certain_conflict(task)
        if conflict:
            nlp = build_nlp(task, initial_guess(task), self, account)
            spent, message = account.totals(nlp.dimension), "No motion is possible."
            nothing = Solution.failed(nlp, message, status=Status.INFEASIBLE, **spent)
            return Outcome(None, nothing, account.counts, conflict)
        answer, stands = _confirmed(task, self._solve_from_starts(task, request.warm_start, account))
        diagnosis = ""
        if not stands:
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

    def _solve_from_starts(self, task: TrajectoryTask, warm: Trajectory | None, account: Account) -> Answer:
        """Return the best answer of the first start and of those that compete with it."""
        if warm is not None:
            return attempt(task, warm, self, account, continued=False)
        if gives_durations(task):
            return attempt_held(task, self, account)
        answers = [attempt(task, None, self, account, continued=True)]
        if task.family.has_lifted_form:
            most = max(self.tuning.few_knots_iterations, account.evaluations)
            alike = replace(self, iterations=min(self.iterations, most))  # no start costs much more than the first
            for start in islice(further_starts(task), self.tuning.further_starts):
                if account.exhausted():
                    break
                answers.append(attempt(task, start, alike, account, continued=True))
        return best_answer(task, answers)

    def check_available(self) -> None:
        """Raise `UnavailableError` when the plug-in does not load, or does not solve a small problem."""
        reason = unavailable_reason(self.plugin)
        if reason:
            raise UnavailableError(f"solver {self.plugin!r} cannot be used: {reason}")


def _confirmed(task: TrajectoryTask, answer: Answer) -> tuple[Answer, bool]:
    """Return an answer with the status the audit gives it, and whether it needs no recovery.

    What IPOPT calls acceptable converged where its motion is feasible. On long paths the last digits may take more
    iterations than all else; a motion that a little slowing makes feasible is still far better than the best one
    with fewer knots.
    """
    if answer.solved:
        return answer, True
    near = answer.violation.max(initial=0.0) < NEARLY_KEPT and answer.status is not Status.TIME_EXHAUSTED
    if not (near and is_feasible(task, answer.trajectory)):
        return answer, False
    return (replace(answer, status=Status.CONVERGED) if answer.message == ACCEPTABLE else answer), True
