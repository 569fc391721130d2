"""What mutation testing found untested in the update rules; each test here kills a change that survived."""

import numpy as np
import pytest

from metaheuristics import (
    EliteSparrowSearch,
    Evaluation,
    LevySparrowSearch,
    ParticleSwarm,
    SparrowSearch,
    TentSparrowSearch,
)
from metaheuristics.algorithms.elite_sparrow_search import MUTATION, OPPOSITION


def flock(optimizer, positions, half_width=8.0):
    positions = np.array(positions, dtype=float)
    n, d = positions.shape
    edge = np.full(d, half_width)
    state = optimizer.start(-edge, edge, np.random.default_rng(0), total_generations=10)
    return state.evolve(
        positions=positions,
        cost=np.arange(float(n)),
        violation=np.zeros(n),
        leader=positions[0],
        leader_cost=0.0,
        leader_violation=0.0,
        rows=np.arange(n),
    )


def swarm_state(swarm):
    state = swarm.start([-10.0, -10.0], [10.0, 10.0], np.random.default_rng(0), total_generations=10)
    return state.evolve(
        phase=0,
        positions=np.array([[1.0, 2.0], [3.0, 4.0]]),
        velocities=np.array([[1.0, -1.0], [0.0, 2.0]]),
        best_positions=np.array([[0.0, 2.0], [3.0, 3.0]]),
        best_cost=np.arange(2.0),
        best_violation=np.zeros(2),
        leader=0,
    )


def test_the_social_pull_is_multiplied_by_its_factor(scripted):
    swarm = ParticleSwarm(population=2, weight=0.5, cognitive=2.0, social=3.0)
    rng = scripted(random=[[[0.5, 0.25], [0.5, 0.5]], [[0.1, 0.2], [0.3, 0.4]]])
    _, moved = swarm.ask(swarm_state(swarm), rng)
    # V2 = 0.5 (0, 2) + 2 (0.5, 0.5) ((3, 3) - (3, 4)) + 3 (0.3, 0.4) ((0, 2) - (3, 4)) = (-2.7, -2.4)
    assert moved.velocities == pytest.approx(np.array([[-0.8, -0.5], [-2.7, -2.4]]))


def test_the_first_generation_of_a_linear_inertia_is_number_one(scripted):
    swarm = ParticleSwarm(population=2, inertia="linear", velocity_limit=np.inf)
    _, moved = swarm.ask(swarm_state(swarm), scripted(random=[0.0, 0.0]))
    # w = 0.9 - 0.5 * 1 / 10
    assert moved.velocities == pytest.approx(0.85 * np.array([[1.0, -1.0], [0.0, 2.0]]))


@pytest.mark.parametrize(
    ("population", "share", "count"), [(10, 0.01, 1), (10, 0.2, 2), (4, 0.99, 3), (10, 0.99, 9)]
)
def test_there_is_one_producer_at_least_and_one_scrounger(population, share, count):
    assert SparrowSearch(population=population, producers=share).producer_count == count


def test_an_opposite_on_the_bound_itself_is_inside(scripted):
    search = EliteSparrowSearch(population=4, debiased=True)
    # Elites (0, 0) and (8, -8): a + b = (8, -8), so the opposite of (0, 0) is the corner of the box.
    state = flock(search, [[0.0, 0.0], [8.0, -8.0], [1.0, 1.0], [2.0, 2.0]]).evolve(phase=OPPOSITION)
    assert search.oppose(state, scripted(random=[0.25]))[0].tolist() == [8.0, -8.0]


def test_a_scalar_mutation_stretches_every_coordinate_by_the_same():
    search = EliteSparrowSearch(population=4, mutation="scalar")
    positions = [[1.0, 2.0, 4.0], [3.0, 1.0, 1.0], [1.0, 1.0, 2.0], [0.0, 5.0, 1.0]]
    state = flock(search, positions).evolve(phase=MUTATION, rows=np.array([0]))
    stretched = search.mutate(state, np.random.default_rng(3)) / positions[0]
    assert stretched.shape == (1, 3)
    assert stretched[0] == pytest.approx(np.full(3, stretched[0, 0]))


def test_a_generation_of_the_elite_search_may_need_one_evaluation_more():
    assert SparrowSearch(population=50, scouts=0.1).evaluations_per_generation == 55
    assert EliteSparrowSearch(population=50, scouts=0.1).evaluations_per_generation == 56
    assert EliteSparrowSearch(population=50).initial_evaluations == 100


@pytest.mark.parametrize(
    ("paper", "population", "inertia", "weight", "factor"),
    [
        ("A", 100, "linear", 0.7298, 2.0),
        ("B", 30, "linear", 0.7298, 2.0),
        ("D", 50, "trigonometric", 0.7298, 1.49618),
        ("D-plain", 50, "constant", 0.7, 2.0),
    ],
)
def test_the_swarms_of_the_papers_have_their_settings(paper, population, inertia, weight, factor):
    swarm = ParticleSwarm.paper(paper)
    assert (swarm.population, swarm.inertia, swarm.weight) == (population, inertia, weight)
    assert (swarm.cognitive, swarm.social) == (factor, factor)
    assert (swarm.weight_max, swarm.weight_min) == (0.9, 0.4)


def test_a_change_of_just_the_threshold_is_stagnation():
    search = EliteSparrowSearch(population=4, threshold=0.5)
    state = flock(search, [[1.0, 2.0], [3.0, 1.0], [1.0, 1.0], [0.0, 5.0]])
    assert search.is_stagnant(state.evolve(previous_cost=2.0, leader_cost=1.0))
    assert not search.is_stagnant(state.evolve(previous_cost=2.0, leader_cost=0.9))


@pytest.mark.parametrize(
    ("search", "population", "safety"),
    [
        (EliteSparrowSearch.paper(), 100, 0.8),
        (LevySparrowSearch.paper(), 30, 0.8),
        (TentSparrowSearch.paper("SSA"), 100, 0.5),
        (TentSparrowSearch.paper("TADF-SSA"), 100, 0.5),
    ],
)
def test_the_sparrow_searches_of_the_papers_have_their_settings(search, population, safety):
    assert (search.population, search.safety) == (population, safety)
    assert (search.producers, search.scouts) == (0.2, 0.1)


def test_a_swarm_has_finished_a_generation_after_every_answer():
    swarm = ParticleSwarm(population=2)
    state = swarm.start([-1.0], [1.0], np.random.default_rng(0), total_generations=5)
    X, asked = swarm.ask(state, np.random.default_rng(1))
    assert swarm.tell(asked, X, Evaluation([1.0, 2.0])).phase == 0


@pytest.mark.parametrize(("producers", "count"), [(0.2, 3), (0.4, 1), (0.5, 0), (0.6, 0)])
def test_no_scrounger_flies_where_the_producers_are_half_of_the_flock(producers, count):
    assert SparrowSearch(population=10, producers=producers).flying_count == count


@pytest.mark.parametrize("share", [0.0, 1.0, -0.1, 1.1])
def test_nobody_or_everybody_a_producer_is_refused(share):
    with pytest.raises(ValueError, match="producers' share between 0 and 1"):
        SparrowSearch(producers=share)


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_nobody_or_everybody_may_be_a_scout(share):
    assert SparrowSearch(population=10, scouts=share).scout_count == 10 * share
