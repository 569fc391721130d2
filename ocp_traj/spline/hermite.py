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


@lru_cache
def end_derivative_weights(degree: int, derivative: int, tau: float) -> Array:
    """Weights (2, order + 1) of the end states in a derivative by tau at `tau` (0 or 1)."""
    order = (degree - 1) // 2
    return read_only((derivative_row(degree, derivative, tau) @ hermite_matrix(degree)).reshape(2, order + 1))
