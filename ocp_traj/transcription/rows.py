"""The constraint rows and cost terms of the condensed form, for a population at once.

Every block of rows is an array of values (S segments, N points, p candidates, k values) with bounds (S, 2, k); the
symbolic form lists the same values in the same order (segment, point, value).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.constraints import DERIVATIVE_LIMITS, DerivativeLimit, SampledConstraint
from ocp_traj.constraints.constraint import finite_joints
from ocp_traj.constraints.torque import TorqueLimit
from ocp_traj.exceptions import InputError
from ocp_traj.nlp import RowBlock
from ocp_traj.objectives import SQUARED_DERIVATIVES, SampledTerm, SquaredDerivative
from ocp_traj.objectives.energy import Energy, EnergyWithoutRegeneration
from ocp_traj.spline import get_family
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.batch import CurveBatch
from ocp_traj.transcription.extrema import ArrayOperations, extremes
from ocp_traj.transcription.samples import Instant, instant_function, instant_of

ARRAYS = ArrayOperations()


@dataclass(frozen=True)
class Block:
    """Bounds, scale and labels of the rows of one limit.

    Attributes
    ----------
    name : str
    joints : (k,) joint of each value, -1 where none
    lower, upper : (S, k) bounds divided by `scale`
    scale : (S, k)
    fractions : (N,) of the segment; for exact extrema the two rows (largest, smallest) say 0 and 1
    per_gap : int
    """

    name: str
    joints: Any
    lower: Array
    upper: Array
    scale: Array
    fractions: Array
    per_gap: int

    @classmethod
    def of(cls, name: str, joints: Any, bounds: Array, fractions: Array, per_gap: int) -> Block:
        """Build a block from (S, 2, k) bounds; the larger finite bound of each row is its scale."""
        magnitude = np.where(np.isfinite(bounds), np.abs(bounds), 0.0).max(axis=1)
        scale = np.where(magnitude > 0, magnitude, 1.0)
        return cls(
            name,
            np.asarray(joints),
            bounds[:, 0] / scale,
            bounds[:, 1] / scale,
            scale,
            np.asarray(fractions),
            per_gap,
        )

    @property
    def shape(self) -> tuple[int, int, int]:
        """(S, N, k)."""
        return self.scale.shape[0], len(self.fractions), self.scale.shape[1]

    @cached_property
    def is_symmetric(self) -> bool:
        """Whether every scaled bound is -1 and 1."""
        return bool((self.upper == 1.0).all() and (self.lower == -1.0).all())

    def over(self, values: Array) -> Array:
        """Return max(value / scale - upper, lower - value / scale, 0), (S, N, p, k); overwrites `values`."""
        np.multiply(values, (1.0 / self.scale)[:, None, None, :], out=values)
        if self.is_symmetric:
            np.absolute(values, out=values)
            values -= 1.0
        else:
            below = self.lower[:, None, None, :] - values
            values -= self.upper[:, None, None, :]
            np.maximum(values, below, out=values)
        return np.maximum(values, 0.0, out=values)

    def ratio(self, values: Array) -> Array:
        """Return each candidate's largest value over its bound on its own side, (p,); 0/0 counts as 0."""
        with np.errstate(divide="ignore", invalid="ignore"):
            scaled = values / self.scale[:, None, None, :]
            ratio = np.maximum(scaled / self.upper[:, None, None, :], scaled / self.lower[:, None, None, :])
        ratio[values == 0] = 0.0
        largest: Array = ratio.max(axis=(0, 1, 3), initial=0.0)
        return largest

    def row_block(self) -> RowBlock:
        """Return the labels, one a row."""
        segments, points, width = self.shape
        segment = np.repeat(np.arange(segments), points * width)
        fraction = np.tile(np.repeat(self.fractions, width), segments)
        inside = (segment % self.per_gap + fraction) / self.per_gap
        return RowBlock(self.name, np.tile(self.joints, segments * points), segment // self.per_gap, inside)


@dataclass(frozen=True)
class KinematicRows:
    """One derivative limit: exact extrema where the degree allows, samples elsewhere."""

    limit: DerivativeLimit
    block: Block
    exact: bool

    def values(self, curves: CurveBatch) -> Array:
        """Return the values (S, N, p, k)."""
        order, joints = self.limit.order, self.block.joints
        if not self.exact:
            values = curves.sample(order, self.block.fractions)
            return values if len(joints) == values.shape[3] else values[..., joints]
        p = curves.durations.shape[0]
        values = np.empty((curves.durations.shape[1], 2, p, len(joints)))
        for degree, segments, states in curves.groups:
            chosen = states if len(joints) == states.shape[3] else states[..., joints]
            coefficients = list(curves.coefficients(degree, segments, chosen))
            for _ in range(order):
                coefficients = [power * value for power, value in enumerate(coefficients)][1:]
            largest, smallest = extremes(coefficients, ARRAYS)
            unit = (curves.durations.T[segments] ** order)[:, :, None]
            values[segments, 0], values[segments, 1] = largest / unit, smallest / unit
        return values


@dataclass(frozen=True)
class InstantRows:
    """One constraint on functions of an instant (torque, torque rate, Cartesian speed, custom)."""

    constraint: SampledConstraint
    block: Block
    function: Any = field(repr=False)


@dataclass(frozen=True)
class InstantTerm:
    """One integrated cost term that needs torques."""

    term: SampledTerm
    weight: float
    function: Any = field(repr=False)


class Samples:
    """q, v, a, jerk and torque of a population on the regular grid, each computed when first needed.

    Arrays are (S, N, p, n) with the grid's last point of a segment repeated as the first of the next.
    """

    def __init__(self, task: TrajectoryTask, curves: CurveBatch, fractions: Array) -> None:
        self.task, self.curves, self.fractions = task, curves, fractions

    def motion(self, order: int) -> Array:
        """Return a derivative on the grid."""
        return self._motion[order]

    @cached_property
    def _motion(self) -> dict[int, Array]:
        return {order: self.curves.sample(order, self.fractions) for order in range(4)}

    @cached_property
    def torque(self) -> Array:
        """Joint torques; computed once at a knot that two segments share."""
        return self._torque(self._motion[1], self._motion[2])

    @cached_property
    def static_torque(self) -> Array:
        """Torques that hold the arm still (no friction)."""
        return self._torque(None, None)

    def _torque(self, v: Array | None, a: Array | None) -> Array:
        robot = self.task.robot
        assert robot is not None
        q = self._motion[0]
        segments, points, p, n = q.shape
        rows = self._unique(q)
        zero = np.zeros_like(rows)
        tau = robot.torque_batch(
            rows, zero if v is None else self._unique(v), zero if a is None else self._unique(a)
        )
        inner = tau[: segments * (points - 1) * p].reshape(segments, points - 1, p, n)
        last = tau[segments * (points - 1) * p :].reshape(1, p, n)
        full = np.empty(q.shape)
        full[:, :-1] = inner
        full[:-1, -1] = inner[1:, 0]
        full[-1, -1] = last[0]
        return full

    def _unique(self, values: Array) -> Array:
        """Drop the repeated knots: (S (N - 1) p + p, n)."""
        n = values.shape[3]
        return np.concatenate([values[:, :-1].reshape(-1, n), values[-1, -1].reshape(-1, n)])

    def call(self, function: Any) -> Array:
        """Evaluate a CasADi function (q, v, a, j) -> (k,) on the grid, (S, N, p, k)."""
        columns = [self._motion[order].reshape(-1, self.task.n).T for order in range(4)]
        values = np.array(function.map(columns[0].shape[1])(*columns)).T
        return values.reshape(*self._motion[0].shape[:3], -1)


class CondensedRows:
    """All rows and cost terms of a task in the condensed form."""

    def __init__(
        self, task: TrajectoryTask, kinematic: list[KinematicRows], instant: Instant, fractions: Array
    ) -> None:
        self.task, self.kinematic, self.fractions = task, kinematic, fractions
        self.per_gap = task.virtual_knots + 1
        self.instants = [
            InstantRows(
                constraint,
                Block.of(
                    constraint.name,
                    constraint.joints(task),
                    np.repeat(constraint.bounds(task), self.per_gap, axis=0),
                    fractions,
                    self.per_gap,
                ),
                instant_function(task, constraint),
            )
            for constraint in instant.constraints
        ]
        self.terms = [
            InstantTerm(term, term.weight(task), instant_function(task, term)) for term in instant.terms
        ]
        self.squared = [term for term in SQUARED_DERIVATIVES if term.weight(task) > 0]

    @property
    def blocks(self) -> list[Block]:
        """Blocks of rows in order."""
        return [*[rows.block for rows in self.kinematic], *[rows.block for rows in self.instants]]

    def samples(self, curves: CurveBatch) -> Samples:
        """Return the (lazy) samples of a population."""
        return Samples(self.task, curves, self.fractions)

    def instant_values(self, rows: InstantRows, samples: Samples) -> Array:
        """Return the values (S, N, p, k) of one constraint."""
        if isinstance(rows.constraint, TorqueLimit):
            return samples.torque[..., rows.block.joints]
        return samples.call(rows.function)

    def term_integrand(self, term: InstantTerm, samples: Samples) -> Array:
        """Return the weighted integrand (S, N, p) of one cost term."""
        if isinstance(term.term, Energy | EnergyWithoutRegeneration):
            values = samples.torque * samples.motion(1)
        else:
            values = samples.call(term.function)
        if term.term.shape == "absolute":
            np.absolute(values, out=values)
        elif term.term.shape == "positive":
            np.maximum(values, 0.0, out=values)
        integrand: Array = term.weight * values.sum(axis=3)
        return integrand

    @cached_property
    def simpson(self) -> Array:
        """Weights of Simpson's rule on a segment of unit duration, (N,)."""
        count = len(self.fractions) - 1
        weights = np.full(count + 1, 2.0)
        weights[1::2] = 4.0
        weights[[0, -1]] = 1.0
        return weights / (3 * count)

    def integrate(self, integrand: Array, durations: Array) -> Array:
        """Integrate (S, N, p) over time with durations (p, S); returns (p,)."""
        return np.einsum("snp,n,ps->p", integrand, self.simpson, durations)

    def squared_integral(self, term: SquaredDerivative, curves: CurveBatch) -> Array:
        """Return the weighted integral of a squared derivative, exact by Gauss-Legendre, (p,)."""
        degree = max(group[0] for group in curves.groups)
        nodes, weights = np.polynomial.legendre.leggauss(degree - term.order + 1)
        values = curves.sample(term.order, (nodes + 1) / 2)
        squares = (values**2).sum(axis=3)
        return term.weight(self.task) * np.einsum("snp,n,ps->p", squares, weights / 2, curves.durations)


def make_rows(task: TrajectoryTask, samples: int, extrema: str) -> CondensedRows:
    """Choose the rows of a task; see `CondensedNlp` for the parameters."""
    if extrema not in ("auto", "exact", "sampled"):
        raise InputError(f"extrema {extrema!r} is unknown, expected 'auto', 'exact' or 'sampled'")
    family = get_family(task.family)
    if extrema == "exact" and family.degree > 5:
        raise InputError(
            f"exact extrema of {task.family} have no closed form, expected extrema 'sampled' or 'auto'"
        )
    per_gap = task.virtual_knots + 1
    intervals = max(2, 2 * round(samples / (2 * per_gap)))
    fractions = np.linspace(0.0, 1.0, intervals + 1)
    kinematic = []
    for limit in DERIVATIVE_LIMITS:
        if not limit.applies(task):
            continue
        exact = extrema != "sampled" and family.degree <= 5 and limit.order > 0
        joints = finite_joints(limit.bounds(task))
        bounds = np.repeat(limit.bounds(task)[:, :, joints], per_gap, axis=0)
        points = np.array([0.0, 1.0]) if exact else fractions
        kinematic.append(KinematicRows(limit, Block.of(limit.name, joints, bounds, points, per_gap), exact))
    return CondensedRows(task, kinematic, instant_of(task), fractions)
