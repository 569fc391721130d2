"""What a solver gives back: fields by name, sensible defaults, and histories of what is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from metaheuristics import History, Problem, Solution, Status
from metaheuristics.nondominated import find_front, front_numbers
from metaheuristics.recorder import Recorder

PROBLEM = Problem.from_function(lambda X: X.sum(axis=1), [0.0, 0.0], [1.0, 1.0])


def make(**changes):
    return Solution(**{"problem": PROBLEM, "x": np.zeros(2), "cost": 1.0, "status": Status.CONVERGED, **changes})


def test_fields_are_given_by_name_only():
    with pytest.raises(TypeError):
        Solution(PROBLEM, np.zeros(2), 1.0, Status.CONVERGED)
    with pytest.raises(TypeError):
        History([1], [1.0], [0.0], [0.0], [[0.0]], [0.0])


def test_what_is_not_given_is_nothing():
    found = make()
    assert (found.message, found.evaluations, found.build_time, found.solve_time) == ("", 0, 0.0, 0.0)
    assert found.feasible and found.total_violation == 0.0
    assert len(found.history) == 0 and found.history.x.shape == (0, 2)


def test_a_solver_without_an_answer_has_no_candidate_and_is_not_feasible():
    failed = Solution.failed(PROBLEM, "broke down", evaluations=3)
    assert failed.status is Status.FAILED and failed.evaluations == 3
    assert math.isinf(failed.cost) and math.isinf(failed.total_violation) and not failed.feasible
    assert failed.x.shape == (2,) and np.isnan(failed.x).all()
    assert Solution.failed(PROBLEM, "none", status=Status.INFEASIBLE).status is Status.INFEASIBLE


def test_an_answer_pays_for_all_searches():
    first = make(evaluations=3, build_time=0.5, solve_time=1.0)
    second = make(evaluations=4, build_time=0.25, solve_time=2.0, cost=0.5)
    paid = second.paying_for([first, second], message="both")
    assert (paid.evaluations, paid.build_time, paid.solve_time, paid.seconds) == (7, 0.75, 3.0, 3.75)
    assert (paid.cost, paid.message) == (0.5, "both")


def test_a_history_knows_what_it_is_given():
    history = History.of([2.0, 1.0], evaluations=[5, 10], dimension=3)
    assert history.evaluations.tolist() == [5, 10] and history.violation.tolist() == [0.0, 0.0]
    assert history.x.shape == (2, 3) and np.isnan(history.x).all()
    assert np.isnan(history.seconds).all() and np.isnan(history.spread).all()
    known = History.of([2.0], evaluations=[5], dimension=1, violation=[0.5], seconds=[0.1], x=[[4.0]], spread=[0.2])
    assert (known.violation[0], known.seconds[0], known.x[0, 0], known.spread[0]) == (0.5, 0.1, 4.0, 0.2)


@pytest.mark.parametrize(
    ("cost", "violation", "status", "words"),
    [
        (1.0, 0.0, Status.STALLED, "done"),
        (1.0, 0.25, Status.INFEASIBLE, "The least total violation found is 0.25. done"),
        (math.inf, math.inf, Status.FAILED, "No candidate had finite values. done"),
    ],
)
def test_the_best_candidate_decides_the_status(cost, violation, status, words):
    recorder = Recorder(np.zeros(2), cost, violation, rows=np.array([violation]), evaluations=9)
    found = recorder.make_solution(PROBLEM, Status.STALLED, "done", solve_time=2.0)
    assert (found.status, found.message, found.evaluations) == (status, words, 9)
    assert (found.build_time, found.solve_time, len(found.history)) == (0.0, 2.0, 0)


def test_the_front_holds_what_nothing_else_matches_or_beats_in_order():
    rng = np.random.default_rng(4)
    first, second = rng.integers(0, 12, (2, 200)).astype(float)
    front = find_front(first, second)
    assert (np.diff(first[front]) > 0).all() and (np.diff(second[front]) < 0).all()
    assert (front_numbers(first, second)[front] == 0).all()
    unique = {(first[row], second[row]) for row in np.flatnonzero(front_numbers(first, second) == 0)}
    assert unique == {(first[row], second[row]) for row in front}
    for row in front:
        assert row == np.flatnonzero((first == first[row]) & (second == second[row]))[0]
    assert find_front(np.empty(0), np.empty(0)).size == 0
