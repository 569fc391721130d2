import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from metaheuristics import AdaptivePenalty, EpsilonLevel, FeasibleFirst, NonDominated, StaticPenalty
from metaheuristics.nondominated import crowding_distance, front_numbers
from metaheuristics.ordering import ORDERINGS, find_ordering

values = st.sampled_from([0.0, 0.5, 1.0, 2.0, 3.0, np.inf])
points = st.lists(st.tuples(values, values), min_size=1, max_size=12)
rules = [*ORDERINGS.values(), NonDominated(best="lowest-cost"), FeasibleFirst(0.7), StaticPenalty(2.0)]


def split(pairs):
    cost, violation = np.array(pairs, dtype=float).T
    broken = np.isinf(cost) | np.isinf(violation)
    return np.where(broken, np.inf, cost), np.where(broken, np.inf, violation)


def is_better(rule, one, other):
    return bool(rule.is_better(*(np.array([value]) for value in (*one, *other)))[0])


def test_feasible_first_prefers_less_violation_then_less_cost():
    rule = FeasibleFirst()
    assert is_better(rule, (9.0, 0.0), (1.0, 0.1))
    assert is_better(rule, (1.0, 0.1), (1.0, 0.2))
    assert is_better(rule, (1.0, 0.1), (2.0, 0.1))
    assert not is_better(rule, (1.0, 0.0), (1.0, 0.0))
    assert rule.sort(np.array([3.0, 1.0, 2.0, 0.0]), np.array([0.0, 0.0, 0.0, 5.0])).tolist() == [1, 2, 0, 3]


def test_a_tolerance_forgives_small_violations():
    rule = FeasibleFirst(tolerance=0.2)
    assert is_better(rule, (1.0, 0.2), (2.0, 0.0))
    assert is_better(rule, (2.0, 0.0), (1.0, 0.21))


def test_epsilon_starts_at_the_quantile_and_falls_to_zero_by_the_control_time():
    violation = np.array([0.0, 1.0, 2.0, 3.0, 4.0, np.inf])
    rule = EpsilonLevel(quantile=0.5, control=0.5, exponent=2.0).adapt(violation, violation, 0.0)
    assert rule.tolerance == 2.0  # the middle one of the five finite violations
    assert rule.adapt(violation, violation, 0.25).tolerance == pytest.approx(2.0 * 0.5**2)
    assert rule.adapt(violation, violation, 0.5).tolerance == 0.0
    assert EpsilonLevel().adapt(np.ones(1), np.array([np.inf]), 0.0).tolerance == 0.0


def test_a_static_penalty_adds_the_weighted_violation():
    rule = StaticPenalty(weight=10.0)
    assert is_better(rule, (1.0, 0.1), (2.5, 0.0))  # 2.0 < 2.5
    assert not is_better(rule, (1.0, 0.2), (2.5, 0.0))  # 3.0 > 2.5
    assert rule.find_best(np.array([1.0, 2.5]), np.array([0.1, 0.0])) == 0


def test_an_adaptive_penalty_grows_after_infeasible_and_falls_after_feasible_bests():
    rule = AdaptivePenalty(weight=8.0, increase=2.0, decrease=1.5, patience=2)
    infeasible, feasible = (np.zeros(1), np.ones(1)), (np.zeros(1), np.zeros(1))
    once = rule.adapt(*infeasible, 0.0)
    assert (once.weight, once.streak) == (8.0, -1)
    twice = once.adapt(*infeasible, 0.0)
    assert (twice.weight, twice.streak) == (16.0, 0)
    assert twice.adapt(*feasible, 0.0).adapt(*infeasible, 0.0).streak == -1
    assert twice.adapt(*feasible, 0.0).adapt(*feasible, 0.0).weight == pytest.approx(16.0 / 1.5)


def test_nondominated_sorting_ranks_fronts_and_the_reading_chooses_the_leader():
    cost = np.array([1.0, 2.0, 3.0, 2.5, 4.0])
    violation = np.array([3.0, 1.0, 0.0, 2.0, 4.0])
    # Front 0: (1, 3), (2, 1), (3, 0); front 1: (2.5, 2); front 2: (4, 4).
    assert front_numbers(cost, violation).tolist() == [0, 0, 0, 1, 2]
    assert NonDominated().sort(cost, violation).tolist() == [2, 0, 1, 3, 4]
    assert NonDominated(best="lowest-cost").sort(cost, violation).tolist() == [0, 2, 1, 3, 4]
    assert NonDominated().find_best(cost, violation) == 2
    assert NonDominated(best="lowest-cost").find_best(cost, violation) == 0


def test_between_two_nondominated_candidates_the_reading_decides():
    assert is_better(NonDominated(), (3.0, 0.0), (1.0, 3.0))
    assert is_better(NonDominated(best="lowest-cost"), (1.0, 3.0), (3.0, 0.0))
    for best in ("feasible-first", "lowest-cost"):
        assert is_better(NonDominated(best=best), (1.0, 0.0), (1.0, 3.0))


def test_crowding_is_the_relative_gap_of_the_neighbours():
    cost, violation = np.array([0.0, 1.0, 4.0, 5.0]), np.array([8.0, 6.0, 2.0, 0.0])
    distance = crowding_distance(cost, violation, np.zeros(4, dtype=np.intp))
    assert distance[[0, 3]].tolist() == [np.inf, np.inf]
    assert distance[1] == pytest.approx(4.0 / 5.0 + 6.0 / 8.0)
    assert distance[2] == pytest.approx(4.0 / 5.0 + 6.0 / 8.0)


def count_fronts_slowly(cost, violation):
    left, fronts, number = set(range(len(cost))), np.empty(len(cost), dtype=int), 0
    while left:
        front = {
            i
            for i in left
            if not any(
                cost[j] <= cost[i]
                and violation[j] <= violation[i]
                and (cost[j] < cost[i] or violation[j] < violation[i])
                for j in left
            )
        }
        for i in front:
            fronts[i] = number
        left -= front
        number += 1
    return fronts


@given(points)
def test_fronts_agree_with_peeling_by_definition(pairs):
    cost, violation = split(pairs)
    assert front_numbers(cost, violation).tolist() == count_fronts_slowly(cost, violation).tolist()


@pytest.mark.parametrize("rule", rules, ids=repr)
@given(pairs=points)
def test_sort_best_and_pairwise_comparison_agree(rule, pairs):
    cost, violation = split(pairs)
    order = rule.sort(cost, violation)
    assert sorted(order.tolist()) == list(range(len(pairs)))
    best = rule.find_best(cost, violation)
    leader = order[0]
    for i in (best, leader):
        others = np.full(len(pairs), cost[i]), np.full(len(pairs), violation[i])
        assert not rule.is_better(cost, violation, *others).any()
    for i, j in zip(range(len(pairs)), reversed(range(len(pairs)))):
        pair = cost[i], violation[i], cost[j], violation[j]
        assert rule.beats(*map(float, pair)) == bool(rule.is_better(*(np.array([v]) for v in pair))[0])


def test_rules_are_found_by_name():
    assert find_ordering("epsilon") == EpsilonLevel()
    assert find_ordering(FeasibleFirst(0.5)) == FeasibleFirst(0.5)
    with pytest.raises(ValueError, match="'deb', expected one of feasible-first, epsilon"):
        find_ordering("deb")
    with pytest.raises(ValueError, match="'cheapest'"):
        NonDominated(best="cheapest")
