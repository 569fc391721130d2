import numpy as np
import pytest

from metaheuristics import Evaluation, Problem, Status
from metaheuristics.arrays import freeze


class Doubled(Problem):
    def evaluate(self, X):
        return Evaluation(2.0 * X.sum(axis=1))


def test_a_problem_keeps_read_only_copies_of_its_bounds():
    lower = np.zeros(3)
    problem = Doubled("doubled", lower, [1.0, 2.0, 3.0])
    lower[0] = 5.0
    assert problem.lower[0] == 0.0
    assert problem.dimension == 3
    assert problem.name == "doubled"
    with pytest.raises(ValueError, match="read-only"):
        problem.upper[0] = 9.0


def test_a_subclass_evaluates_batches():
    problem = Doubled("doubled", [0.0, 0.0], [1.0, 1.0])
    assert problem.evaluate(np.array([[1.0, 0.5], [0.0, 0.25]])).cost.tolist() == [3.0, 0.5]


@pytest.mark.parametrize(
    ("lower", "upper", "words"),
    [
        ([0.0], [1.0, 2.0], r"shapes \(1,\) and \(2,\)"),
        ([[0.0]], [[1.0]], r"expected two vectors"),
        ([], [], "same length"),
        ([0.0, 3.0], [1.0, 2.0], r"Variable 2 .* \[3.0, 2.0\], expected lower <= upper"),
        ([0.0, np.nan], [1.0, 2.0], "Variable 2"),
    ],
)
def test_impossible_bounds_are_refused(lower, upper, words):
    with pytest.raises(ValueError, match=words):
        Doubled("doubled", lower, upper)


def test_a_function_of_costs_or_of_evaluations_makes_a_problem():
    costs = Problem.from_function(lambda X: X[:, 0], [0.0], [1.0])
    rows = Problem.from_function(lambda X: Evaluation(X[:, 0], X), [0.0], [1.0], name="rows")
    X = np.array([[0.5], [0.25]])
    assert costs.evaluate(X).cost.tolist() == [0.5, 0.25]
    assert costs.evaluate(X).violation.shape == (2, 0)
    assert rows.evaluate(X).total_violation.tolist() == [0.5, 0.25]
    assert rows.name == "rows"


def test_a_function_with_the_wrong_number_of_costs_is_refused():
    problem = Problem.from_function(lambda X: np.zeros(3), [0.0], [1.0])
    with pytest.raises(ValueError, match="answered 3 costs for 2 candidates"):
        problem.evaluate(np.zeros((2, 1)))


@pytest.mark.parametrize(
    ("cost", "violation", "words"),
    [
        (1.0, None, r"shape \(\)"),
        ([[1.0]], None, r"shape \(1, 1\)"),
        ([1.0, 2.0], [0.0, 1.0], r"expected \(2, m\)"),
        ([1.0, 2.0], [[0.0]], r"expected \(2, m\)"),
        ([1.0], [[-0.5]], "smallest violation is -0.5"),
    ],
)
def test_evaluations_of_the_wrong_shape_or_sign_are_refused(cost, violation, words):
    with pytest.raises(ValueError, match=words):
        Evaluation(cost, violation)


def test_violations_add_up_over_the_rows():
    evaluation = Evaluation([1.0, 2.0], [[0.5, 0.25], [0.0, 0.0]])
    assert evaluation.total_violation.tolist() == [0.75, 0.0]
    assert Evaluation([1.0, 2.0]).total_violation.tolist() == [0.0, 0.0]


@pytest.mark.parametrize("broken", [np.nan, np.inf, -np.inf])
def test_broken_candidates_become_the_worst_in_cost_and_violation(broken):
    cost, violation = Evaluation([1.0, broken, 3.0], [[0.0], [0.0], [np.nan]]).scores
    assert cost.tolist() == [1.0, np.inf, np.inf]
    assert violation.tolist() == [0.0, np.inf, np.inf]
    assert Evaluation([1.0, broken]).scores[0].tolist() == [1.0, np.inf]


def test_costs_too_large_to_square_are_still_costs():
    assert Evaluation([1e300, 2.0]).scores[0].tolist() == [1e300, 2.0]


def test_every_status_has_a_sentence_and_the_word_of_the_contract():
    keys = {status.key for status in Status}
    assert keys == {
        "converged",
        "budget_exhausted",
        "time_exhausted",
        "stalled",
        "infeasible",
        "failed",
    }
    assert all(status.value.endswith(".") for status in Status)


def test_freezing_copies():
    given = np.arange(3.0)
    frozen = freeze(given)
    given[0] = 7.0
    assert frozen[0] == 0.0
    assert not frozen.flags.writeable
