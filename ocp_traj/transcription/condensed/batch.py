"""A whole population of curves at once: durations to splines, and splines to samples, in NumPy.

Arrays run over joints first and candidates last, (n, ..., S segments, p candidates): one matrix product a joint
samples all segments of all candidates, every joint's samples are one contiguous block, and inverse dynamics takes
those blocks as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import comb

import numpy as np

from ocp_traj.arrays import Array, read_only
from ocp_traj.spline import EndConditions
from ocp_traj.spline.hermite import derivative_row, falling, hermite_matrix
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.condensed.knot_derivatives import knot_derivatives
from ocp_traj.transcription.curve import end_conditions, pieces_through


@dataclass(frozen=True)
class CurveBatch:
    """Curves of p candidates.

    Attributes
    ----------
    h : (S, p) durations of the segments, s
    states : (n, degree + 1, S, p)
        Scaled end states q, h v, h^2 a, ... at the start, then at the end of every segment.
    degrees : tuple of S int
        Degree of each segment; a cubic among quintics is held as the quintic it also is.
    """

    h: Array
    states: Array
    degrees: tuple[int, ...]

    @property
    def degree(self) -> int:
        """Degree of the states."""
        return int(self.states.shape[1]) - 1

    @cached_property
    def inverse_powers(self) -> list[Array]:
        """1, 1 / h, 1 / h^2, 1 / h^3; each (S, p)."""
        inverse = 1.0 / self.h
        return [np.ones_like(self.h), inverse, inverse * inverse, inverse * inverse * inverse]

    @cached_property
    def rise(self) -> Array:
        """The states with positions measured from the segment's start, for derivatives.

        A joint that stands still then has derivatives of exactly 0, whose sign friction asks for.
        """
        rise: Array = self.states.copy()
        rise[:, self.states.shape[1] // 2] -= self.states[:, 0]
        rise[:, 0] = 0.0
        return rise

    @cached_property
    def slopes(self) -> Array:
        """Ascending coefficients of the derivative by tau, (n, degree, S, p)."""
        return _combine(power_rows(self.degree, 1, self.degree + 1), self.rise)

    def sample(self, order: int, fractions: tuple[float, ...], out: Array | None = None) -> Array:
        """Return a derivative at `fractions` of every segment, (n, N, S, p)."""
        states = self.rise * self.inverse_powers[order] if order else self.states
        return _combine(sample_rows(self.degree, order, fractions), states, out)

    def positions(self, fractions: Array) -> Array:
        """Return positions at fractions (k, S, p) of its own of every segment of every candidate, (n, k, S, p)."""
        coefficients = self.coefficients(0)[:, :, None]
        values: Array = np.broadcast_to(coefficients[:, -1], (len(coefficients), *fractions.shape)).copy()
        for power in reversed(range(self.degree)):
            values *= fractions
            values += coefficients[:, power]
        return values

    def coefficients(self, order: int) -> Array:
        """Return the ascending coefficients of derivative `order` by tau, (n, degree + 1 - order, S, p)."""
        if order == 0:
            return _combine(power_rows(self.degree, 0, self.degree + 1), self.states)
        if order == 1:
            return self.slopes
        factors = [falling(power, order) / power for power in range(order, self.degree + 1)]
        return self.slopes[:, order - 1 :] * np.array(factors)[:, None, None]


def _combine(rows: Array, states: Array, out: Array | None = None) -> Array:
    """Return rows (N, degree + 1) times states (n, degree + 1, S, p), (n, N, S, p)."""
    n, _, segments, p = states.shape
    out = np.empty((n, len(rows), segments, p)) if out is None else out
    np.matmul(rows, states.reshape(n, -1, segments * p), out=out.reshape(n, -1, segments * p))
    return out


def hull(curves: CurveBatch) -> Array:
    """Return the Bernstein coefficients of the positions, (n, degree + 1, S, p)."""
    return _combine(bernstein_rows(curves.degree, 0), curves.states)


@lru_cache
def power_rows(degree: int, order: int, terms: int) -> Array:
    """Return the matrix from scaled end states to ascending coefficients of a derivative by tau.

    Only the first `terms` coefficients of the polynomial itself are kept; a cubic held as a quintic has four.
    """
    matrix = hermite_matrix(degree)[order:terms]
    factors = np.array([falling(power, order) for power in range(order, terms)])
    return read_only(matrix * factors[:, None])


@lru_cache
def bernstein_change(degree: int) -> Array:
    """Return the matrix from ascending coefficients to Bernstein coefficients of one degree."""
    rows = range(degree + 1)
    return read_only([[comb(i, k) / comb(degree, k) for k in rows] for i in rows])


@lru_cache
def bernstein_rows(degree: int, order: int) -> Array:
    """Return the matrix from scaled end states to the Bernstein coefficients of a derivative by tau."""
    return read_only(bernstein_change(degree - order) @ power_rows(degree, order, degree + 1))


@lru_cache
def sample_rows(degree: int, order: int, fractions: tuple[float, ...]) -> Array:
    """Return the (N, degree + 1) matrix from scaled end states to derivatives by tau at `fractions`."""
    rows = np.stack([derivative_row(degree, order, fraction) for fraction in fractions])
    return read_only(rows @ hermite_matrix(degree))


@lru_cache
def elevation_matrix(low: int, high: int) -> Array:
    """Return the matrix from the scaled end states of degree `low` to those of degree `high`."""
    order = (high - 1) // 2
    rows = [derivative_row(low, j, tau) for tau in (0.0, 1.0) for j in range(order + 1)]
    return read_only(np.stack(rows) @ hermite_matrix(low))


def build_curves(task: TrajectoryTask, durations: Array, positions: Array) -> CurveBatch:
    """Return the curves of p candidates.

    Parameters
    ----------
    durations : (p, S) s
    positions : (S + 1, n, p or 1) rad (m)
        At all knots; those that the end conditions decide are ignored.
    """
    family, h = task.family, np.ascontiguousarray(durations.T)
    given = end_conditions(task)
    start, end = ({j: value.T for j, value in side.items()} for side in (given.start, given.end))
    part = family.spline_part(h, positions, EndConditions(start, end))
    if part is None or max(*part.ends.start, *part.ends.end) > (family.degree - 1) // 2:
        return _curves_of_pieces(task, h, positions)
    outside = part.outside
    inner = slice(outside, len(h) - outside)
    knots = slice(outside, len(h) + 1 - outside)
    derivatives = knot_derivatives(family.degree, h[inner], positions[knots], part.ends.start, part.ends.end)
    if outside:
        found = derivatives
        derivatives = np.empty((len(found), len(h) + 1, *found.shape[2:]))
        derivatives[:, knots] = found
        for j in range(1, len(found) + 1):
            derivatives[j - 1, 0], derivatives[j - 1, -1] = start[j], end[j]
    return CurveBatch(h, _uniform_states(family.degree, h, positions, derivatives), family.degrees(len(h)))


def _uniform_states(degree: int, h: Array, positions: Array, derivatives: Array) -> Array:
    order, segments = derivatives.shape[0], len(h)
    states = np.empty((positions.shape[1], 2 * order + 2, *h.shape))
    for side in (0, 1):
        knots = slice(side, segments + side)
        first = side * (order + 1)
        states[:, first] = positions[knots].transpose(1, 0, 2)
        power = h
        for j in range(1, order + 1):
            np.multiply(derivatives[j - 1, knots].transpose(1, 0, 2), power, out=states[:, first + j])
            power = power * h
    return states


def _curves_of_pieces(task: TrajectoryTask, h: Array, positions: Array) -> CurveBatch:
    """Return the curves of any family from its own pieces."""
    family = task.family
    columns, knots = [row[:, None] for row in h], [row.T for row in positions]
    pieces = pieces_through(task, columns, knots, end_conditions(task))
    states = np.empty((task.n, family.degree + 1, *h.shape))
    for segment, piece in enumerate(pieces):
        own = np.stack([np.broadcast_to(state, (h.shape[1], task.n)) for state in piece.states])
        if piece.degree < family.degree:
            own = np.tensordot(elevation_matrix(piece.degree, family.degree), own, 1)
        states[:, :, segment] = own.transpose(2, 0, 1)
    return CurveBatch(h, states, tuple(piece.degree for piece in pieces))
