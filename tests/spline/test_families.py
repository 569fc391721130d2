"""Every family against an independent construction, and the same numbers from numbers, batches and symbols."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.interpolate import CubicSpline, make_interp_spline

from ocp_traj.spline import EndConditions, get_family
from ocp_traj.spline.hermite import hermite_pieces


def evaluate(pieces, t, derivative=0):
    """Evaluate pieces of (1, n) entries at times t by their definition."""
    breakpoints = np.concatenate([[0.0], np.cumsum([np.ravel(piece.duration)[0] for piece in pieces])])
    index = np.clip(np.searchsorted(breakpoints, t, side="right") - 1, 0, len(pieces) - 1)
    values = []
    for time, k in zip(t, index):
        h = np.ravel(pieces[k].duration)[0]
        coefficients = np.stack([np.ravel(c) for c in pieces[k].coefficients()], axis=1)
        tau = (time - breakpoints[k]) / h
        values.append(
            [
                np.polynomial.Polynomial(row).deriv(derivative)(tau) / h**derivative
                if derivative
                else np.polynomial.Polynomial(row)(tau)
                for row in coefficients
            ]
        )
    return np.array(values)


def random_data(rng, count, n=3):
    return rng.uniform(0.2, 2.0, count - 1), rng.normal(size=(count, n))


@pytest.mark.parametrize("count", [2, 3, 4, 9])
@pytest.mark.parametrize(("name", "order"), [("cubic", 1), ("quintic", 2), ("septic", 3)])
def test_uniform_families_agree_with_scipy(name, order, count):
    rng = np.random.default_rng(count)
    h, q = random_data(rng, count)
    start, end = rng.normal(size=(order, 3)), rng.normal(size=(order, 3))
    ends = EndConditions({j + 1: start[j] for j in range(order)}, {j + 1: end[j] for j in range(order)})
    pieces = get_family(name).pieces(list(h[:, None]), list(q), ends)
    knots = np.concatenate([[0.0], np.cumsum(h)])
    reference = make_interp_spline(
        knots,
        q,
        k=2 * order + 1,
        bc_type=([(j + 1, start[j]) for j in range(order)], [(j + 1, end[j]) for j in range(order)]),
    )
    t = np.linspace(0, knots[-1], 57)
    for derivative in range(order + 2):
        expected = reference(t, derivative)
        np.testing.assert_allclose(
            evaluate(pieces, t, derivative), expected, rtol=0, atol=1e-10 * max(1.0, np.abs(expected).max())
        )


def test_clamped_cubic_agrees_with_scipys_cubic_spline():
    rng = np.random.default_rng(0)
    h, q = random_data(rng, 8)
    pieces = get_family("cubic").pieces(
        list(h[:, None]), list(q), EndConditions({1: np.zeros(3)}, {1: np.zeros(3)})
    )
    knots = np.concatenate([[0.0], np.cumsum(h)])
    reference = CubicSpline(knots, q, bc_type="clamped")
    t = np.linspace(0, knots[-1], 101)
    np.testing.assert_allclose(
        evaluate(pieces, t, 2), reference(t, 2), atol=1e-10 * np.abs(reference(t, 2)).max()
    )


def test_free_end_acceleration_of_a_quintic_is_natural():
    rng = np.random.default_rng(1)
    h, q = random_data(rng, 5)
    pieces = get_family("quintic").pieces(
        list(h[:, None]), list(q), EndConditions({1: np.zeros(3)}, {1: np.zeros(3)})
    )
    knots = np.concatenate([[0.0], np.cumsum(h)])
    zero = np.zeros(3)
    reference = make_interp_spline(knots, q, k=5, bc_type=([(1, zero), (3, zero)], [(1, zero), (3, zero)]))
    t = np.linspace(0, knots[-1], 31)
    np.testing.assert_allclose(evaluate(pieces, t), reference(t), atol=1e-10)


@pytest.mark.parametrize("count", [2, 3, 6])
def test_a_given_jerk_takes_the_place_of_a_quintics_natural_condition(count):
    rng = np.random.default_rng(count)
    h, q = random_data(rng, count)
    start, end = rng.normal(size=(2, 3)), rng.normal(size=(2, 3))
    ends = EndConditions({1: start[0], 3: start[1]}, {1: end[0], 3: end[1]})
    family = get_family("quintic")
    assert family.fixed_by_ends(ends) == (0, 0)
    pieces = family.pieces(list(h[:, None]), list(q), ends)
    knots = np.concatenate([[0.0], np.cumsum(h)])
    conditions = [[(1, side[0]), (3, side[1])] for side in (start, end)]
    reference = make_interp_spline(knots, q, k=5, bc_type=tuple(conditions))
    t = np.linspace(0, knots[-1], 31)
    np.testing.assert_allclose(evaluate(pieces, t), reference(t), atol=1e-10)


@pytest.mark.parametrize(("name", "extra"), [("cubic", 2), ("quintic", 3), ("septic", 4)])
def test_positions_next_to_the_ends_follow_from_extra_end_conditions(name, extra):
    rng = np.random.default_rng(2)
    h, q = random_data(rng, 9)
    given = {j: rng.normal(size=3) for j in range(1, extra + 1)}
    final = {j: rng.normal(size=3) for j in range(1, extra + 1)}
    positions = list(q)
    positions[1] = positions[-2] = None
    pieces = get_family(name).pieces(list(h[:, None]), positions, EndConditions(given, final))
    total = h.sum()
    for j in given:
        np.testing.assert_allclose(evaluate(pieces, [0.0], j)[0], given[j], rtol=1e-8, atol=1e-8)
        np.testing.assert_allclose(evaluate(pieces, [total], j)[0], final[j], rtol=1e-8, atol=1e-8)
    knots = np.cumsum(h)[:-1]
    for j in range(get_family(name).degree):
        left, right = evaluate(pieces, knots - 1e-12, j), evaluate(pieces, knots, j)
        np.testing.assert_allclose(left, right, rtol=1e-6, atol=1e-6 * max(1.0, np.abs(right).max()))


@pytest.mark.parametrize("count", [4, 5, 7])
def test_three_five_three_meets_its_fourteen_and_more_conditions(count):
    rng = np.random.default_rng(count)
    h, q = random_data(rng, count)
    zero = np.zeros(3)
    ends = EndConditions({1: zero, 2: zero}, {1: zero, 2: zero})
    pieces = get_family("3-5-3").pieces(list(h[:, None]), list(q), ends)
    assert [piece.degree for piece in pieces] == [3, *[5] * (count - 3), 3]
    knots = np.concatenate([[0.0], np.cumsum(h)])
    np.testing.assert_allclose(evaluate(pieces, knots), q, atol=1e-12)
    for j in (1, 2):
        np.testing.assert_allclose(evaluate(pieces, knots[[0, -1]], j), 0, atol=1e-10)
        np.testing.assert_allclose(
            evaluate(pieces, knots[1:-1] - 1e-13, j), evaluate(pieces, knots[1:-1], j), atol=1e-8
        )
    for j in (3, 4):
        inner = knots[2:-2]
        if len(inner):
            right = evaluate(pieces, inner, j)
            np.testing.assert_allclose(
                evaluate(pieces, inner - 1e-13, j), right, atol=1e-8 * np.abs(right).max()
            )


def test_first_cubic_of_three_five_three_from_rest_is_a_pure_cube():
    q = np.array([[0.0], [2.0], [3.0], [1.0]])
    zero = np.zeros(1)
    ends = EndConditions({1: zero, 2: zero}, {1: zero, 2: zero})
    first = get_family("3-5-3").pieces([np.array([0.5])] * 3, list(q), ends)[0]
    np.testing.assert_allclose(np.ravel(first.coefficients()), [0, 0, 0, 2.0], atol=1e-14)


@pytest.mark.parametrize("name", ["cubic", "quintic", "septic", "3-5-3"])
def test_batches_and_symbols_give_the_same_numbers_as_single_curves(name):
    rng = np.random.default_rng(5)
    family = get_family(name)
    q = rng.normal(size=(6, 2))
    batch = rng.uniform(0.2, 2.0, (7, 5))
    zero = np.zeros((1, 2))
    orders = range(1, max((family.degree - 1) // 2, 1) + 1)
    ends = EndConditions(dict.fromkeys(orders, zero), dict.fromkeys(orders, zero))
    rows = [row[None, :] for row in q]
    together = family.pieces([batch[:, [k]] for k in range(5)], rows, ends)
    symbols = ca.SX.sym("h", 5)
    symbolic_ends = EndConditions(
        dict.fromkeys(orders, ca.DM.zeros(1, 2)), dict.fromkeys(orders, ca.DM.zeros(1, 2))
    )
    symbolic = family.pieces([symbols[k] for k in range(5)], [ca.DM(row).T for row in q], symbolic_ends)
    function = ca.Function(
        "f", [symbols], [ca.vertcat(*[ca.vertcat(*piece.coefficients()) for piece in symbolic])]
    )
    for index, h in enumerate(batch):
        alone = family.pieces(
            list(h[:, None]),
            list(q),
            EndConditions(dict.fromkeys(orders, zero[0]), dict.fromkeys(orders, zero[0])),
        )
        stacked = np.concatenate([np.stack([np.ravel(c) for c in piece.coefficients()]) for piece in alone])
        batched = np.concatenate(
            [
                np.stack([np.broadcast_to(c, (7, 2))[index] for c in piece.coefficients()])
                for piece in together
            ]
        )
        np.testing.assert_allclose(batched, stacked, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(np.array(function(h)), stacked, rtol=1e-9, atol=1e-12)


def test_hermite_pieces_keep_the_digits_of_a_short_piece() -> None:
    """The jerk of the quintic through samples of a parabola, 1 kHz and far from zero, is that of the parabola: zero."""
    times = np.arange(200) / 1024
    position = 3.0 + times + times**2 / 6.0
    states = position, 1.0 + times / 3.0, np.full_like(times, 1.0 / 3.0)
    pieces = hermite_pieces(times, *(state[:, None] for state in states))
    jerk = 6.0 * np.abs(pieces[:, 0, 3])
    # A rounding error of the position, over the cube of the step.
    assert 0.0 < jerk.max() < 60 * np.finfo(float).eps * position.max() * 1024**3
    np.testing.assert_array_equal(pieces[:, 0, 0], position[:-1])


def test_hermite_pieces_are_the_polynomial_they_sample() -> None:
    times = np.array([0.0, 0.4, 1.5])
    cubic = np.polynomial.Polynomial([1.0, -2.0, 0.5, 3.0])
    pieces = hermite_pieces(times, cubic(times)[:, None], cubic.deriv()(times)[:, None])
    for start, piece in zip(times, pieces[:, 0], strict=False):
        shifted = cubic(np.polynomial.Polynomial([start, 1.0]))
        np.testing.assert_allclose(piece, shifted.coef, rtol=1e-12)
