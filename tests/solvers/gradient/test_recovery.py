"""After a failed start: a motion with fewer knots, an elastic phase, other starts, or the reason why none can help."""

from __future__ import annotations

from dataclasses import replace

import pytest

from metaheuristics import Status
from ocp_traj.exceptions import InputError, UnknownNameError
from ocp_traj.solvers import Request, parse_solver
from ocp_traj.solvers.gradient.account import Account
from ocp_traj.solvers.gradient.attempt import attempt
from ocp_traj.solvers.gradient.gradient import Gradient
from ocp_traj.solvers.gradient.plugin_call import Answer
from ocp_traj.solvers.gradient.recovery import recover, relax, try_elsewhere, with_fewer_knots
from ocp_traj.solvers.gradient.settings import GradientSettings, Tuning
from ocp_traj.task import Limits, Objective, TrajectoryTask

SETTINGS = GradientSettings(compiled=False)
POINTS = [[0.0, 0.0], [1.0, 0.5], [0.5, 1.0]]


def task(**changes: object) -> TrajectoryTask:
    return TrajectoryTask(POINTS, Limits(velocity=2.0, acceleration=4.0), **{"virtual_knots": 0, **changes})  # type: ignore[arg-type]


def failed_start(of: TrajectoryTask) -> tuple[Answer, Account]:
    account = Account(Request())
    return attempt(of, None, replace(SETTINGS, iterations=1), account, continued=False), account


def test_a_task_without_knots_has_no_motion_with_fewer() -> None:
    failed, account = failed_start(task())
    assert not failed.solved
    assert with_fewer_knots(task(), failed, SETTINGS, account) is None


def test_a_start_that_was_cut_off_is_recovered() -> None:
    failed, account = failed_start(task())
    answer, diagnosis = recover(task(), failed, SETTINGS, account)
    assert answer.solved and diagnosis == ""
    assert answer.trajectory.duration == pytest.approx(
        attempt(task(), None, SETTINGS, Account(Request()), continued=True).trajectory.duration, rel=1e-6
    )


def test_the_elastic_phase_gives_a_start_where_the_limits_can_be_kept() -> None:
    failed, account = failed_start(task())
    answer, sentence = relax(task(), failed, SETTINGS, account)
    assert answer.solved and sentence == ""
    none = replace(SETTINGS, tuning=Tuning(elastic_phases=0))
    assert relax(task(), failed, none, account) == (failed, "")


def test_a_duration_that_is_too_short_is_explained_before_anything_is_relaxed() -> None:
    for high, status, words in (
        (1.3, Status.INFEASIBLE, "no motion within the velocity and acceleration limits takes less than 1.70"),
        (1.9, Status.STALLED, "the shortest motion found takes 2.09"),  # a knot-free cubic needs more than the bound
    ):
        short = task(objective=Objective(duration=(0.0, high)))
        failed, account = failed_start(short)
        answer, diagnosis = recover(short, failed, SETTINGS, account)
        assert answer.status is status
        assert f"duration: at most {high:g} s are allowed" in diagnosis and words in diagnosis


def test_nothing_is_tried_when_the_budget_is_used_up() -> None:
    failed, _ = failed_start(task())
    account = Account(Request(budget=1))
    answer, diagnosis = recover(task(), failed, SETTINGS, account)
    assert answer.status is Status.BUDGET_EXHAUSTED and diagnosis == ""
    assert account.evaluations == 0


def test_numbers_of_the_recipe_are_settings_by_name() -> None:
    solver = parse_solver("ipopt[rough_rounds=1,rounds=2,conflict_excess=0.01]")
    assert isinstance(solver, Gradient)
    assert solver.tuning == Tuning(rough_rounds=1, conflict_excess=0.01) and solver.rounds == 2
    with pytest.raises(InputError, match="'rough_rounds' of a gradient solver is 'x', expected a whole number"):
        parse_solver("ipopt[rough_rounds=x]")
    with pytest.raises(UnknownNameError, match="has no setting 'starts'"):
        parse_solver("ipopt[starts=3]")
    with pytest.raises(UnknownNameError, match="has no setting 'tuning', expected one of plugin, tolerance"):
        parse_solver("ipopt[tuning=3]")


def test_other_starts_end_with_the_first_solution() -> None:
    failed, _ = failed_start(task())
    account, once = Account(Request()), Account(Request())
    first = try_elsewhere(task(), failed, 1, SETTINGS, once)
    answer = try_elsewhere(task(), failed, 4, SETTINGS, account)
    assert first.solved and answer.solved and account.evaluations == once.evaluations
    assert try_elsewhere(task(), answer, 4, SETTINGS, account) is answer
    assert try_elsewhere(task(), failed, 0, SETTINGS, account) is failed
