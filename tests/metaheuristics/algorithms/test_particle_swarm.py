import math

import numpy as np
import pytest

from metaheuristics import Evaluation, ParticleSwarm, minimize
from metaheuristics.test_problems.standard import Sphere


def make_swarm_state(optimizer, positions, velocities, bests, leader, *, generation=0, total=10):
    state = optimizer.start([-10.0, -10.0], [10.0, 10.0], np.random.default_rng(0), total_generations=total)
    n = len(positions)
    return state.evolve(
        phase=0,
        generation=generation,
        positions=np.array(positions),
        velocities=np.array(velocities),
        best_positions=np.array(bests),
        best_cost=np.arange(float(n)),
        best_violation=np.zeros(n),
        leader=leader,
    )


def test_one_step_by_hand(scripted):
    swarm = ParticleSwarm(population=2, weight=0.5, cognitive=2.0, social=1.0)
    state = make_swarm_state(
        swarm, [[1.0, 2.0], [3.0, 4.0]], [[1.0, -1.0], [0.0, 2.0]], [[0.0, 2.0], [3.0, 3.0]], 0
    )
    rng = scripted(random=[[[0.5, 0.25], [0.5, 0.5]], [[0.1, 0.2], [0.3, 0.4]]])
    X, moved = swarm.ask(state, rng)
    # V1 = 0.5 (1, -1) + 2 (0.5, 0.25) ((0, 2) - (1, 2)) + (0.1, 0.2) ((0, 2) - (1, 2)) = (-0.6, -0.5)
    # V2 = 0.5 (0, 2) + 2 (0.5, 0.5) ((3, 3) - (3, 4)) + (0.3, 0.4) ((0, 2) - (3, 4)) = (-0.9, -0.8)
    assert pytest.approx(np.array([[0.4, 1.5], [2.1, 3.2]])) == X
    assert moved.velocities == pytest.approx(np.array([[-0.6, -0.5], [-0.9, -0.8]]))
    assert rng.exhausted


def test_bests_and_leader_follow_improvements_only():
    swarm = ParticleSwarm(population=2)
    state = make_swarm_state(swarm, [[1.0, 2.0], [3.0, 4.0]], np.zeros((2, 2)), [[0.0, 2.0], [3.0, 3.0]], 0)
    told = swarm.tell(state, np.array([[5.0, 5.0], [6.0, 6.0]]), Evaluation([0.5, -1.0]))
    assert told.best_positions.tolist() == [[0.0, 2.0], [6.0, 6.0]]
    assert told.best_cost.tolist() == [0.0, -1.0]
    assert told.leader == 1
    assert told.generation == 1
    assert state.best_positions.tolist() == [[0.0, 2.0], [3.0, 3.0]]


@pytest.mark.parametrize(
    ("wall", "velocity"), [("zero", [0.0, 1.0]), ("reverse", [-4.0, 1.0]), ("keep", [4.0, 1.0])]
)
def test_the_wall_rule_changes_only_the_velocity_that_hit(scripted, wall, velocity):
    swarm = ParticleSwarm(population=2, weight=1.0, wall=wall)
    positions = [[8.0, 0.0], [0.0, 0.0]]
    state = make_swarm_state(swarm, positions, [[4.0, 1.0], [0.0, 0.0]], [[8.0, 0.0], [0.0, 0.0]], 1)
    X, asked = swarm.ask(state, scripted(random=[0.0, 0.0]))
    assert X[0].tolist() == [10.0, 1.0]
    told = swarm.tell(asked, X, Evaluation([1.0, 2.0]))
    assert told.velocities[0].tolist() == velocity


def test_velocities_are_limited_relative_to_the_box(scripted):
    swarm = ParticleSwarm(population=2, weight=1.0, velocity_limit=0.1)
    state = make_swarm_state(swarm, np.zeros((2, 2)), [[3.0, -5.0], [1.0, 0.0]], np.zeros((2, 2)), 0)
    _, moved = swarm.ask(state, scripted(random=[0.0, 0.0]))
    assert moved.velocities.tolist() == [[2.0, -2.0], [1.0, 0.0]]
    free = ParticleSwarm(population=2, weight=1.0, velocity_limit=math.inf)
    assert free.ask(state, scripted(random=[0.0, 0.0]))[1].velocities.tolist() == [[3.0, -5.0], [1.0, 0.0]]


def test_inertia_schedules_by_hand(scripted):
    none = scripted()
    assert ParticleSwarm().find_factors(3, 10, none) == (0.7298, 1.49618, 1.49618)
    linear = ParticleSwarm(inertia="linear", cognitive=2.0, social=2.0)
    assert linear.find_factors(5, 10, none) == (pytest.approx(0.65), 2.0, 2.0)
    assert linear.find_factors(99, 10, none)[0] == pytest.approx(0.4)


def test_the_trigonometric_schedule_of_paper_d_as_printed(scripted):
    swarm = ParticleSwarm.paper("D")
    # Eq. (10): (0.9 - 0.4) cos^2(100/200), no + w_min, no pi; Eqs. (11), (12) at t = 100, T = 200:
    # 2 cos^2(pi/6) = 1.5, 2 sin^2(pi/3) = 1.5.
    w, c1, c2 = swarm.find_factors(100, 200, scripted())
    assert w == pytest.approx(0.5 * math.cos(0.5) ** 2) == pytest.approx(0.3850756)
    assert (c1, c2) == (pytest.approx(1.5), pytest.approx(1.5))
    # t > 0.6 T: 0.2 + 0.1 rand; t = T: c1 = 2 cos^2(pi/3) = 0.5, c2 = 2 sin^2(2 pi/3) = 1.5.
    assert swarm.find_factors(200, 200, scripted(random=[0.5])) == (
        pytest.approx(0.25),
        pytest.approx(0.5),
        pytest.approx(1.5),
    )
    assert swarm.find_factors(120, 200, scripted())[0] == pytest.approx(0.5 * math.cos(0.6) ** 2)


def test_the_repaired_schedule_of_paper_d(scripted):
    swarm = ParticleSwarm(inertia="trigonometric-repaired")
    # (0.9 - 0.4) cos^2(pi/2) + 0.4 = 0.4 at t = T/2; 0.5 cos^2(pi/4) + 0.4 = 0.65 at T/4.
    assert swarm.find_factors(100, 200, scripted())[0] == pytest.approx(0.4)
    assert swarm.find_factors(50, 200, scripted())[0] == pytest.approx(0.65)


def test_paper_presets_hold_what_the_papers_print():
    assert ParticleSwarm.paper("B").population == 30
    assert ParticleSwarm.paper("B").inertia == "linear"
    assert (ParticleSwarm.paper("B").weight_max, ParticleSwarm.paper("B").weight_min) == (0.9, 0.4)
    assert ParticleSwarm.paper("D").inertia == "trigonometric"
    assert (ParticleSwarm.paper("D").weight_max, ParticleSwarm.paper("D").weight_min) == (0.9, 0.4)
    assert ParticleSwarm.paper("A").population == 100
    assert ParticleSwarm.paper("D-plain").weight == 0.7


def test_the_swarm_finds_a_shifted_sphere_to_ten_digits():
    problem = Sphere(5, half_width=100.0, shift=[10.0, -30.0, 55.0, 0.1, -79.0])
    best = minimize(problem, ParticleSwarm(population=40), budget=20_000, rng=np.random.default_rng(1))
    assert best.x == pytest.approx(problem.optimum, abs=1e-8)
