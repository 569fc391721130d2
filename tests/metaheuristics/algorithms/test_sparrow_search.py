"""Every move of sparrow search against numbers computed by hand, whole runs against straight-line code."""

import math

import numpy as np
import pytest

from metaheuristics import Evaluation, SparrowSearch, minimize
from metaheuristics.algorithms.sparrow_search import PRODUCERS, READINGS, SCOUTS, SCROUNGERS
from metaheuristics.bounds import clip
from metaheuristics.test_problems.standard import Rastrigin


def make_flock(optimizer, positions, cost=None, *, phase=PRODUCERS, total=10, half_width=100.0, rows=None):
    positions = np.array(positions, dtype=float)
    n, d = positions.shape
    edge = np.full(d, half_width)
    state = optimizer.start(-edge, edge, np.random.default_rng(0), total_generations=total)
    cost = np.arange(float(n)) if cost is None else np.array(cost, dtype=float)
    best = int(cost.argmin())
    return state.evolve(
        phase=phase,
        positions=positions,
        cost=cost,
        violation=np.zeros(n),
        leader=positions[best],
        leader_cost=float(cost[best]),
        leader_violation=0.0,
        rows=np.arange(n) if rows is None else np.array(rows),
    )


FIVE = [[2.0, -4.0], [3.0, 0.0], [1.0, 1.0], [0.0, 5.0], [4.0, 4.0]]


def test_safe_producers_shrink_towards_the_origin(scripted):
    optimizer = SparrowSearch(population=5, producers=0.4)
    # R2 = 0.3 < ST; alpha = 1 - 0.5 and 1 - 0.75: exp(-1 / (0.5 * 10)) and exp(-2 / (0.25 * 10)).
    moved = optimizer.move_producers(make_flock(optimizer, FIVE), scripted(random=[0.3, [[0.5], [0.75]]]))
    assert moved[0] == pytest.approx(np.array([2.0, -4.0]) * math.exp(-0.2))
    assert moved[1] == pytest.approx(np.array([3.0, 0.0]) * math.exp(-0.8))


def test_safe_producers_with_one_alpha_a_coordinate(scripted):
    optimizer = SparrowSearch(population=5, producers=0.2, alpha="coordinate")
    moved = optimizer.move_producers(make_flock(optimizer, FIVE), scripted(random=[0.3, [[0.5, 0.75]]]))
    assert moved[0] == pytest.approx([2.0 * math.exp(-0.2), -4.0 * math.exp(-0.4)])


def test_alarmed_producers_leap_along_the_diagonal_or_per_coordinate(scripted):
    scalar = SparrowSearch(population=5, producers=0.2)
    moved = scalar.move_producers(make_flock(scalar, FIVE), scripted(random=[0.8], standard_normal=[0.7]))
    assert moved[0] == pytest.approx([2.7, -3.3])
    free = SparrowSearch(population=5, producers=0.2, normal="coordinate")
    rng = scripted(random=[0.9], standard_normal=[[[0.7, -1.0]]])
    assert free.move_producers(make_flock(free, FIVE), rng)[0] == pytest.approx([2.7, -5.0])


def test_debiased_producers_move_relative_to_another_sparrow_or_the_box(scripted):
    optimizer = SparrowSearch(population=5, producers=0.2, debiased=True, leap=0.01)
    # Random sparrow: floor(5 * 0.7) = row 3, (0, 5); X - X_r = (2, -9); factor exp(-1 / (0.5 * 10)).
    rng = scripted(random=[0.3, 0.5, 0.7], standard_normal=[[[1.0, -0.5]]])
    moved = optimizer.move_producers(make_flock(optimizer, FIVE), rng)
    assert moved[0] == pytest.approx(np.array([2.0, -4.0]) + math.exp(-0.2) * np.array([2.0, 4.5]))
    rng = scripted(random=[0.9], standard_normal=[[[1.0, -0.5]]])
    assert optimizer.move_producers(make_flock(optimizer, FIVE), rng)[0] == pytest.approx([4.0, -5.0])


@pytest.mark.parametrize(
    ("flight", "expected"),
    [("literal", [1.5, 1.5]), ("coordinate", [2.0, 0.5]), ("coordinate-undivided", [3.0, 0.0])],
)
def test_flight_to_the_best_producer_in_three_readings(scripted, flight, expected):
    # |X - X_p| = (2, 1), A = (+1, -1): the literal product is (2 - 1) / 2 = 0.5 for both coordinates.
    optimizer = SparrowSearch(population=5, flight=flight)
    flown = optimizer.fly(np.array([[3.0, 0.0]]), np.array([1.0, 1.0]), scripted(random=[[[0.5, 0.25]]]))
    assert flown[0] == pytest.approx(expected)


def test_hungry_scroungers_end_near_the_origin(scripted):
    optimizer = SparrowSearch(population=5, producers=0.2)
    # Ranks 3 to 5 are hungry (i > 5/2); for the first Q exp((X_worst - X_i) / 9) = 0.5 exp(3/9) twice.
    left = optimizer.leave(
        make_flock(optimizer, FIVE), np.array(FIVE[2:3]), 2, scripted(standard_normal=[0.5])
    )
    assert left[0] == pytest.approx([0.5 * math.exp(3.0 / 9.0)] * 2)
    free = SparrowSearch(population=5, normal="coordinate")
    rng = scripted(standard_normal=[[[0.5, -2.0]]])
    assert free.leave(make_flock(free, FIVE), np.array(FIVE[1:2]), 2, rng)[0] == pytest.approx(
        [0.5 * math.exp(1.0 / 9.0), -2.0 * math.exp(4.0 / 9.0)]
    )


def test_debiased_hungry_scroungers_go_beside_another_sparrow(scripted):
    optimizer = SparrowSearch(population=5, debiased=True)
    rng = scripted(random=[0.7], standard_normal=[[[0.5, -2.0]]])  # row 3: (0, 5)
    left = optimizer.leave(make_flock(optimizer, FIVE), np.array(FIVE[1:2]), 2, rng)
    assert left[0] == pytest.approx([0.0 + 0.5 * 3.0, 5.0 - 2.0 * -5.0])


@pytest.mark.parametrize(("hungry", "flying"), [("population", 3), ("scroungers", 2)])
def test_who_is_hungry_depends_on_the_reading_of_n(scripted, hungry, flying):
    # n = 10, 2 producers: i > 10/2 leaves ranks 3, 4, 5 flying, i > 8/2 ranks 3 and 4.
    optimizer = SparrowSearch(population=10, producers=0.2, hungry=hungry)
    flock = make_flock(optimizer, np.ones((10, 2)))
    moved = optimizer.move_scroungers(flock, scripted(random=[0.9], standard_normal=[7.0]))
    assert (moved[:flying] == 1.0).all()
    assert (moved[flying:] == 7.0).all()


def test_scroungers_follow_the_best_of_the_moved_producers(scripted):
    optimizer = SparrowSearch(population=5, producers=0.4, flight="coordinate-undivided")
    flock = make_flock(optimizer, FIVE, [9.0, 8.0, 2.0, 3.0, 4.0])  # the producers' best is row 1, (3, 0)
    moved = optimizer.move_scroungers(flock, scripted(random=[0.9], standard_normal=[1.0]))
    assert moved.shape == (3, 2)
    near = SparrowSearch(population=8, producers=0.25, flight="coordinate-undivided")
    flock = make_flock(near, [*FIVE, [1.0, 2.0], [2.0, 2.0], [3.0, 3.0]], [9.0, 8.0, 2, 3, 4, 5, 6, 7])
    moved = near.move_scroungers(flock, scripted(random=[0.9], standard_normal=[1.0]))
    assert moved[0] == pytest.approx([3.0 + 2.0, 0.0 + 1.0])  # X_p + |(1, 1) - (3, 0)|


def test_the_default_is_the_authors_own_program():
    author = {
        "replacement": "greedy",
        "alpha": "scalar",
        "normal": "scalar",
        "beta": "coordinate",
        "flight": "literal",
    }
    assert {name: getattr(SparrowSearch(), name) for name in author} == author
    assert {name: readings[0] for name, readings in READINGS.items()} == {**author, "hungry": "population"}


def test_scouts_fly_around_the_best(scripted):
    scalar = SparrowSearch(population=5, beta="scalar")
    flock = make_flock(scalar, FIVE, [5.0, 4.0, 2.0, 3.0, 6.0], phase=SCOUTS, rows=[1])
    moved = scalar.move_scouts(flock, scripted(standard_normal=[-0.5], random=[0.75]))
    assert moved[0] == pytest.approx([1.0 - 0.5 * 2.0, 1.0 - 0.5 * 1.0])
    moved = SparrowSearch(population=5).move_scouts(flock, scripted(standard_normal=[[[-0.5, 2.0]]], random=[0.75]))
    assert moved[0] == pytest.approx([0.0, 3.0])


def test_a_scout_at_the_best_moves_by_its_distance_to_the_worst(scripted):
    flock_cost = [5.0, 4.0, 2.0, 3.0, 6.0]
    optimizer = SparrowSearch(population=5)
    flock = make_flock(optimizer, FIVE, flock_cost, phase=SCOUTS, rows=[2])
    moved = optimizer.move_scouts(flock, scripted(standard_normal=[9.0], random=[0.75]))
    # (1, 1) + 0.5 |(1, 1) - (4, 4)| / ((2 - 6) + eps) = (1, 1) - 1.5 / 4.
    assert moved[0] == pytest.approx([0.625, 0.625])
    free = SparrowSearch(population=5, debiased=True)
    moved = free.move_scouts(flock, scripted(standard_normal=[9.0], random=[[[0.75, 0.0]]]))
    assert moved[0] == pytest.approx([1.0 + 0.5 * 3.0, 1.0 - 3.0])


def test_a_scout_at_the_best_stays_where_the_worst_is_broken(scripted):
    optimizer = SparrowSearch(population=5)
    flock = make_flock(optimizer, FIVE, [5.0, 4.0, 2.0, 3.0, np.inf], phase=SCOUTS, rows=[2])
    moved = optimizer.move_scouts(flock, scripted(standard_normal=[9.0], random=[0.75]))
    assert moved[0].tolist() == [1.0, 1.0]


def test_greedy_keeps_the_old_position_and_always_does_not():
    for replacement, first in (("greedy", [2.0, -4.0]), ("always", [7.0, 7.0])):
        optimizer = SparrowSearch(population=5, producers=0.4, replacement=replacement)
        flock = make_flock(optimizer, FIVE, rows=[0, 1])
        X = np.array([[7.0, 7.0], [8.0, 8.0]])
        told = optimizer.tell(flock, X, Evaluation([3.0, -1.0]))
        assert told.positions[0].tolist() == first
        assert told.positions[1].tolist() == [8.0, 8.0]
        assert told.leader.tolist() == [8.0, 8.0]
        assert told.leader_cost == -1.0
        assert (told.phase, told.generation) == (SCROUNGERS, 0)
        assert flock.positions.tolist() == FIVE


def test_a_generation_has_three_phases_and_counts_the_scouts():
    optimizer = SparrowSearch(population=10)
    sizes = []
    rng = np.random.default_rng(0)
    state = optimizer.start([-1.0] * 2, [1.0] * 2, rng, total_generations=3)
    while state.generation < 1:
        X, state = optimizer.ask(state, rng)
        sizes.append(X.shape[0])
        state = optimizer.tell(state, X, Evaluation((X**2).sum(axis=1)))
    assert sizes == [10, 2, 8, 1]
    assert optimizer.evaluations_per_generation == 11
    assert SparrowSearch(population=10, scouts=0.0).evaluations_per_generation == 10


class StraightLineSparrowSearch:
    """The published rules once more, sparrow by sparrow, sharing nothing with the library but the draws."""

    def __init__(self, f, lower, upper, optimizer, total, rng):
        self.f, self.lower, self.upper, self.rng = f, lower, upper, rng
        self.options, self.total = optimizer, total
        n, d = optimizer.population, len(lower)
        self.x = [lower + (upper - lower) * row for row in rng.random((n, d))]
        self.cost = [f(x) for x in self.x]
        self.best = min(range(n), key=lambda i: self.cost[i])
        self.best_x, self.best_cost = self.x[self.best].copy(), self.cost[self.best]

    def settle(self, rows, moved):
        for i, x in zip(rows, moved):
            x = clip(np.array([x]), self.lower, self.upper)[0]
            cost = self.f(x)
            if cost < self.best_cost:
                self.best_x, self.best_cost = x.copy(), cost
            if self.options.replacement == "always" or cost < self.cost[i]:
                self.x[i], self.cost[i] = x, cost

    def draw(self, reading, p, d):
        return self.rng.standard_normal((p, 1 if reading == "scalar" else d))

    def run_generation(self):
        o, n, d = self.options, self.options.population, len(self.lower)
        order = np.argsort(self.cost, kind="stable")
        self.x, self.cost = [self.x[i] for i in order], [self.cost[i] for i in order]
        producers = round(o.producers * n)
        moved = []
        if self.rng.random() < o.safety:
            alpha = 1.0 - self.rng.random((producers, 1 if o.alpha == "scalar" else d))
            for i in range(producers):
                moved.append(self.x[i] * np.exp(-(i + 1) / (alpha[i] * self.total)))
        else:
            q = self.draw(o.normal, producers, d)
            moved = [self.x[i] + q[i] for i in range(producers)]
        self.settle(range(producers), moved)
        leading = min(range(producers), key=lambda i: self.cost[i])
        target, worst = self.x[leading].copy(), self.x[-1].copy()
        base = n if o.hungry == "population" else n - producers
        flying = [i for i in range(producers, n) if not i + 1 > base / 2]
        hungry = [i for i in range(producers, n) if i + 1 > base / 2]
        signs = np.where(self.rng.random((len(flying), d)) >= 0.5, 1.0, -1.0)
        moved = []
        for k, i in enumerate(flying):
            difference = np.abs(self.x[i] - target)
            pseudo_inverse = signs[k] / (signs[k] @ signs[k])
            if o.flight == "literal":
                moved.append(target + (difference @ pseudo_inverse) * np.ones(d))
            elif o.flight == "coordinate":
                moved.append(target + difference * pseudo_inverse)
            else:
                moved.append(target + difference * signs[k])
        q = self.draw(o.normal, len(hungry), d)
        for k, i in enumerate(hungry):
            moved.append(q[k] * np.exp((worst - self.x[i]) / (i + 1) ** 2))
        self.settle(flying + hungry, moved)
        rows = np.argsort(self.rng.random(n))[: round(o.scouts * n)]
        beta = self.draw(o.beta, len(rows), d)
        k_factor = self.rng.uniform(-1.0, 1.0, (len(rows), 1))
        last = np.argsort(self.cost, kind="stable")[-1]
        moved = []
        for k, i in enumerate(rows):
            if self.cost[i] > self.best_cost:
                moved.append(self.best_x + beta[k] * np.abs(self.x[i] - self.best_x))
            else:
                gap = self.cost[i] - self.cost[last] + o.smallest
                moved.append(self.x[i] + k_factor[k] * np.abs(self.x[i] - self.x[last]) / gap)
        self.settle(rows, moved)


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"replacement": "always"},
        {"alpha": "coordinate"},
        {"normal": "coordinate"},
        {"beta": "scalar"},
        {"flight": "coordinate"},
        {"flight": "coordinate-undivided"},
        {"hungry": "scroungers"},
        {"safety": 0.2, "producers": 0.3, "scouts": 0.3},
    ],
    ids=str,
)
def test_whole_runs_agree_with_straight_line_code(settings):
    problem = Rastrigin(3, half_width=5.12, shift=[1.0, -2.0, 0.5])
    optimizer = SparrowSearch(population=20, **settings)
    generations = 12
    best = minimize(problem, optimizer, generations=generations, rng=np.random.default_rng(4))

    def f(x):
        return float(problem.evaluate(x[None]).cost[0])

    peer = StraightLineSparrowSearch(
        f, problem.lower, problem.upper, optimizer, generations, np.random.default_rng(4)
    )
    costs = [peer.best_cost]
    for _ in range(generations):
        peer.run_generation()
        costs.append(peer.best_cost)
    assert best.history.cost == pytest.approx(costs, rel=1e-9)
    assert best.x == pytest.approx(peer.best_x, rel=1e-9)


def test_hungry_scroungers_in_a_wide_box_do_not_overflow(scripted):
    optimizer = SparrowSearch(population=5, producers=0.2)
    state = optimizer.start([-1e4] * 2, [1e4] * 2, np.random.default_rng(0))
    state = state.evolve(positions=np.array([[0.0, 0.0]] * 4 + [[9e3, -9e3]]))
    left = optimizer.leave(state, np.array([[-9e3, 9e3]]), 2, scripted(standard_normal=[0.5]))
    # (X_worst - X) / 3^2 = +-2000, cut at 700: 0.5 e^700 and 0.5 e^-2000.
    assert left[0] == pytest.approx([0.5 * np.exp(700.0), 0.0])


def test_a_broken_candidate_is_remembered_as_worst_where_everybody_settles():
    optimizer = SparrowSearch(population=5, producers=0.4, replacement="always")
    rng = np.random.default_rng(0)
    state = optimizer.start([-1.0] * 2, [1.0] * 2, rng)
    X, state = optimizer.ask(state, rng)
    state = optimizer.tell(state, X, Evaluation([5.0, 4.0, 3.0, 2.0, 1.0]))
    assert state.violation.tolist() == [0.0] * 5
    X, state = optimizer.ask(state, rng)
    state = optimizer.tell(state, X, Evaluation([np.nan, 6.0]))
    assert state.violation.tolist() == [np.inf, 0.0, 0.0, 0.0, 0.0]
    assert state.cost.tolist() == [np.inf, 6.0, 3.0, 4.0, 5.0]
