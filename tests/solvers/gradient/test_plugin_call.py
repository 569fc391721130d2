"""One call of a plug-in: its answer, its rank among others, and multipliers carried to a problem with more rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from metaheuristics import Status
from ocp_traj.solvers import Request
from ocp_traj.solvers.gradient import plugin_call
from ocp_traj.solvers.gradient.account import Account
from ocp_traj.solvers.gradient.attempt import build_nlp
from ocp_traj.solvers.gradient.plugin_call import (
    ACCEPTABLE,
    call_plugin,
    carry_multipliers,
    condensed_from,
    first_point,
)
from ocp_traj.solvers.gradient.settings import GradientSettings
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.transcription import CondensedNlp, LiftedNlp, initial_guess
from ocp_traj.transcription.nlp import RowBlock

SETTINGS = GradientSettings(compiled=False)


def task(**changes: object) -> TrajectoryTask:
    limits = Limits(velocity=2.0, acceleration=4.0)
    return TrajectoryTask([[0.0, 0.0], [1.0, 0.5], [0.5, 1.0]], limits, **{"virtual_knots": 0, **changes})  # type: ignore[arg-type]


def block(limit: str, rows: int) -> RowBlock:
    index = np.zeros(rows, dtype=int)
    return RowBlock(limit, index, index, np.zeros(rows))


def test_families_without_virtual_knots_get_the_condensed_form() -> None:
    account = Account(Request())
    lifted = build_nlp(task(), initial_guess(task()), SETTINGS, account)
    assert isinstance(lifted, LiftedNlp) and account.build_time > 0.0
    other = TrajectoryTask(np.arange(4.0)[:, None], Limits(velocity=2.0, acceleration=4.0), family="3-5-3")
    assert isinstance(build_nlp(other, initial_guess(other), SETTINGS, account), CondensedNlp)


def test_the_condensed_form_starts_from_the_guess_in_a_wide_box() -> None:
    own = task()
    condensed = condensed_from(own, initial_guess(own), SETTINGS, 16)
    assert condensed.task is own and str(condensed.encoding) == "log-durations"
    durations = initial_guess(own).segment_durations
    np.testing.assert_allclose(condensed.decode(condensed.guess).segment_durations, durations)
    np.testing.assert_allclose(np.exp(condensed.upper), 1e3 * durations.max())
    np.testing.assert_allclose(np.exp(condensed.lower), 1e-3 * durations.min())


def test_a_call_converges_and_is_paid_for() -> None:
    account = Account(Request())
    answer = call_plugin(build_nlp(task(), initial_guess(task()), SETTINGS, account), SETTINGS, account, warm=False)
    assert answer.solved and answer.violation.max() < 1e-7
    assert account.evaluations > 1 and account.counts["nlp_f"] == account.evaluations
    assert answer.trajectory.duration == pytest.approx(answer.cost)


def test_a_warm_call_with_multipliers_takes_fewer_iterations() -> None:
    cold, warm = Account(Request()), Account(Request())
    nlp = build_nlp(task(virtual_knots=3), initial_guess(task(virtual_knots=3)), SETTINGS, cold)
    first = call_plugin(nlp, SETTINGS, cold, warm=False)
    again = call_plugin(nlp, SETTINGS, warm, warm=True, before=first)
    assert first.solved and again.solved and again.cost == pytest.approx(first.cost, rel=1e-6)
    assert warm.evaluations < cold.evaluations


def test_the_rank_prefers_what_is_solved_then_less_excess_then_less_cost() -> None:
    nlp = build_nlp(task(), initial_guess(task()), SETTINGS, Account(Request()))
    failed = replace(first_point(nlp, "stopped"), violation=np.array([0.2, 0.1]), cost=1.0)
    assert failed.status is Status.FAILED and failed.rank == (True, 0.2, 1.0)
    closer = replace(failed, violation=np.array([0.1, 0.1]), cost=9.0)
    solved = replace(failed, status=Status.CONVERGED, cost=5.0)
    assert sorted([failed, closer, solved], key=lambda answer: answer.rank) == [solved, closer, failed]


def test_an_acceptable_answer_counts_only_while_its_rows_hold(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plugin_call, "read_status", lambda plugin, stats: (Status.CONVERGED, ACCEPTABLE))
    nlp = build_nlp(task(), initial_guess(task()), SETTINGS, Account(Request()))
    early = replace(SETTINGS, iterations=2)
    assert call_plugin(nlp, early, Account(Request()), warm=False).status is Status.STALLED
    lenient = replace(early, tuning=replace(early.tuning, acceptable_violation=np.inf))
    assert call_plugin(nlp, lenient, Account(Request()), warm=False).status is Status.CONVERGED


def test_multipliers_go_to_the_blocks_of_the_same_limit_in_order() -> None:
    old = [block("velocity", 2), block("torque", 1), block("velocity", 1)]
    new = [block("velocity", 3), block("jerk", 1), block("velocity", 1), block("torque", 2)]
    carried = carry_multipliers(old, new, np.array([1.0, 2.0, 3.0, 4.0]))
    assert carried.tolist() == [1.0, 2.0, 0.0, 0.0, 4.0, 3.0, 0.0]
