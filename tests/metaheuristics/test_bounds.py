import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from metaheuristics.bounds import BOUND_RULES, clip, reflect, repair, resample

LOWER, UPPER = np.array([-1.0, 10.0, 2.0]), np.array([1.0, 12.0, 2.0])


def test_clip_puts_coordinates_on_the_bound_they_crossed():
    X = np.array([[-3.0, 13.0, 2.5], [0.5, 11.0, 2.0], [np.nan, np.inf, -np.inf]])
    assert clip(X, LOWER, UPPER).tolist() == [[-1.0, 12.0, 2.0], [0.5, 11.0, 2.0], [-1.0, 12.0, 2.0]]


def test_reflect_mirrors_as_often_as_needed():
    X = np.array([[-1.5, 12.5, 2.5], [3.5, 10.25, 2.0], [-4.25, np.inf, np.nan]])
    # -1.5 -> -0.5; 12.5 -> 11.5; 3.5 -> -1.5 -> -0.5; -4.25 -> 2.25 -> -0.25.
    assert reflect(X, LOWER, UPPER).tolist() == [[-0.5, 11.5, 2.0], [-0.5, 10.25, 2.0], [-0.25, 12.0, 2.0]]


def test_reflecting_a_uniform_point_moved_to_either_side_leaves_it_uniform():
    rng = np.random.default_rng(1)
    moved = rng.random((4000, 1)) + rng.choice([-0.7, 0.7], (4000, 1))
    numbers = reflect(moved, np.zeros(1), np.ones(1))[:, 0]
    assert stats.kstest(numbers, "uniform").pvalue > 0.01


def test_resample_draws_only_what_left():
    X = np.array([[5.0, 11.0, 2.0], [0.25, np.nan, 7.0]])
    drawn = resample(X.copy(), LOWER, UPPER, np.random.default_rng(3))
    numbers = np.random.default_rng(3).random(3)
    assert drawn[0].tolist() == [-1.0 + 2.0 * numbers[0], 11.0, 2.0]
    assert drawn[1].tolist() == [0.25, 10.0 + 2.0 * numbers[1], 2.0]


@given(
    st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=3, max_size=3),
    st.sampled_from(BOUND_RULES),
)
def test_every_rule_ends_inside_and_leaves_the_inside_alone(row, rule):
    X = np.array([row, [0.5, 11.0, 2.0]])
    inside = repair(rule, X.copy(), LOWER, UPPER, np.random.default_rng(0))
    assert (inside >= LOWER).all()
    assert (inside <= UPPER).all()
    kept = (X >= LOWER) & (X <= UPPER)
    assert (inside[kept] == X[kept]).all()


def test_an_unknown_rule_is_refused():
    with pytest.raises(ValueError, match="'wrap', expected one of clip, reflect, resample"):
        repair("wrap", np.zeros((1, 3)), LOWER, UPPER, np.random.default_rng(0))


@pytest.mark.parametrize("rule", BOUND_RULES)
def test_bounds_given_once_or_once_a_row_lead_to_the_same_places(rule):
    X = np.random.default_rng(5).normal(0.0, 3.0, (7, 3)) + np.array([0.0, 11.0, 2.0])
    X[3] = [np.nan, np.inf, -np.inf]
    once = repair(rule, X.copy(), LOWER, UPPER, np.random.default_rng(0))
    rows = repair(rule, X.copy(), np.tile(LOWER, (7, 1)), np.tile(UPPER, (7, 1)), np.random.default_rng(0))
    assert once.tolist() == rows.tolist()
