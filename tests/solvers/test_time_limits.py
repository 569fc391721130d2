"""Solvers begin nothing that cannot end within the time limit; the tests keep the time themselves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from metaheuristics import Solution, Status
from ocp_traj.solvers import Outcome, Request, Solver, outcomes
from ocp_traj.solvers.pace import EXACT_WORK, GRADIENT_WORK, derivatives_in_time
from ocp_traj.solving import solve
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.transcription import CondensedNlp, ExtraPoints, LiftedNlp, initial_guess

TASK = TrajectoryTask(
    np.array([[0.0], [1.0], [0.5], [1.5]]), Limits(velocity=1.0, acceleration=2.0, jerk=20.0), family="3-5-3"
)


class TimedNlp(CondensedNlp):
    """A condensed problem whose symbols take 1 s to make."""

    symbol_seconds = 1.0  # type: ignore[assignment]


@pytest.mark.parametrize(
    ("seconds", "order", "left"),
    [
        (None, 2, None),
        (2.0 + EXACT_WORK, 2, 1.0),
        (0.5 + EXACT_WORK, 1, EXACT_WORK - 0.5 - GRADIENT_WORK),
        (GRADIENT_WORK, 0, GRADIENT_WORK - 1.0),
    ],
)
def test_derivatives_are_built_as_far_as_there_is_time(
    seconds: float | None, order: int, left: float | None
) -> None:
    assert derivatives_in_time(TimedNlp(TASK), seconds) == (order, pytest.approx(left))


def test_the_lifted_form_is_quick_to_differentiate() -> None:
    task = TASK.changed(family="cubic")
    nlp = LiftedNlp(task, initial_guess(task), 4, ExtraPoints())
    assert derivatives_in_time(nlp, 0.1) == (2, 0.1)


def test_without_time_for_derivatives_the_start_is_the_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(CondensedNlp, "symbol_seconds", 1e6)
    result = solve(TASK, "ipopt", time_limit=1e3)
    assert result.solution.status is Status.TIME_EXHAUSTED
    assert result.feasible and "no time to build the problem's derivatives" in result.message


def test_with_some_time_the_second_derivatives_are_approximated(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(CondensedNlp, "symbol_seconds", 1e4)
    result = solve(TASK, "ipopt", time_limit=1e4 * (1.5 + GRADIENT_WORK))
    assert result.solution.status is Status.CONVERGED and result.feasible
    assert result.solution.evaluations > 0 and "nlp_hess_l" not in result.counts


class Slow(Solver):
    """Takes 4 s of a clock of its own for every run."""

    kind = "gradient"

    def __init__(self) -> None:
        self.now, self.limits = 0.0, []

    def run(self, task: TrajectoryTask, request: Request) -> Outcome:
        """Note the time allowed and let 4 s pass."""
        self.limits.append(request.time_limit)
        self.now += 4.0
        nlp = CondensedNlp(task)
        return Outcome(initial_guess(task), Solution.failed(nlp, "nothing", evaluations=1))


def test_no_run_is_begun_that_would_not_end_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    solver = Slow()
    clock: Any = type("Clock", (), {"perf_counter": staticmethod(lambda: solver.now)})
    monkeypatch.setattr(outcomes, "time", clock)
    found = outcomes.run_from_each(solver, TASK, Request(time_limit=10.0), [None] * 5, begin=0.0)
    assert solver.limits == [10.0, 6.0] and len(found) == 2  # 2 s would be left for the third
    solver.limits.clear()
    assert len(outcomes.run_from_each(solver, TASK, Request(time_limit=-1.0), [None], begin=0.0)) == 1
