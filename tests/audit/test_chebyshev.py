"""Chebyshev series: extrema, zeros, integrals and bounds against NumPy's own routines."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import chebyshev as reference

from ocp_traj.audit.numerics import chebyshev
from ocp_traj.audit.numerics.chebyshev import DEGREE


def random_series(seed: int, rows: int = 40) -> np.ndarray:
    """Return series with decaying coefficients, some shifted far from zero."""
    rng = np.random.default_rng(seed)
    decay = rng.uniform(0.3, 1.0, (rows, 1)) ** np.arange(DEGREE + 1.0)
    series = rng.normal(size=(rows, DEGREE + 1)) * decay
    series[:, 0] += rng.choice([0.0, 3.0, -50.0], rows)
    return series


def real_roots(series: np.ndarray) -> np.ndarray:
    """Return the real roots inside (-1, 1) by the companion matrix."""
    roots = reference.chebroots(series)
    roots = roots[np.abs(roots.imag) < 1e-9].real
    return np.sort(roots[np.abs(roots) < 1.0])


@pytest.mark.parametrize("seed", range(4))
def test_extrema_are_numpys(seed: int) -> None:
    series = random_series(seed)
    row, theta = chebyshev.critical_points(series)
    values = chebyshev.evaluate(series[row], theta)
    for index, coefficients in enumerate(series):
        points = np.concatenate([real_roots(reference.chebder(coefficients)), [-1.0, 1.0]])
        expected = reference.chebval(points, coefficients)
        mine = values[row == index]
        assert mine.max() == pytest.approx(expected.max(), rel=1e-12, abs=1e-12)
        assert mine.min() == pytest.approx(expected.min(), rel=1e-12, abs=1e-12)
        inner = np.sort(np.cos(theta[(row == index) & (theta > 0) & (theta < np.pi)]))
        for point in points[:-2]:
            assert np.abs(inner - point).min() < 1e-7


@pytest.mark.parametrize("seed", range(4))
def test_zeros_are_numpys(seed: int) -> None:
    series = random_series(seed)
    row, theta = chebyshev.zeros(series)
    for index, coefficients in enumerate(series):
        mine = np.sort(np.cos(theta[row == index]))
        assert mine == pytest.approx(real_roots(coefficients), abs=1e-9)


def test_two_extrema_between_grid_points_are_found() -> None:
    # a cubic wiggle a hundredth of the grid's spacing wide, around x = 0.3
    width = 1e-4
    wiggle = np.polynomial.polynomial.polyfromroots([0.3 - width, 0.3 + width])
    series = np.zeros((1, DEGREE + 1))
    curve = reference.poly2cheb(np.polynomial.polynomial.polyint(wiggle))
    series[0, : curve.size] = curve
    _, theta = chebyshev.critical_points(series)
    for point in (0.3 - width, 0.3 + width):
        assert np.abs(np.cos(theta) - point).min() < 1e-8


@pytest.mark.parametrize("seed", range(4))
def test_enclosures_hold_and_are_tight(seed: int) -> None:
    series = random_series(seed)
    low, high, lower, upper = chebyshev.enclosures(series)
    fine = reference.chebval(np.cos(np.linspace(0, np.pi, 20_001)), series.T)
    assert (lower <= fine.min(axis=1)).all()
    assert (upper >= fine.max(axis=1)).all()
    assert (low >= fine.min(axis=1) - 1e-9).all()
    assert (high <= fine.max(axis=1) + 1e-9).all()
    span = high - low
    assert (upper - high <= 0.01 * span).all()
    assert (low - lower <= 0.01 * span).all()
    assert (upper - high >= 0.0097 * span).all()


def test_derivatives_and_integrals_are_numpys() -> None:
    series = random_series(7)
    slopes = chebyshev.differentiate(series)
    for coefficients, slope, integral in zip(series, slopes, chebyshev.integrals(series), strict=True):
        assert slope[:-1] == pytest.approx(reference.chebder(coefficients), rel=1e-12, abs=1e-12)
        assert slope[-1] == 0.0
        primitive = reference.chebint(coefficients)
        expected = reference.chebval(1.0, primitive) - reference.chebval(-1.0, primitive)
        assert integral == pytest.approx(expected, rel=1e-12, abs=1e-12)


def fitted(function: object, tolerance: float, count: int = 1) -> chebyshev.ChebyshevCurve:
    return chebyshev.fit(
        lambda pieces, x: function(pieces[:, None] + x)[..., None],  # type: ignore[operator]
        np.arange(count),
        np.zeros(count),
        np.ones(count),
        lambda largest: tolerance * largest,
    )


@pytest.mark.parametrize("count", [1, 100])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-9, 1e-12])
def test_a_smooth_curve_is_met_within_its_bound(count: int, tolerance: float) -> None:
    def wave(t: np.ndarray) -> np.ndarray:
        return np.exp(np.sin(25.0 * t)) / (1.0 + 4.0 * t)

    curve = fitted(wave, tolerance, count)
    assert curve.resolved
    assert curve.bounds.max() <= tolerance * np.e
    pieces = np.repeat(np.arange(count), 333)
    x = np.tile(np.linspace(0, 1, 333), count)
    segment, theta = curve.locate(pieces, x)
    assert np.array_equal(curve.pieces[segment], pieces)
    error = np.abs(chebyshev.evaluate(curve.coefficients[segment, 0], theta) - wave(pieces + x))
    assert (error <= curve.bounds[segment, 0] + 1e-14).all()


def test_segments_follow_one_another() -> None:
    curve = fitted(lambda t: np.abs(t - 0.3), 1e-7)
    assert curve.left[0] == 0.0
    assert curve.right[-1] == 1.0
    assert np.array_equal(curve.left[1:], curve.right[:-1])
    assert np.min(curve.right - curve.left) < 1e-5
    ends = curve.position(np.array([0, 0]), np.array([0.0, np.pi]))
    assert ends.tolist() == [curve.right[0], curve.left[0]]


def test_a_jump_is_halved_down_to_a_billionth() -> None:
    curve = fitted(lambda t: np.where(t < 0.3, 1.0, 2.0), 1e-9)
    assert curve.resolved
    wide = np.flatnonzero(curve.right - curve.left > 0.6**30)
    assert curve.bounds[wide].max() <= 2e-9
    assert np.min(curve.right - curve.left) == 0.5**30
