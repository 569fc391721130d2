"""Two-point Hermite polynomials of odd degree in normalised time tau = (t - t_k) / h in [0, 1]."""

from __future__ import annotations

from functools import lru_cache
from math import factorial

import numpy as np

from ocp_traj.arrays import Array, read_only


def falling(power: int, derivative: int) -> float:
    """Return power! / (power - derivative)!, the factor of a differentiated monomial (0 when it vanishes)."""
    return factorial(power) / factorial(power - derivative) if power >= derivative else 0.0


@lru_cache
def derivative_row(degree: int, derivative: int, tau: float) -> Array:
    """Row r with ``r @ c`` the derivative by tau, at `tau`, of the polynomial with ascending coefficients c."""
    powers = range(degree + 1)
    return read_only([falling(k, derivative) * tau ** max(k - derivative, 0) for k in powers])


@lru_cache
def hermite_matrix(degree: int) -> Array:
    """Matrix from end states to ascending coefficients, (degree + 1, degree + 1).

    The end states are q, h v, h^2 a, ... (orders 0 to (degree - 1) / 2) at tau = 0, then the same at tau = 1.
    """
    order = (degree - 1) // 2
    conditions = [derivative_row(degree, j, tau) for tau in (0.0, 1.0) for j in range(order + 1)]
    # The entries are multiples of 1 / order!; rounding to them takes away the inversion's error.
    unit = factorial(order)
    return read_only(np.round(np.linalg.inv(np.stack(conditions)) * unit) / unit)


def hermite_pieces(times: Array, *states: Array) -> Array:
    """Return the pieces with given derivatives at every time: cubics through q, v; quintics through q, v, a.

    Parameters
    ----------
    times : (N,)
        Increasing, s.
    *states : (N, n) each
        Position and its derivatives there, in ascending order.

    Returns
    -------
    (N - 1, n, degree + 1)
        Ascending coefficients of the time since each piece's start; the degree is 2 len(states) - 1.
    """
    h = np.diff(times)[:, None]
    ends = [[state[side] * h**order for order, state in enumerate(states)] for side in (slice(-1), slice(1, None))]
    # Positions are taken from each piece's start: a short piece would lose the digits of its travel.
    ends[0][0], ends[1][0] = np.zeros_like(ends[0][0]), np.diff(states[0], axis=0)
    coefficients = np.stack([*ends[0], *ends[1]], axis=2) @ hermite_matrix(2 * len(states) - 1).T
    coefficients[:, :, 0] = states[0][:-1]
    return np.asarray(coefficients / h[:, :, None] ** np.arange(2 * len(states)))


@lru_cache
def end_derivative_weights(degree: int, derivative: int, tau: float) -> Array:
    """Weights (2, order + 1) of the end states in a derivative by tau at `tau` (0 or 1)."""
    order = (degree - 1) // 2
    return read_only((derivative_row(degree, derivative, tau) @ hermite_matrix(degree)).reshape(2, order + 1))
