"""Unconstrained classics with a known optimum, shifted and rotated at will."""

from __future__ import annotations

import math
from abc import abstractmethod

import numpy as np
import numpy.typing as npt

from metaheuristics.arrays import FloatArray, freeze
from metaheuristics.evaluation import Evaluation
from metaheuristics.problem import Problem


class StandardProblem(Problem):
    """A classic f(R (x - shift)) with its least value 0 at x = shift.

    Parameters
    ----------
    dimension
        Number of variables d.
    half_width
        The box is +- this in every variable.
    shift
        (d,) place of the optimum, the origin by default.
    rotation
        (d, d) orthogonal matrix R, the identity by default; see `draw_rotation`.

    Raises
    ------
    ValueError
        If the shift is outside the box, or a shape does not fit.
    """

    def __init__(
        self,
        dimension: int,
        *,
        half_width: float,
        shift: npt.ArrayLike | None = None,
        rotation: npt.ArrayLike | None = None,
    ) -> None:
        edge = np.full(dimension, half_width)
        super().__init__(f"{type(self).__name__.lower()}-{dimension}", -edge, edge)
        self.optimum = freeze(np.zeros(dimension) if shift is None else shift)
        self.rotation = None if rotation is None else freeze(rotation)
        if self.optimum.shape != (dimension,) or (np.abs(self.optimum) > half_width).any():
            raise ValueError(f"The shift is {self.optimum}, expected ({dimension},) inside +-{half_width}.")
        if self.rotation is not None and self.rotation.shape != (dimension, dimension):
            raise ValueError(
                f"The rotation has shape {self.rotation.shape}, expected {(dimension, dimension)}."
            )

    def evaluate(self, X: FloatArray) -> Evaluation:
        """Return the costs of X (p, d); see `Problem.evaluate`."""
        moved = X - self.optimum
        if self.rotation is not None:
            # Not a matrix product of BLAS: its rounding depends on how many candidates come at once.
            moved = np.einsum("pj,ij->pi", moved, self.rotation)
        return Evaluation(self.compute(moved))

    @abstractmethod
    def compute(self, z: FloatArray) -> FloatArray:
        """Return f (p,) at the points z (p, d) relative to the optimum, 0 at z = 0."""


class Sphere(StandardProblem):
    """Sum of z_j^2."""

    def compute(self, z: FloatArray) -> FloatArray:
        """See `StandardProblem.compute`."""
        return (z * z).sum(axis=1)


class Ellipsoid(StandardProblem):
    """Sum of 10^(6 (j - 1) / (d - 1)) z_j^2: condition number one million."""

    def compute(self, z: FloatArray) -> FloatArray:
        """See `StandardProblem.compute`."""
        d = z.shape[1]
        return (10.0 ** (6.0 * np.arange(d) / max(d - 1, 1)) * z * z).sum(axis=1)


class Schwefel12(StandardProblem):
    """Sum over i of (z_1 + ... + z_i)^2: quadratic, not separable."""

    def compute(self, z: FloatArray) -> FloatArray:
        """See `StandardProblem.compute`."""
        return (np.cumsum(z, axis=1) ** 2).sum(axis=1)


class Rosenbrock(StandardProblem):
    """Sum of 100 (y_(j+1) - y_j^2)^2 + (1 - y_j)^2 at y = z + 1: a bent narrow valley."""

    def compute(self, z: FloatArray) -> FloatArray:
        """See `StandardProblem.compute`."""
        y = z + 1.0
        return (100.0 * (y[:, 1:] - y[:, :-1] ** 2) ** 2 + (1.0 - y[:, :-1]) ** 2).sum(axis=1)


class Rastrigin(StandardProblem):
    """Sum of z_j^2 - 10 cos(2 pi z_j) + 10: about 10^d local minima in +-5.12."""

    def compute(self, z: FloatArray) -> FloatArray:
        """See `StandardProblem.compute`."""
        return (z * z - 10.0 * np.cos(2.0 * math.pi * z) + 10.0).sum(axis=1)


class Ackley(StandardProblem):
    """20 - 20 exp(-0.2 sqrt(mean z^2)) + e - exp(mean cos 2 pi z): a funnel with ripples."""

    def compute(self, z: FloatArray) -> FloatArray:
        """See `StandardProblem.compute`."""
        radius = np.sqrt((z * z).mean(axis=1))
        ripples = np.cos(2.0 * math.pi * z).mean(axis=1)
        return 20.0 - 20.0 * np.exp(-0.2 * radius) + math.e - np.exp(ripples)


class Griewank(StandardProblem):
    """Sum z_j^2 / 4000 - product cos(z_j / sqrt j) + 1."""

    def compute(self, z: FloatArray) -> FloatArray:
        """See `StandardProblem.compute`."""
        roots = np.sqrt(np.arange(1.0, z.shape[1] + 1.0))
        return (z * z).sum(axis=1) / 4000.0 - np.cos(z / roots).prod(axis=1) + 1.0


HALF_WIDTHS: dict[type[StandardProblem], float] = {
    Sphere: 100.0,
    Ellipsoid: 100.0,
    Schwefel12: 100.0,
    Rosenbrock: 30.0,
    Rastrigin: 5.12,
    Ackley: 32.0,
    Griewank: 600.0,
}
"""The classics and the half width of the box they are usually posed in."""


def make_shifted(
    kind: type[StandardProblem], dimension: int, rng: np.random.Generator, *, rotated: bool = False
) -> StandardProblem:
    """Return a classic with its optimum drawn uniformly in the inner 80 % of its usual box.

    Parameters
    ----------
    kind
        A key of `HALF_WIDTHS`.
    dimension
        Number of variables.
    rng
        Source of the shift, one number a coordinate, and of the rotation.
    rotated
        Whether to rotate it at random as well.
    """
    half_width = HALF_WIDTHS[kind]
    shift = rng.uniform(-0.8 * half_width, 0.8 * half_width, dimension)
    rotation = draw_rotation(dimension, rng) if rotated else None
    return kind(dimension, half_width=half_width, shift=shift, rotation=rotation)


def draw_rotation(dimension: int, rng: np.random.Generator) -> FloatArray:
    """Return a random orthogonal matrix (d, d), uniform over all (Mezzadri 2007, arXiv:math-ph/0609050)."""
    q, r = np.linalg.qr(rng.standard_normal((dimension, dimension)))
    return q * np.sign(np.diagonal(r))
