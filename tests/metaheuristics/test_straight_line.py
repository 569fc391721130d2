"""Every update rule of the papers, step by step against straight-line code written from the equations.

The programs below know nothing of the package: scalars, loops, one line per equation. Both sides are fed the same
random numbers in the same order; every candidate of thirty generations has to agree to 1e-12.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from metaheuristics import (
    EliteSparrowSearch,
    Evaluation,
    LevySparrowSearch,
    Optimizer,
    ParticleSwarm,
    SparrowSearch,
    TentSparrowSearch,
)

D, N, GENERATIONS = 4, 20, 30
LOWER, UPPER = np.array([-3.0, -1.0, 0.5, -2.0]), np.array([2.0, 4.0, 3.0, 2.5])
CENTRE, WEIGHT = (0.7, 1.9, 1.1, -0.4), (1.0, 3.0, 0.5, 2.0)

Candidates = Iterator[list[list[float]]]


def cost_of(x: Any) -> float:
    """A shifted ellipsoid with ripples."""
    return sum(w * (v - c) ** 2 + 0.1 * math.sin(5.0 * v) for v, c, w in zip(x, CENTRE, WEIGHT)) + 5.0


def violation_of(x: Any) -> float:
    """One linear constraint that cuts the optimum off."""
    return max(0.0, x[0] + x[1] - 2.0)


def evaluate(X: Any) -> Evaluation:
    """Judge candidates for the package."""
    return Evaluation(np.array([cost_of(x) for x in X]), np.array([[violation_of(x)] for x in X]))


def asked(optimizer: Optimizer[Any], seed: int) -> list[np.ndarray]:
    """Return what the package evaluates, call by call, until thirty generations are complete."""
    rng = np.random.default_rng(seed)
    state = optimizer.start(LOWER, UPPER, rng, total_generations=GENERATIONS)
    calls = []
    while state.generation < GENERATIONS:
        X, state = optimizer.ask(state, rng)
        calls.append(np.array(X))
        state = optimizer.tell(state, X, evaluate(X))
    return calls


def inside(x: list[float]) -> list[float]:
    """Clip one candidate into the box."""
    return [min(max(v, low), high) for v, low, high in zip(x, LOWER, UPPER)]


class Sparrow:
    """A position with its scores."""

    def __init__(self, x: list[float]) -> None:
        self.x, self.f, self.c = x, cost_of(x), violation_of(x)

    def beats(self, other: Sparrow) -> bool:
        """Less violation, then less cost."""
        return (self.c, self.f) < (other.c, other.f)


def uniform(rng: np.random.Generator) -> list[list[float]]:
    """Return the initial population."""
    u = rng.random((N, D))
    return [[LOWER[j] + (UPPER[j] - LOWER[j]) * u[i, j] for j in range(D)] for i in range(N)]


def sorted_flock(flock: list[Sparrow]) -> list[Sparrow]:
    """Return the flock, best first."""
    return sorted(flock, key=lambda s: (s.c, s.f))


def sparrow_search(
    rng: np.random.Generator,
    *,
    start: Callable[[np.random.Generator], list[list[float]]] = uniform,
    safety: float = 0.8,
    greedy: bool = True,
    per_coordinate: bool = True,
    joiners: bool = False,
    levy: bool = False,
    beta_at: Callable[[float], float] | None = None,
    factor_at: Callable[[float], float] | None = None,
    scaled: bool = False,
    order: Callable[[list[Sparrow]], list[Sparrow]] = sorted_flock,
    elite: bool = False,
) -> Candidates:
    """Yield the candidates of Eqs. (37) to (50) of Ma et al. and (13) to (19) of Zhang et al."""
    first = start(rng)
    yield first
    flock = [Sparrow(x) for x in first]
    if elite:
        flock = yield from oppose(rng, flock, order)
    best = min(flock, key=lambda s: (s.c, s.f))
    producers, scouts = round(0.2 * N), round(0.1 * N)
    near = (N - producers if joiners else N) // 2 - producers
    for t in range(1, GENERATIONS + 1):
        share = t / GENERATIONS
        before = best.f
        flock = order(flock)
        # producers
        moved: list[list[float]] = []
        if rng.random() < safety:
            if levy:
                mu, nu = rng.standard_normal((producers, D)), rng.standard_normal((producers, D))
                sigma = 0.696574502557698
                for i in range(producers):
                    step = [sigma * mu[i, j] / abs(nu[i, j]) ** (1 / 1.5) for j in range(D)]
                    moved.append([x + x * s for x, s in zip(flock[i].x, step)])
            else:
                alpha = 1.0 - rng.random((producers, 1))
                for i in range(producers):
                    shrink = math.exp(-(i + 1) / (alpha[i, 0] * GENERATIONS))
                    moved.append([x * shrink for x in flock[i].x])
        else:
            q = rng.standard_normal((producers, 1))
            w = 0.9 - 0.5 * share**2 if levy else 1.0
            moved = [[x + q[i, 0] * w for x in flock[i].x] for i in range(producers)]
        best = yield from settle(flock, range(producers), moved, best, greedy)
        # scroungers
        leader = min(flock[:producers], key=lambda s: (s.c, s.f))
        worst = flock[-1].x
        signs = rng.random((near, D))
        q = rng.standard_normal((N - producers - near, 1))
        moved = []
        for i in range(producers, N):
            x = flock[i].x
            if i < producers + near:
                a = [1.0 if signs[i - producers, j] >= 0.5 else -1.0 for j in range(D)]
                jump = sum(abs(x[j] - leader.x[j]) * a[j] for j in range(D)) / D
                moved.append([p + jump for p in leader.x])
            else:
                k = i + 1
                moved.append([q[i - producers - near, 0] * math.exp((worst[j] - x[j]) / k**2) for j in range(D)])
        best = yield from settle(flock, range(producers, N), moved, best, greedy)
        # scouts
        rows = list(rng.random(N).argsort()[:scouts])
        moved = []
        if levy:
            r = rng.random((scouts, D))
            b1 = max(1.0 - share, 0.0) ** t
            for k in range(scouts):
                back = [UPPER[j] + r[k, j] * (LOWER[j] - best.x[j]) for j in range(D)]
                moved.append([back[j] + b1 * (best.x[j] - back[j]) for j in range(D)])
        else:
            if beta_at is None:
                beta = rng.standard_normal((scouts, D if per_coordinate else 1)) * np.ones(D)
                factor = 2.0 * rng.random((scouts, 1)) - 1.0
            elif scaled:
                beta = rng.standard_normal((scouts, D if per_coordinate else 1)) * np.ones(D) * beta_at(share)
                assert factor_at is not None
                factor = (2.0 * rng.random((scouts, 1)) - 1.0) * factor_at(share)
            else:
                assert factor_at is not None
                beta, factor = np.full((scouts, D), beta_at(share)), np.full((scouts, 1), factor_at(share))
            last = order(flock)[-1]
            for k, row in enumerate(rows):
                s = flock[row]
                if (s.f, s.c) == (best.f, best.c):
                    size = (s.f - last.f) + 1e-50
                    moved.append([s.x[j] + factor[k, 0] * abs(s.x[j] - last.x[j]) / size for j in range(D)])
                else:
                    moved.append([best.x[j] + beta[k, j] * abs(s.x[j] - best.x[j]) for j in range(D)])
        best = yield from settle(flock, rows, moved, best, greedy or levy)
        if elite and abs(best.f - before) <= 1e-3 * abs(before):
            best = yield from mutate(rng, flock, best, share)


def settle(
    flock: list[Sparrow], rows: Any, moved: list[list[float]], best: Sparrow, greedy: bool
) -> Iterator[Any]:
    """Ask for the moved positions, keep them, and return the best so far."""
    tries = [inside(x) for x in moved]
    yield tries
    candidates = [Sparrow(x) for x in tries]
    kept = []
    for row, candidate in zip(rows, candidates):
        if not greedy or candidate.beats(flock[row]):
            flock[row] = candidate
            kept.append(candidate)
    for candidate in sorted(kept, key=lambda s: (s.c, s.f))[:1]:
        if candidate.beats(best):
            best = candidate
    return best


def oppose(
    rng: np.random.Generator, flock: list[Sparrow], order: Callable[[list[Sparrow]], list[Sparrow]]
) -> Iterator[Any]:
    """Elite opposition-based learning of the initial population."""
    elites = order(flock)[: (N + 1) // 2]
    a = [min(s.x[j] for s in elites) for j in range(D)]
    b = [max(s.x[j] for s in elites) for j in range(D)]
    k, again = rng.random((N, 1)), rng.random((N, D))
    opposite = []
    for i, s in enumerate(flock):
        x = [k[i, 0] * (a[j] + b[j]) - s.x[j] for j in range(D)]
        drawn = [LOWER[j] + (UPPER[j] - LOWER[j]) * again[i, j] for j in range(D)]
        opposite.append([x[j] if LOWER[j] <= x[j] <= UPPER[j] else drawn[j] for j in range(D)])
    yield opposite
    return order(flock + [Sparrow(x) for x in opposite])[:N]


def mutate(rng: np.random.Generator, flock: list[Sparrow], best: Sparrow, share: float) -> Iterator[Any]:
    """Gauss-Cauchy mutation of the best sparrow of the flock."""
    row = min(range(N), key=lambda i: (flock[i].c, flock[i].f))
    present, other = flock[row], flock[int(N * rng.random())]
    s = 1.0 if present.f < other.f else math.exp((present.f - other.f) / abs(present.f))
    cauchy, normal = rng.standard_cauchy((1, D)), rng.standard_normal((1, D))
    x = [
        present.x[j] * (1 + (1 - share**2) * s * cauchy[0, j] + share**2 * s * normal[0, j]) for j in range(D)
    ]
    mutant = inside(x)
    yield [mutant]
    candidate = Sparrow(mutant)
    if candidate.beats(present):
        flock[row] = candidate
        if candidate.beats(best):
            best = candidate
    return best


def dominates(a: Sparrow, b: Sparrow) -> bool:
    """No worse in cost and violation, and better in one of them."""
    return a.f <= b.f and a.c <= b.c and (a.f < b.f or a.c < b.c)


def non_dominated(flock: list[Sparrow]) -> list[Sparrow]:
    """Sort by fronts of (cost, violation), inside a front by crowding; the feasible best leads."""
    if not any(s.c for s in flock):
        return sorted(flock, key=lambda s: s.f)
    left, ranked = list(range(len(flock))), []
    while left:
        front = [i for i in left if not any(dominates(flock[k], flock[i]) for k in left)]
        crowding = dict.fromkeys(front, 0.0)
        row = sorted(front, key=lambda i: (flock[i].f, flock[i].c))
        for value in (lambda s: s.f, lambda s: s.c):
            extent = abs(value(flock[row[-1]]) - value(flock[row[0]]))
            for before, i, after in zip(row, row[1:], row[2:]):
                gap = abs(value(flock[after]) - value(flock[before]))
                crowding[i] += gap / extent if extent > 0 else 0.0
        crowding[row[0]] = crowding[row[-1]] = math.inf
        ranked += sorted(front, key=lambda i: -crowding[i])
        left = [i for i in left if i not in front]
    leader = min(range(len(flock)), key=lambda i: (flock[i].c, flock[i].f))
    return [flock[leader], *(flock[i] for i in ranked if i != leader)]


def tent(rng: np.random.Generator) -> list[list[float]]:
    """Return the initial population of the Tent map."""
    x, kicks = rng.random(N), rng.random((D, N))
    population = []
    for i in range(N):
        z, row = x[i], []
        for j in range(D):
            z = ((2 * z if z < 0.5 else 2 * (1 - z)) + kicks[j, i] / D) % 1.0
            row.append(LOWER[j] + (UPPER[j] - LOWER[j]) * z)
        population.append(row)
    return population


def logistic_sine(rng: np.random.Generator) -> list[list[float]]:
    """Return the initial population of the two-dimensional logistic-sine map, a = 0.9."""
    x, y = rng.uniform(1e-6, 1 - 1e-6), rng.uniform(1e-6, 1 - 1e-6)
    a, orbit = 0.9, []  # a chaotic map: rounding differently would lead elsewhere
    while len(orbit) < N * D:
        x = abs(math.sin(math.pi * (4 * a * x * (1 - x) + (1 - a) * math.sin(math.pi * y))))
        y = abs(math.sin(math.pi * (4 * a * y * (1 - y) + (1 - a) * math.sin(math.pi * x))))
        orbit += [x, y]
    return [[LOWER[j] + (UPPER[j] - LOWER[j]) * orbit[i * D + j] for j in range(D)] for i in range(N)]


def particle_swarm(rng: np.random.Generator, schedule: str) -> Candidates:
    """Yield the candidates of particle swarm with the inertia of Zhu & Wang, Eqs. (10) to (12), or a linear one."""
    X = uniform(rng)
    yield X
    swarm = [Sparrow(x) for x in X]
    own = list(swarm)
    V = [[0.0] * D for _ in range(N)]
    for t in range(1, GENERATIONS + 1):
        s = t / GENERATIONS
        if schedule == "linear":
            w, c1, c2 = 0.9 - 0.5 * s, 2.0, 2.0
        else:
            c1, c2 = 2 * math.cos(math.pi * s / 3) ** 2, 2 * math.sin(math.pi * s / 1.5) ** 2
            repaired = schedule == "trigonometric-repaired"
            if s <= 0.6:
                w = 0.5 * math.cos(math.pi * s if repaired else s) ** 2 + (0.4 if repaired else 0.0)
            else:
                w = 0.2 + 0.1 * rng.random()
        r1, r2 = rng.random((N, D)), rng.random((N, D))
        best = min(own, key=lambda p: (p.c, p.f))
        X = []
        for i in range(N):
            for j in range(D):
                x, limit = swarm[i].x[j], 0.5 * (UPPER[j] - LOWER[j])
                v = w * V[i][j] + c1 * r1[i, j] * (own[i].x[j] - x) + c2 * r2[i, j] * (best.x[j] - x)
                V[i][j] = min(max(v, -limit), limit)
            free = [x + v for x, v in zip(swarm[i].x, V[i])]
            X.append(inside(free))
            V[i] = [v if a == b else 0.0 for v, a, b in zip(V[i], free, X[-1])]
        yield X
        swarm = [Sparrow(x) for x in X]
        own = [p if p.beats(q) else q for p, q in zip(swarm, own)]


def annealed_beta(s: float) -> float:
    """Return beta of Zhang et al., Eq. (18), with the stand-in ends 0.2 and 1."""
    return 0.2 + 0.8 * (1 + math.cos(math.pi * s)) / 2


def late_factor(s: float) -> float:
    """Return K of Zhang et al., Eq. (19), with the stand-in ends 0 and 1."""
    return math.sin(math.pi * s * s)


ADAPTIVE: dict[str, Any] = {"beta_at": annealed_beta, "factor_at": late_factor, "safety": 0.5}
RULES: dict[str, tuple[Optimizer[Any], Callable[[np.random.Generator], Candidates]]] = {
    "ssa, the author's own program": (
        SparrowSearch(population=N),
        lambda rng: sparrow_search(rng),
    ),
    "ssa, greedy, beta scalar": (
        SparrowSearch(population=N, beta="scalar"),
        lambda rng: sparrow_search(rng, per_coordinate=False),
    ),
    "ssa, always": (
        SparrowSearch(population=N, beta="scalar", replacement="always"),
        lambda rng: sparrow_search(rng, per_coordinate=False, greedy=False),
    ),
    "ssa, n of the joiners": (
        SparrowSearch(population=N, hungry="scroungers"),
        lambda rng: sparrow_search(rng, joiners=True),
    ),
    "issa-b": (
        LevySparrowSearch(population=N),
        lambda rng: sparrow_search(rng, start=logistic_sine, levy=True),
    ),
    "t-ssa": (
        TentSparrowSearch(population=N, safety=0.5, adaptive=False),
        lambda rng: sparrow_search(rng, start=tent, safety=0.5),
    ),
    "adf-ssa": (
        TentSparrowSearch(population=N, safety=0.5, tent=False),
        lambda rng: sparrow_search(rng, **ADAPTIVE),
    ),
    "tadf-ssa": (
        TentSparrowSearch(population=N, safety=0.5),
        lambda rng: sparrow_search(rng, start=tent, **ADAPTIVE),
    ),
    "tadf-ssa, factors scaled": (
        TentSparrowSearch(population=N, safety=0.5, factors="scale"),
        lambda rng: sparrow_search(rng, start=tent, scaled=True, **ADAPTIVE),
    ),
    "issa-a": (
        EliteSparrowSearch(population=N),
        lambda rng: sparrow_search(rng, order=non_dominated, elite=True),
    ),
    "pso, linear": (
        ParticleSwarm(population=N, inertia="linear", cognitive=2.0, social=2.0),
        lambda rng: particle_swarm(rng, "linear"),
    ),
    "pso-d, printed": (
        ParticleSwarm(population=N, inertia="trigonometric"),
        lambda rng: particle_swarm(rng, "trigonometric"),
    ),
    "pso-d, repaired": (
        ParticleSwarm(population=N, inertia="trigonometric-repaired"),
        lambda rng: particle_swarm(rng, "trigonometric-repaired"),
    ),
}


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("name", list(RULES))
def test_thirty_generations_agree_with_straight_line_code(name: str, seed: int) -> None:
    optimizer, program = RULES[name]
    expected = [np.array(X) for X in program(np.random.default_rng(seed))]
    calls = asked(optimizer, seed)
    assert len(calls) == len(expected)
    for number, (mine, theirs) in enumerate(zip(calls, expected)):
        assert mine.shape == theirs.shape, f"call {number}"
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-12, err_msg=f"call {number}")
