"""What a run of a gradient solver has cost: calls, evaluations, history, and what is left of the request."""

from __future__ import annotations

import numpy as np
import pytest

from metaheuristics import Status
from ocp_traj.solvers import Request
from ocp_traj.solvers.gradient.account import Account

STATS = {
    "n_call_nlp_f": 4,
    "n_call_nlp_g": 5,
    "n_call_nlp_hess_l": 3,
    "t_wall_total": 0.1,
    "iterations": {"obj": [3.0, 2.0, 1.0], "inf_pr": [0.5, 0.1, 0.0]},
}


def test_calls_add_up_and_an_evaluation_is_what_is_called_most() -> None:
    account = Account(Request())
    account.record(STATS, 0.5)
    account.record(STATS, 0.25)
    assert account.counts == {"nlp_f": 8, "nlp_g": 10, "nlp_hess_l": 6}
    assert (account.evaluations, account.solve_time) == (10, 0.75)


def test_a_call_without_statistics_costs_one_evaluation() -> None:
    account = Account(Request())
    account.record({}, 0.5)
    assert (account.evaluations, account.counts) == (1, {})


def test_the_totals_hold_the_course_over_all_calls() -> None:
    account = Account(Request())
    account.record(STATS, 0.5)
    account.record(STATS, 0.5)
    totals = account.totals(2)
    history = totals["history"]
    assert totals["evaluations"] == 10 and totals["solve_time"] == 1.0
    assert history.cost.tolist() == [3.0, 2.0, 1.0] * 2
    assert history.violation.tolist() == [0.5, 0.1, 0.0] * 2
    assert history.evaluations.tolist() == [0, 2, 5, 5, 7, 10]
    assert history.x.shape == (6, 2) and np.isnan(history.x).all() and np.isnan(history.spread).all()


def test_a_budget_leaves_one_evaluation_for_the_first_point() -> None:
    account = Account(Request(budget=12))
    assert account.evaluations_left(500) == 11 and account.evaluations_left(3) == 3
    account.record(STATS, 0.0)
    account.record(STATS, 0.0)
    assert account.evaluations_left(500) == 1 and account.exhausted() is None
    account.record({}, 0.0)
    assert account.evaluations_left(500) == 0 and account.exhausted() is Status.BUDGET_EXHAUSTED
    assert Account(Request()).evaluations_left(500) == 500


def test_the_time_counts_from_the_beginning_of_the_run() -> None:
    account = Account(Request(time_limit=100.0))
    assert account.exhausted() is None
    assert account.left.time_limit == pytest.approx(100.0, abs=50.0)
    account.begin -= 200.0
    assert account.exhausted() is Status.TIME_EXHAUSTED
