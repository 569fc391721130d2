"""Every status a solve can end with is reached by a real solve."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import casadi as ca
import pytest

from helpers.small_tasks import ARM_POINTS, arm_task, plain_task
from metaheuristics import Status
from ocp_traj.case import load_case
from ocp_traj.solvers import Request
from ocp_traj.solvers.gradient.account import Account
from ocp_traj.solvers.gradient.gradient import LOOSE, Gradient
from ocp_traj.solving import SolveResult, solve
from ocp_traj.task import CustomObjective, Objective, TrajectoryTask
from ocp_traj.transcription.guess import initial_guess


def hard_task() -> TrajectoryTask:
    limits = {"jerk": 50.0, "torque": [60.0, 60.0, 60.0, 12.0, 12.0, 12.0]}
    return arm_task(ARM_POINTS[[0, 1, 3]], limits=limits, virtual_knots=3, objective=Objective(energy=1.0))


def converged() -> SolveResult:
    return solve(plain_task())


def out_of_budget() -> SolveResult:
    return solve(plain_task(virtual_knots=3), budget=5)


def out_of_time() -> SolveResult:
    return solve(hard_task(), time_limit=0.05)


def infeasible() -> SolveResult:
    return solve(plain_task(objective=Objective(duration=(0.0, 0.5))))


def failed() -> SolveResult:
    """A cost that is no number anywhere."""
    q, v, a, tau = (ca.SX.sym(name, 2) for name in ("q", "v", "a", "tau"))
    nothing = ca.Function("nothing", [q, v, a, tau], [ca.sqrt(-1 - ca.sumsqr(v))])
    return solve(plain_task(objective=Objective(custom=(CustomObjective("nothing", nothing),))))


REACHED = {
    Status.CONVERGED: converged,
    Status.BUDGET_EXHAUSTED: out_of_budget,
    Status.TIME_EXHAUSTED: out_of_time,
    Status.INFEASIBLE: infeasible,
    Status.FAILED: failed,
}
"""`stalled` has its tests beside the third-party solvers and the stopping rules."""


@pytest.mark.parametrize("status", REACHED, ids=lambda status: status.key)
def test_a_gradient_solver_ends_with_the_status_and_files_tell_it(status: Status) -> None:
    result = REACHED[status]()
    assert result.solution.status is status, result
    assert result.to_json()["status"] == status.key
    assert (status is Status.CONVERGED) <= result.feasible
    assert result.message


def test_a_failure_is_not_called_a_conflict() -> None:
    """The limits of this task can be kept, so no limit may be named."""
    assert failed().diagnosis == ""


def test_a_failing_task_falls_back_on_the_motion_with_fewer_knots() -> None:
    """Which it contains: the knots are inserted, the motion stays, and so does the failure's status."""
    task = plain_task(virtual_knots=3)
    solver, account = Gradient(), Account(Request(0, None, None, None, None))
    nlp = solver._build(task, initial_guess(task), account)
    failed = Gradient(iterations=2)._call(nlp, account, warm=False, before=None)
    assert failed.status is Status.BUDGET_EXHAUSTED
    contained = solver._with_fewer_knots(task, account, failed)
    assert contained is not None and contained.status is failed.status
    assert "1 virtual knots" in contained.message
    fewer = solve(task.changed(virtual_knots=1))
    assert contained.trajectory.duration == pytest.approx(fewer.duration, rel=1e-6)
    assert len(contained.trajectory.breakpoints) == 4 * task.gaps + 1
    assert contained.violation.max() < 1e-6


def weak_arm() -> TrajectoryTask:
    """Return a task whose torque limits need points between the first samples."""
    return load_case("ur5-torque-limited", ["spline.virtual_knots=0"])


def test_rounds_of_added_points_are_rough_at_first_and_the_last_one_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tolerances: list[float] = []
    call = Gradient._call

    def noted(solver: Gradient, *args: Any, **more: Any) -> Any:
        tolerances.append(solver.tolerance)
        return call(solver, *args, **more)

    monkeypatch.setattr(Gradient, "_call", noted)
    result = solve(weak_arm())
    assert result.feasible
    assert tolerances[:2] == [LOOSE, LOOSE]
    assert tolerances[-1] == Gradient().tolerance
    tolerances.clear()
    assert solve(plain_task()).feasible  # nothing to sample, nothing to do roughly
    assert set(tolerances) == {Gradient().tolerance}


def test_a_failure_after_a_rough_round_starts_again_without_those(monkeypatch: pytest.MonkeyPatch) -> None:
    tolerances: list[float] = []
    call = Gradient._call

    def second_fails(solver: Gradient, *args: Any, **more: Any) -> Any:
        tolerances.append(solver.tolerance)
        answer = call(solver, *args, **more)
        return replace(answer, status=Status.FAILED) if len(tolerances) == 2 else answer

    monkeypatch.setattr(Gradient, "_call", second_fails)
    result = solve(weak_arm())
    assert tolerances[:2] == [LOOSE, LOOSE] and set(tolerances[2:]) == {Gradient().tolerance}
    assert result.feasible and result.solution.status is Status.CONVERGED
    assert result.duration == pytest.approx(solve(weak_arm()).duration, rel=1e-5)
