"""Closed-form extrema on [0, 1] against numeric roots, flat, tangent and degenerate polynomials included."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from ocp_traj.transcription.condensed.extrema import ArrayOperations, SymbolicOperations, extremes

SPECIAL = [
    [1.0, 0.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, -1.0, 0.0, 0.0],
    [0.0, 0.0, 0.0, 0.0, 1.0],
    [0.0, 0.0, 1.0, -2.0, 1.0],
    [0.0, 1.0, -1.0, 1e-14, 0.0],
    [0.0, 1.0, -1.0, 1e-6, 1e-7],
    [0.0, 1.0, -3.0, 3.0, -1.0],
    [0.1, -0.4, 0.6, -0.4, 0.1],
    [0.0, 1e8, -1e8, 3e7, -2e7],
    [0.0, 1e-9, -1e-9, 0.0, 2e-9],
]


def brute_force(coefficients: np.ndarray) -> tuple[float, float]:
    polynomial = np.polynomial.Polynomial(coefficients)
    roots = polynomial.deriv().roots() if np.any(coefficients[1:]) else np.empty(0)
    inside = [
        float(root.real) for root in np.atleast_1d(roots) if abs(root.imag) < 1e-6 and 0 < root.real < 1
    ]
    values = polynomial(np.array([0.0, 1.0, *inside, *np.linspace(0.0, 1.0, 401)]))
    return float(values.max()), float(values.min())


def polynomials(degree: int) -> np.ndarray:
    rng = np.random.default_rng(degree)
    drawn = rng.standard_normal((400, degree + 1)) * 10.0 ** rng.integers(-3, 4, (400, degree + 1))
    special = [row[: degree + 1] for row in SPECIAL if not any(row[degree + 1 :])]
    return np.array([*drawn, *special])


@pytest.mark.parametrize("degree", [0, 1, 2, 3, 4])
def test_arrays_find_the_largest_and_the_smallest_value(degree: int) -> None:
    rows = polynomials(degree)
    largest, smallest = extremes(rows.T, ArrayOperations())
    for row, high, low in zip(rows, largest, smallest):
        expected_high, expected_low = brute_force(row)
        size = max(np.abs(row).max(), 1e-300)
        assert abs(high - expected_high) < 1e-9 * size
        assert abs(low - expected_low) < 1e-9 * size


@pytest.mark.parametrize("degree", [0, 1, 2, 3, 4])
def test_symbols_say_what_arrays_say(degree: int) -> None:
    rows = polynomials(degree)
    symbols = [ca.SX.sym(f"c{power}") for power in range(degree + 1)]
    function = ca.Function("extremes", symbols, list(extremes(symbols, SymbolicOperations())))
    largest, smallest = extremes(rows.T, ArrayOperations())
    for row, high, low in zip(rows, largest, smallest):
        size = max(np.abs(row).max(), 1e-300)
        values = np.array([float(value) for value in function(*row)])
        np.testing.assert_allclose(values / size, np.array([high, low]) / size, atol=1e-12)


def test_a_degree_without_closed_form_is_refused() -> None:
    with pytest.raises(ValueError, match="closed form of degree 4 asked for, expected at most 3"):
        extremes(np.ones((6, 1)), ArrayOperations())
