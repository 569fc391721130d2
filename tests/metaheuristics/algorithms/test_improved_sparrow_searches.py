import math

import numpy as np
import pytest

from metaheuristics import (
    EliteSparrowSearch,
    Evaluation,
    LevySparrowSearch,
    NonDominated,
    SparrowSearch,
    TentSparrowSearch,
    minimize,
)
from metaheuristics.algorithms.elite_sparrow_search import MUTATION, OPPOSITION, find_mutation_scale
from metaheuristics.algorithms.levy_sparrow_search import draw_levy, find_levy_scale
from metaheuristics.algorithms.sparrow_search import PRODUCERS, SCOUTS
from metaheuristics.test_problems.standard import Sphere

POSITIONS = [[2.0, -4.0], [3.0, 0.0], [1.0, 1.0], [0.0, 5.0], [4.0, 4.0]]


def make_flock(optimizer, cost, *, phase=PRODUCERS, generation=0, total=10, rows=(0, 1, 2, 3, 4)):
    state = optimizer.start([-8.0] * 2, [8.0] * 2, np.random.default_rng(0), total_generations=total)
    cost = np.array(cost, dtype=float)
    best = int(cost.argmin())
    return state.evolve(
        phase=phase,
        generation=generation,
        positions=np.array(POSITIONS),
        cost=cost,
        violation=np.zeros(5),
        leader=np.array(POSITIONS[best]),
        leader_cost=float(cost[best]),
        leader_violation=0.0,
        rows=np.array(rows),
    )


COST = [5.0, 4.0, 2.0, 3.0, 6.0]


# Paper C


def test_tent_start_fills_the_box_or_lies_between_a_sparrows_own_extremes():
    lower, upper, rng = [0.0, 10.0], [1.0, 14.0], np.random.default_rng(0)
    box = TentSparrowSearch(population=200).start(lower, upper, rng, total_generations=5).positions
    assert box.min(axis=0) == pytest.approx(lower, abs=0.05)
    assert box.max(axis=0) == pytest.approx(upper, abs=0.2)
    optimizer = TentSparrowSearch(population=200, tent_range="own-extremes")
    own = optimizer.start([-1.0] * 3, [1.0] * 3, np.random.default_rng(1), total_generations=5).positions
    rng = np.random.default_rng(1)
    rng.random(200), rng.random((3, 200))
    uniform = -1.0 + 2.0 * rng.random((200, 3))
    assert (own >= uniform.min(axis=1, keepdims=True)).all()
    assert (own <= uniform.max(axis=1, keepdims=True)).all()
    plain = TentSparrowSearch(population=5, tent=False)
    assert (
        plain.start([0.0], [1.0], np.random.default_rng(2)).positions[:, 0]
        == np.random.default_rng(2).random((5, 1))[:, 0]
    ).all()


def test_adaptive_factors_by_hand():
    optimizer = TentSparrowSearch()
    assert optimizer.find_beta(0.0) == pytest.approx(1.0)
    assert optimizer.find_beta(0.5) == pytest.approx(0.6)  # 0.2 + 0.8 (1 + 0) / 2
    assert optimizer.find_beta(1.0) == pytest.approx(0.2)
    assert optimizer.find_scout_factor(0.0) == 0.0
    assert optimizer.find_scout_factor(0.5) == pytest.approx(math.sin(math.pi / 4))
    assert optimizer.find_scout_factor(math.sqrt(0.5)) == pytest.approx(1.0)
    assert optimizer.find_scout_factor(1.0) == pytest.approx(0.0, abs=1e-12)


def test_adaptive_scouts_replace_or_scale_the_random_factors(scripted):
    # t = 5 of 10: beta = 0.6, K = sin(pi / 4). Row 1 is not the best: X_best + beta |(2, -1)|.
    replace = TentSparrowSearch(population=5)
    flock = make_flock(replace, COST, phase=SCOUTS, generation=4, rows=[1, 2])
    moved = replace.move_scouts(flock, scripted())
    k = math.sin(math.pi / 4)
    assert moved[0] == pytest.approx([1.0 + 0.6 * 2.0, 1.0 + 0.6 * 1.0])
    assert moved[1] == pytest.approx([1.0 - k * 3.0 / 4.0] * 2)  # (1, 1) + K (3, 3) / (2 - 6)
    scale = TentSparrowSearch(population=5, factors="scale")
    moved = scale.move_scouts(flock, scripted(standard_normal=[-0.5], random=[0.75]))
    assert moved[0] == pytest.approx([1.0 - 0.3 * 2.0, 1.0 - 0.3 * 1.0])
    assert moved[1] == pytest.approx([1.0 - 0.5 * k * 3.0 / 4.0] * 2)
    plain = TentSparrowSearch(population=5, adaptive=False)
    moved = plain.move_scouts(flock, scripted(standard_normal=[-0.5], random=[0.75]))
    assert moved[0] == pytest.approx([0.0, 0.5])


def test_debiased_adaptive_factors_have_random_signs(scripted):
    optimizer = TentSparrowSearch(population=5, debiased=True)
    flock = make_flock(optimizer, COST, phase=SCOUTS, generation=4, rows=[1])
    moved = optimizer.move_scouts(flock, scripted(random=[[[0.9, 0.1]], [[0.9, 0.9]]]))
    assert moved[0] == pytest.approx([1.0 + 0.6 * 2.0, 1.0 - 0.6 * 1.0])


def test_paper_c_prints_these_settings():
    for variant, tent, adaptive in (
        ("T-SSA", True, False),
        ("ADF-SSA", False, True),
        ("TADF-SSA", True, True),
    ):
        search = TentSparrowSearch.paper(variant)
        assert (search.population, search.producers, search.scouts, search.safety) == (100, 0.2, 0.1, 0.5)
        assert (search.tent, search.adaptive) == (tent, adaptive)
    assert TentSparrowSearch.paper("SSA") == SparrowSearch(population=100, safety=0.5)
    with pytest.raises(ValueError, match="variant is 'X-SSA'"):
        TentSparrowSearch.paper("X-SSA")


# Paper B


def test_levy_steps_by_hand(scripted):
    # Mantegna: [Gamma(2.5) sin(0.75 pi) / (Gamma(1.25) 1.5 2^0.25)]^(2/3) = 0.696575.
    assert find_levy_scale() == pytest.approx(0.6965745, abs=1e-6)
    steps = draw_levy(1, 2, scripted(standard_normal=[[[1.0, -2.0]], [[8.0, -1.0]]]))
    assert steps[0] == pytest.approx([0.6965745 / 4.0, -2.0 * 0.6965745], abs=1e-6)


def test_the_nonlinear_weight_by_hand():
    search = LevySparrowSearch()
    assert [search.find_weight(share) for share in (0.0, 0.5, 1.0)] == pytest.approx([0.9, 0.775, 0.4])


def test_levy_producers_multiply_their_position_and_weigh_their_leap(scripted):
    search = LevySparrowSearch(population=5, producers=0.2)
    flock = make_flock(search, COST, generation=4)  # t / T = 0.5: w = 0.775
    rng = scripted(random=[0.3], standard_normal=[[[1.0, -2.0]], [[8.0, -1.0]]])
    step = np.array([find_levy_scale() / 4.0, -2.0 * find_levy_scale()])
    assert search.move_producers(flock, rng)[0] == pytest.approx(np.array([2.0, -4.0]) * (1.0 + step))
    rng = scripted(random=[0.8], standard_normal=[1.0])
    assert search.move_producers(flock, rng)[0] == pytest.approx([2.775, -3.225])


def test_debiased_levy_producers(scripted):
    search = LevySparrowSearch(population=5, producers=0.2, debiased=True)
    flock = make_flock(search, COST, generation=4)
    rng = scripted(random=[0.3, 0.7], standard_normal=[[[1.0, -2.0]], [[8.0, -1.0]]])  # other: (0, 5)
    step = np.array([find_levy_scale() / 4.0, -2.0 * find_levy_scale()])
    expected = np.array([2.0, -4.0]) + np.array([2.0, -9.0]) * step
    assert search.move_producers(flock, rng)[0] == pytest.approx(expected)
    rng = scripted(random=[0.8], standard_normal=[[[1.0, -2.0]]])
    expected = np.array([2.0, -4.0]) + 0.01 * 0.775 * 16.0 * np.array([1.0, -2.0])
    assert search.move_producers(flock, rng)[0] == pytest.approx(expected)


def test_reverse_learning_scouts_by_hand(scripted):
    search = LevySparrowSearch(population=5)
    flock = make_flock(search, COST, phase=SCOUTS, generation=1, rows=[1])
    # t = 2, T = 10: b1 = 0.8^2 = 0.64; X_r = 8 + (0.5, 0.25) (-8 - (1, 1)) = (3.5, 5.75);
    # X = X_r + 0.64 ((1, 1) - X_r) = (1.9, 2.71).
    assert search.move_scouts(flock, scripted(random=[[[0.5, 0.25]]]))[0] == pytest.approx([1.9, 2.71])
    fair = LevySparrowSearch(population=5, debiased=True)
    # X_best + 0.36 (2 r - 1) 16 = (1, 1 - 2.88).
    assert fair.move_scouts(flock, scripted(random=[[[0.5, 0.25]]]))[0] == pytest.approx([1.0, -1.88])


def test_reverse_learning_keeps_the_better_of_old_and_new_even_where_replacement_is_always():
    search = LevySparrowSearch(population=5, replacement="always")
    flock = make_flock(search, COST, phase=SCOUTS, rows=[1])
    told = search.tell(flock, np.array([[7.0, 7.0]]), Evaluation([4.5]))
    assert told.positions.tolist() == POSITIONS
    assert told.generation == 1
    producers = make_flock(search, COST, phase=PRODUCERS)
    told = search.tell(producers, np.array([[7.0, 7.0]]), Evaluation([9.5]))
    assert told.positions[0].tolist() == [7.0, 7.0]


def test_paper_b_prints_these_settings():
    search = LevySparrowSearch.paper()
    assert (search.population, search.producers, search.scouts, search.safety) == (30, 0.2, 0.1, 0.8)


def test_the_logistic_sine_start_lies_in_the_box():
    for reading in ("plain", "squared"):
        search = LevySparrowSearch(population=101, map_reading=reading)
        start = search.start([5.0] * 3, [6.0] * 3, np.random.default_rng(0)).positions
        assert start.min() >= 5.0
        assert start.max() <= 6.0
        assert start.shape == (101, 3)


# Paper A


def test_elite_opposition_by_hand(scripted):
    search = EliteSparrowSearch(population=5)
    flock = make_flock(search, COST, phase=OPPOSITION)
    # Elites: the best three, rows 2, 3, 1: a = (0, 0), b = (3, 5); k = 0.5 for all:
    # opposite = (1.5, 2.5) - x; all inside the box +-8.
    opposite = search.oppose(flock, scripted(random=[0.5, 0.25]))
    assert opposite == pytest.approx(np.array([1.5, 2.5]) - np.array(POSITIONS))


@pytest.mark.parametrize(("redraw", "expected"), [("box", -4.0), ("elites", 0.75)])
def test_opposite_coordinates_outside_the_box_are_redrawn(scripted, redraw, expected):
    search = EliteSparrowSearch(population=5, redraw=redraw)
    flock = make_flock(search, COST, phase=OPPOSITION)
    flock = flock.evolve(positions=flock.positions + np.array([0.0, 0.0]))
    flock.positions[4, 0] = 8.0  # not an elite: 0.0 (0 + 3) - 8 is on the box, 0.0 * 3 - 8.5 would leave it
    flock.positions[4, 0] = 8.5
    opposite = search.oppose(flock, scripted(random=[0.0, 0.25]))
    assert opposite[4, 0] == pytest.approx(expected)  # -8 + 16 / 4, or 0 + 3 / 4
    assert opposite[4, 1] == pytest.approx(-4.0)


def test_debiased_opposition_mirrors_at_the_centre_of_the_elites(scripted):
    search = EliteSparrowSearch(population=5, debiased=True)
    flock = make_flock(search, COST, phase=OPPOSITION)
    assert search.oppose(flock, scripted(random=[0.25]))[2] == pytest.approx([3.0 - 1.0, 5.0 - 1.0])


def test_the_best_of_both_sets_start_the_search():
    search = EliteSparrowSearch(population=5)
    flock = make_flock(search, COST, phase=OPPOSITION)
    opposite = np.arange(10.0).reshape(5, 2) / 2.0
    told = search.tell(flock, opposite, Evaluation([1.0, 9.0, 9.0, 4.5, 9.0]))
    assert told.cost.tolist() == [1.0, 2.0, 3.0, 4.0, 4.5]
    assert told.positions[0].tolist() == [0.0, 0.5]
    assert (told.phase, told.generation, told.leader_cost) == (PRODUCERS, 0, 1.0)


def test_the_mutation_scale_by_hand():
    assert find_mutation_scale(1.0, 2.0) == 1.0
    assert find_mutation_scale(2.0, 1.0) == pytest.approx(math.exp(0.5))
    assert find_mutation_scale(-2.0, -3.0) == pytest.approx(math.exp(0.5))
    assert find_mutation_scale(2.0, 2.0) == 1.0
    assert find_mutation_scale(0.0, -1.0) == 1.0
    assert find_mutation_scale(np.inf, 1.0) == 1.0


def test_the_gauss_cauchy_mutation_by_hand(scripted):
    search = EliteSparrowSearch(population=5)
    flock = make_flock(search, COST, phase=MUTATION, generation=4)
    # t / T = 0.5: l1 = 0.75, l2 = 0.25; s = 1: (1, 1) [1 + 0.75 (2, -1) + 0.25 (0.4, 0.8)] = (2.6, 0.45).
    rng = scripted(random=[0.0], standard_cauchy=[[[2.0, -1.0]]], standard_normal=[[[0.4, 0.8]]])
    X, asked = search.propose(flock, rng)
    assert X[0] == pytest.approx([2.6, 0.45])
    assert asked.rows.tolist() == [2]
    one = EliteSparrowSearch(population=5, mutation="scalar")
    rng = scripted(random=[0.0], standard_cauchy=[2.0], standard_normal=[0.4])
    assert one.propose(flock, rng)[0][0] == pytest.approx([2.6, 2.6])
    fair = EliteSparrowSearch(population=5, debiased=True)
    rng = scripted(random=[0.0], standard_cauchy=[[[2.0, -1.0]]], standard_normal=[[[0.4, 0.8]]])
    spread = np.array(POSITIONS).std(axis=0)
    assert fair.propose(flock, rng)[0][0] == pytest.approx([1.0 + 1.6 * spread[0], 1.0 - 0.55 * spread[1]])


def test_the_mutant_is_kept_only_if_better():
    search = EliteSparrowSearch(population=5)
    flock = make_flock(search, COST, phase=MUTATION, rows=[2])
    kept = search.tell(flock, np.array([[7.0, 7.0]]), Evaluation([1.0]))
    assert kept.positions[2].tolist() == [7.0, 7.0]
    assert (kept.leader_cost, kept.phase, kept.generation) == (1.0, PRODUCERS, 1)
    dropped = search.tell(flock, np.array([[7.0, 7.0]]), Evaluation([2.5]))
    assert dropped.positions.tolist() == POSITIONS


@pytest.mark.parametrize(("previous", "phase"), [(2.0015, MUTATION), (2.5, PRODUCERS), (np.inf, PRODUCERS)])
def test_only_a_stagnant_best_is_mutated(previous, phase):
    search = EliteSparrowSearch(population=5)
    flock = make_flock(search, COST, phase=SCOUTS, rows=[4]).evolve(previous_cost=previous)
    told = search.tell(flock, np.array([[7.0, 7.0]]), Evaluation([99.0]))
    assert told.phase == phase
    assert told.generation == (0 if phase == MUTATION else 1)


def test_paper_a_sorts_without_dominance_by_default():
    search = EliteSparrowSearch.paper()
    assert search.population == 100
    assert search.default_ordering == NonDominated()
    assert search.initial_evaluations == 200
    best = minimize(
        Sphere(2, half_width=5.0),
        EliteSparrowSearch(population=10),
        generations=30,
        rng=np.random.default_rng(0),
    )
    steps = np.diff(best.history.evaluations)
    assert best.history.evaluations[0] == 20
    assert set(steps.tolist()) <= {11, 12}


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: TentSparrowSearch(tent_range="wide"), "tent_range is 'wide'"),
        (lambda: TentSparrowSearch(factors="add"), "factors is 'add'"),
        (lambda: LevySparrowSearch(map_reading="cubed"), "map_reading is 'cubed'"),
        (lambda: LevySparrowSearch(coupling=1.0), "coupling is 1.0"),
        (lambda: EliteSparrowSearch(redraw="sky"), "redraw is 'sky'"),
        (lambda: EliteSparrowSearch(mutation="none"), "mutation is 'none'"),
    ],
)
def test_impossible_readings_are_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()
