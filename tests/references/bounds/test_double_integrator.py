"""The exact test of durations, and its relaxation over boxes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from ocp_traj.references.bounds.double_integrator import JointLimits, feasible, shortest_total


def one_joint(distances: list[float], speed: float, up: float, down: float) -> JointLimits:
    gaps = len(distances)
    column = np.ones((gaps, 1))
    d = np.array(distances)[:, None]
    rest = np.zeros((2, 1))
    return JointLimits(speed * column, speed * column, up * column, down * column, d, d, start=rest, end=rest)


def possible(limits: JointLimits, durations: list[float]) -> bool:
    h = np.array([durations])
    return bool(feasible(limits, h, h)[0])


def random_limits(rng: np.random.Generator, gaps: int, n: int) -> JointLimits:
    shape = (gaps, n)
    distance = rng.normal(size=shape)
    sides = [rng.uniform(0.3, 2.0, shape) for _ in range(4)]
    rest = np.zeros((2, n))
    return JointLimits(*sides, distance, distance, start=rest, end=rest)


def sampled_feasible(limits: JointLimits, durations: np.ndarray, steps: int, loosened: float) -> bool:
    """Whether a motion with piecewise constant acceleration exists: a linear programme, joint by joint."""
    for joint in range(limits.fastest.shape[1]):
        v_rows, v_bounds, d_rows, bounds = [], [], [], []
        size = limits.gaps * steps
        velocity = np.zeros(size)
        for gap in range(limits.gaps):
            dt = durations[gap] / steps
            travelled = np.zeros(size)
            for step in range(steps):
                before = velocity.copy()
                velocity[gap * steps + step] = dt
                travelled += 0.5 * (before + velocity) * dt
                v_rows += [velocity.copy(), -velocity]
                v_bounds += [loosened * limits.fastest[gap, joint], loosened * limits.slowest[gap, joint]]
                bounds.append(
                    (-loosened * limits.braking[gap, joint], loosened * limits.speeding[gap, joint])
                )
            d_rows.append(travelled)
        equal = np.vstack([*d_rows, velocity])
        right = np.append(limits.nearest[:, joint], 0.0)
        answer = linprog(np.zeros(size), A_ub=v_rows, b_ub=v_bounds, A_eq=equal, b_eq=right, bounds=bounds)
        if answer.status != 0:
            return False
    return True


def test_one_gap_is_feasible_exactly_from_its_bang_bang_time_on() -> None:
    limits = one_joint([2.0], 1.0, 2.0, 4.0)
    shortest = 0.5 + 0.25 + (2.0 - 0.25 - 0.125)
    assert not possible(limits, [shortest * (1 - 1e-9)])
    assert possible(limits, [shortest * (1 + 1e-9)])


def test_feasible_durations_of_one_joint_can_be_disconnected() -> None:
    # crossing the first gap in that time needs full acceleration, so the joint arrives with velocity sqrt(2);
    # it passes the second gap at once (0.32 s to 0.41 s), or overshoots and comes back (2.41 s and more)
    limits = one_joint([1.0, 0.5, 0.2], 10.0, 1.0, 1.0)
    second = np.linspace(0.1, 4.0, 4000)
    h = np.column_stack([np.full(4000, np.sqrt(2.0) + 1e-9), second, np.full(4000, 20.0)])
    answers = feasible(limits, h, h)
    ends = second[np.flatnonzero(np.diff(answers.astype(int)))]
    assert ends == pytest.approx([np.sqrt(3) - np.sqrt(2), np.sqrt(2) - 1, np.sqrt(2) + 1], abs=2e-3)


@pytest.mark.parametrize("seed", range(6))
def test_point_test_agrees_with_a_linear_programme(seed: int) -> None:
    rng = np.random.default_rng(seed)
    limits = random_limits(rng, 2, 1)
    checked = 0
    for durations in rng.uniform(0.3, 6.0, size=(25, 2)):
        exact = bool(feasible(limits, durations[None, :], durations[None, :])[0])
        if exact:
            assert sampled_feasible(limits, durations, 30, 1.1)
        else:
            assert not sampled_feasible(limits, durations, 30, 1.0 - 1e-7)
        checked += 1
    assert checked == 25


def test_a_box_around_a_feasible_point_is_never_discarded() -> None:
    rng = np.random.default_rng(7)
    kept = 0
    for _ in range(40):
        limits = random_limits(rng, int(rng.integers(1, 6)), int(rng.integers(1, 4)))
        h = rng.uniform(0.2, 6.0, size=(500, limits.gaps))
        good = h[feasible(limits, h, h)]
        width = rng.uniform(0.0, 1.0, size=good.shape) * rng.choice(
            [1e-3, 0.1, 1.0, 5.0], size=(len(good), 1)
        )
        low = np.maximum(good - width * rng.random(good.shape), 0.0)
        high = good + width * rng.random(good.shape)
        assert feasible(limits, low, high).all()
        kept += len(good)
    assert kept > 500


def test_slower_is_feasible_too_from_rest_to_rest() -> None:
    rng = np.random.default_rng(8)
    limits = random_limits(rng, 4, 3)
    h = rng.uniform(0.2, 8.0, size=(4000, 4))
    good = h[feasible(limits, h, h)]
    assert len(good) > 20
    for scale in (1.001, 1.3, 10.0):
        assert feasible(limits, good * scale, good * scale).all()


def test_shortest_total_is_where_the_test_changes() -> None:
    limits = random_limits(np.random.default_rng(9), 3, 4)
    p = np.random.default_rng(10).dirichlet(np.ones(3), 50)
    total = shortest_total(limits, p, 1000.0)[:, None]
    assert feasible(limits, p * total, p * total).all()
    assert not feasible(limits, p * total * (1 - 1e-9), p * total * (1 - 1e-9)).any()
