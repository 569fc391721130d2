"""What the checker encloses is enclosed: balls, sines, polynomials, interpolants."""

from __future__ import annotations

import math
from decimal import Decimal, getcontext
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from helpers.proofs.proof_motions import torque_motion
from ocp_traj.proofs import Refused, checker
from ocp_traj.proofs.checker import Ball
from ocp_traj.proofs.resolve import resolve_motion, resolve_task


def test_balls_contain_the_exact_results_of_random_formulas() -> None:
    rng = np.random.default_rng(0)
    for _ in range(300):
        exact = [Fraction(x) for x in rng.normal(size=4) * 10.0 ** rng.integers(-5, 5, 4)]
        balls = [Ball(float(x)) for x in exact]
        for _ in range(40):
            i, j = rng.integers(4, size=2)
            operation = rng.integers(5)
            number = float(rng.normal())
            if operation == 0:
                pair = (exact[i] + exact[j], balls[i] + balls[j])
            elif operation == 1:
                pair = (exact[i] - exact[j], balls[i] - balls[j])
            elif operation == 2:
                pair = (exact[i] * exact[j], balls[i] * balls[j])
            elif operation == 3:
                pair = (Fraction(number) * exact[i], number * balls[i])
            else:
                pair = (Fraction(number) - exact[i], number - balls[i])
            if abs(pair[0]) < 1e30:
                exact[j], balls[j] = pair
            assert all(abs(x - Fraction(ball.c)) <= Fraction(ball.e) for x, ball in zip(exact, balls))


def test_the_radius_grows_no_faster_than_rounding_may() -> None:
    total, product = Ball(0.0), Ball(1.0)
    for x in np.random.default_rng(6).uniform(0.5, 2.0, 100):
        total, product = total + float(x), product * float(x)
    assert total.e < 100 * 2.0**-51 * total.c and product.e < 100 * 2.0**-51 * product.c


def test_the_radius_of_a_product_holds_complex_factors_on_both_rims() -> None:
    rng = np.random.default_rng(1)
    for _ in range(500):
        a, b = (Ball(float(c), float(e)) for c, e in zip(rng.normal(size=2), rng.uniform(0, 2, 2)))
        turns = np.exp(2j * np.pi * rng.random(2))
        x, y = a.c + a.e * turns[0], b.c + b.e * turns[1]
        for result, value in ((a + b, x + y), (a - b, x - y), (a * b, x * y), (-a, -x)):
            assert abs(value - result.c) <= result.e * (1 + 1e-12)
        assert (a * b).e <= (abs(a.c) + a.e) * (abs(b.c) + b.e)


def known_sine(x: float) -> tuple[Decimal, Decimal]:
    """Return sine and cosine to 60 digits, by Taylor's series at x / 2^12 and doubling."""
    getcontext().prec = 90
    small = Decimal(x) / 4096
    s, c, term = Decimal(0), Decimal(0), Decimal(1)
    for k in range(60):
        if k % 2:
            s += term * (-1) ** (k // 2)
        else:
            c += term * (-1) ** (k // 2)
        term *= small / (k + 1)
    for _ in range(12):
        s, c = 2 * s * c, c * c - s * s
    return s, c


def test_sine_and_cosine_are_enclosed_up_to_a_hundred_radians() -> None:
    rng = np.random.default_rng(2)
    for x in (0.0, 1e-300, -1e-9, math.pi, 57.0, 100.0, -100.0, *rng.uniform(-100, 100, 200), *rng.normal(size=100)):
        s, c, error = checker.fixed_sine_cosine(float(x))
        sine, cosine = known_sine(float(x))
        assert abs(Decimal(s) - sine) <= Decimal(error) and abs(Decimal(c) - cosine) <= Decimal(error)
        assert error < 3e-16 and s == pytest.approx(math.sin(x), abs=4e-16)


def test_sine_and_cosine_of_complex_discs_are_enclosed() -> None:
    rng = np.random.default_rng(3)
    for _ in range(500):
        ball = Ball(float(rng.uniform(-10, 10)), float(rng.uniform(0, 1.19)))
        z = ball.c + ball.e * np.exp(2j * np.pi * rng.random())
        sine, cosine = checker.sine_cosine(ball)
        assert abs(np.sin(z) - sine.c) <= sine.e and abs(np.cos(z) - cosine.c) <= cosine.e
        assert sine.e <= 3.0 * ball.e + 1e-15
    wide, _ = checker.sine_cosine(Ball(0.0, 1.3))
    assert wide.e == math.inf


def test_angles_beyond_a_thousand_radians_are_refused() -> None:
    with pytest.raises(Refused, match="1001 rad"):
        checker.fixed_sine_cosine(1001.0)


def random_polynomial(rng: np.random.Generator) -> tuple[list[Fraction], Fraction]:
    degree = int(rng.integers(0, 8))
    return [Fraction(float(x)) for x in rng.normal(size=degree + 1)], Fraction(float(rng.uniform(0.1, 3)))


def test_a_polynomial_is_within_its_range_and_not_within_less() -> None:
    rng = np.random.default_rng(4)
    for _ in range(60):
        c, h = random_polynomial(rng)
        grid = [checker.polynomial_value(c, h * k / 64) for k in range(65)]
        low, high = min(grid), max(grid)
        slope = max(abs(checker.polynomial_value(checker.derivative(c), h * k / 64)) for k in range(65))
        room = slope * h / 16 + Fraction(1, 10**6)
        assert checker.within(c, h, low - room, high + room)
        for lower, upper in ((low, high), (low - room, math.inf), (-math.inf, high)):
            try:
                held = checker.within(c, h, lower, upper)
            except Refused:
                continue
            values = [checker.polynomial_value(c, h * k / 101) for k in range(102)]
            assert not held or all(lower <= value <= upper for value in values)
        assert not checker.within(c, h, low + Fraction(1, 10**9), math.inf)
        assert not checker.within(c, h, -math.inf, high - Fraction(1, 10**9))


def test_a_range_touched_inside_is_held_with_a_hair_of_room() -> None:
    bump = [Fraction(0), Fraction(1), Fraction(-1)]  # largest 1/4 at 1/2
    assert checker.within(bump, Fraction(1), Fraction(0), Fraction(1, 4))
    third = [Fraction(0), Fraction(2), Fraction(-3)]  # largest 1/3 at 1/3, which no halving meets
    assert checker.within(third, Fraction(1), Fraction(-1), Fraction(1, 3) + Fraction(1, 10**12))
    assert not checker.within(third, Fraction(1), Fraction(-1), Fraction(1, 3) - Fraction(1, 10**12))


def test_shifting_and_squaring_polynomials() -> None:
    rng = np.random.default_rng(5)
    for _ in range(50):
        c, h = random_polynomial(rng)
        u = Fraction(float(rng.uniform(-1, 1)))
        value = checker.polynomial_value(c, h + h / 3 * u)
        assert checker.polynomial_value(checker.shifted(c, h, h / 3), u) == value
        assert checker.polynomial_value(checker.product(c, c), u) == checker.polynomial_value(c, u) ** 2


@pytest.mark.parametrize("degree", sorted(checker.DEGREES.values()))
def test_interpolation_errors_lie_below_the_contour_bound(degree: int) -> None:
    nodes = checker.Nodes(degree)
    rng = np.random.default_rng(degree)
    grid = np.linspace(-1, 1, 41)
    weights = np.array([[math.comb(degree, i) * ((1 + u) / 2) ** i * ((1 - u) / 2) ** (degree - i)
                         for i in range(degree + 1)] for u in grid])  # fmt: skip
    slopes = np.array([[math.comb(degree - 1, i) * ((1 + u) / 2) ** i * ((1 - u) / 2) ** (degree - 1 - i)
                        for i in range(degree)] for u in grid])  # fmt: skip
    circle = checker.RADIUS * np.exp(2j * np.pi * np.arange(400) / 400)
    closest = 0.0
    for _ in range(120):
        a, b, k = rng.normal(), rng.normal(), rng.uniform(0.5, 2.5)
        pole = (checker.RADIUS + rng.uniform(0.3, 2.0)) * rng.choice([-1, 1])
        places = (circle, np.zeros(1), np.array(nodes.u), grid)
        wave = [a * np.sin(k * z + b) for z in places] + [a * k * np.cos(k * grid + b)]
        fraction = [a / (z - pole) for z in places] + [-a / (grid - pole) ** 2]
        for around, middle, given, true, true_slope in (wave, fraction):
            largest = np.abs(around - middle).max()
            values = [Ball(float(value), 1e-14) for value in given]
            coefficients, slope, rounding, slope_rounding = nodes.interpolate(values, Fraction(1))
            error = np.abs(weights @ coefficients - true).max()
            assert error <= largest * nodes.value_factor + rounding
            slope_error = np.abs(slopes @ slope - true_slope).max()
            assert slope_error <= largest * nodes.slope_factor + slope_rounding
            closest = max(closest, error / (largest * nodes.value_factor + rounding))
    assert closest > 1e-4  # the bound is not far away from what happens


def test_rounding_of_node_values_is_carried_to_the_interpolant() -> None:
    rng = np.random.default_rng(7)
    for degree in checker.DEGREES.values():
        nodes = checker.Nodes(degree)
        grid = np.linspace(0.0, 1.0, 21)
        for _ in range(10):
            noise = rng.choice([-1.0, 1.0], degree + 1) * 1e-3
            b, slope, error, slope_error = nodes.interpolate([Ball(0.0, 1e-3)] * (degree + 1), Fraction(1, 2))
            moved, moved_slope, *_ = nodes.interpolate([Ball(float(x)) for x in noise], Fraction(1, 2))
            assert max(map(abs, b + slope)) == 0.0
            for t in grid:
                assert abs(casteljau(moved, t)) <= error
                assert abs(casteljau(moved_slope, t)) <= slope_error


def casteljau(b: list[float], t: float) -> float:
    row = b
    while len(row) > 1:
        row = [(1 - t) * x + t * y for x, y in zip(row, row[1:])]
    return row[0]


def dynamics(seed: int, **changes: Any) -> checker.Dynamics:
    task, motion = torque_motion(seed, **changes)
    resolved = checker.read_task(resolve_task(task))
    assert resolved.robot is not None
    return checker.Dynamics(resolved, checker.read_motion(resolve_motion(task, motion), resolved), resolved.robot)


def test_torques_in_balls_are_those_of_pinocchio_and_discs_hold_them() -> None:
    for seed in (0, 2, 3, 6):
        task, motion = torque_motion(seed, friction=2.0)
        robot = task.robot
        assert robot is not None
        found = dynamics(seed, friction=2.0)
        half = found.motion.lengths[0] / 16
        powers = found._powers(0, half, half)
        disc = found._torques_at(powers, Ball(0.0, 1.0))
        for u in (-1.0, -0.3, 0.8):
            t = np.array([float(half) * (1 + u)])
            q, v, a = (motion(t, order) for order in range(3))
            expected = robot.torque(q, v, a)[0] - robot.friction.coulomb * np.sign(v[0])
            for ball, value, hull in zip(found._torques_at(powers, Ball(u)), expected, disc):
                assert abs(ball.c - value) <= 1e-9 * (1 + abs(value)) and ball.e <= 1e-10 * (1 + abs(value))
                assert abs(value - hull.c) <= hull.e


def test_friction_has_the_sign_of_the_velocity() -> None:
    found = dynamics(0, friction=3.0)
    coulomb = found.robot.coulomb[0]
    still = [0.0, 0.0, 0.0]
    assert found._with_friction(0, [1.0, 1.0], still) == [([1.0, 1.0], still, 1.0)]
    ((forth, _, _),) = found._with_friction(0, [1.0, 1.0], [0.0, 0.5, 1.0])
    ((back, _, _),) = found._with_friction(0, [1.0, 1.0], [0.0, -0.5, -1.0])
    assert forth == [1.0 + coulomb] * 2 and back == [1.0 - coulomb] * 2
    turning = found._with_friction(0, [1.0, 1.0], [-1.0, 1.0])
    assert sum(share for *_, share in turning) == 1.0
    signs = {part[0] for part, _, _ in turning}
    assert {1.0 + coulomb, 1.0 - coulomb} <= signs


def test_means_of_parts_are_upper_bounds() -> None:
    rng = np.random.default_rng(9)
    for _ in range(30):
        b = rng.normal(size=int(rng.integers(2, 9))).tolist()
        values = np.array([casteljau(b, k / 400) for k in range(401)])
        trapezoid = np.full(401, 1 / 400)
        trapezoid[[0, -1]] /= 2
        for part, exact in ((abs, np.abs(values)), (checker._positive, np.maximum(values, 0))):
            bound = checker.mean_of_part(b, part)
            assert exact @ trapezoid - 1e-4 <= bound <= exact @ trapezoid + 1e-3
