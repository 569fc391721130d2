"""Error-free sums and rational bounds, against fractions."""

from __future__ import annotations

from fractions import Fraction
from math import perm

import numpy as np
import pytest

from ocp_traj.audit import audit
from ocp_traj.audit.motion import Motion, nearest_index
from ocp_traj.audit.numerics.exact import range_of
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory


def value(coefficients: np.ndarray, x: Fraction, order: int) -> Fraction:
    """Return a derivative in rational arithmetic."""
    terms = (
        Fraction(float(c)) * perm(power, order) * x ** (power - order)
        for power, c in enumerate(coefficients)
        if power >= order
    )
    return sum(terms, Fraction(0))


def shifted_chebyshev(degree: int) -> np.ndarray:
    """Return the powers of T_n(2 x - 1), between -1 and 1 on [0, 1]; they are whole numbers."""
    before, now = [1], [-1, 2]
    for _ in range(degree - 1):
        doubled = [4 * b - 2 * a for a, b in zip([*now, 0], [0, *now])]
        before, now = now, [a - b for a, b in zip(doubled, [*before, 0, 0])]
    assert all(float(c) == c for c in now)
    return np.array(now, dtype=np.float64)


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("seed", range(4))
def test_jumps_are_those_of_fractions(seed: int, order: int) -> None:
    rng = np.random.default_rng(seed)
    times = np.concatenate([[0.0], np.cumsum(10.0 ** rng.uniform(-14, 1, 12))]) + rng.uniform(0, 5)
    coefficients = rng.normal(size=(12, 2, 8)) * 10.0 ** rng.uniform(-3, 12, (12, 2, 8))
    found = Motion.of(Trajectory(times, coefficients, times[[0, -1]])).steps(order)
    for knot in range(11):
        h = Fraction(times[knot + 1]) - Fraction(times[knot])
        for joint in range(2):
            after = value(coefficients[knot + 1, joint], Fraction(0), order)
            exact = abs(after - value(coefficients[knot, joint], h, order))
            assert found[knot, joint] == pytest.approx(float(exact), rel=1e-14, abs=0.0)


def test_a_jump_of_one_ulp_is_one_and_none_is_none() -> None:
    third = 1.0 / 3.0
    same = Trajectory([0.0, 0.5, 1.0], [[[third, 0.5]], [[third + 0.25, 0.5]]], [0.0, 1.0])
    exact = abs(Fraction(third + 0.25) - Fraction(third) - Fraction(1, 4))
    assert Motion.of(same).steps(0)[0, 0] == pytest.approx(float(exact), abs=1e-28)
    assert Motion.of(same).steps(1)[0, 0] <= 1e-28


def test_a_range_is_that_of_known_polynomials() -> None:
    for degree in (1, 2, 5, 20):
        coefficients = shifted_chebyshev(degree)
        low, at_low, high, at_high = range_of(coefficients, 3.0, 4.0, 0)
        assert (low, high) == (pytest.approx(-1.0, abs=2e-12), pytest.approx(1.0, abs=2e-12))
        for at, expected in ((at_low, low), (at_high, high)):
            assert float(value(coefficients, Fraction(at), 0)) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("order", [0, 1, 3])
def test_a_range_contains_all_values_and_is_tight(order: int) -> None:
    rng = np.random.default_rng(order)
    for degree in (0, 1, 3, 7):
        coefficients = rng.normal(size=degree + 1)
        low, _, high, _ = range_of(coefficients, 0.25, 1.5, order)
        samples = [float(value(coefficients, Fraction(5 * k, 4 * 400), order)) for k in range(401)]
        assert low <= min(samples) + 1e-12 * (1 + abs(low))
        assert high >= max(samples) - 1e-12 * (1 + abs(high))
        assert high - max(samples) <= 1e-3 * (1 + max(samples) - min(samples))
        assert min(samples) - low <= 1e-3 * (1 + max(samples) - min(samples))


def test_a_polynomial_whose_terms_cancel_is_judged_by_its_exact_values() -> None:
    """Terms up to 1e14 that leave values up to 1: floating-point numbers are wrong by percents."""
    monomials = shifted_chebyshev(20)
    assert np.abs(monomials).max() > 1e13
    motion = Trajectory([0.0, 1.0], [[monomials.tolist()]], [0.0, 1.0])
    assert np.abs(Motion.of(motion).extrema[0]).max() == pytest.approx(1.0, abs=1e-9)
    for edge, broken in ((1.0 - 6e-6, True), (1.0 + 1e-8, False)):
        task = TrajectoryTask([[0.5], [0.5]], Limits(position=[[-edge], [edge]]), tolerance=0.6)
        findings = audit(task, motion).findings
        assert any(finding.startswith("position: ") for finding in findings) is broken


def test_terms_lost_to_underflow_are_not_overlooked() -> None:
    """1e308 t^22 within a femtosecond: t^22 is no floating-point number, the acceleration it makes is 5e10."""
    for size, seen in ((1e308, False), (1e267, False), (1e265, True), (1e200, True)):
        hidden = np.zeros((1, 1, 23))
        hidden[0, 0, 22] = size  # a jerk of 22 * 21 * 20 size 1e-285: 1e-15 at 1e266
        assert Motion.of(Trajectory([0.0, 1e-15], hidden, [0.0, 1e-15])).is_in_range is seen


def test_the_nearest_breakpoint_is_found() -> None:
    breakpoints = np.array([0.0, 1.0, 1.5, 4.0])
    times = np.array([-0.1, 0.0, 0.4, 0.6, 1.3, 2.0, 3.9, 4.2])
    assert nearest_index(breakpoints, times).tolist() == [0, 0, 0, 1, 2, 2, 3, 3]
