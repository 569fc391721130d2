"""The constraint rows and cost terms of the condensed form, for a population at once.

Every block of rows is an array of values (k values, N points, S segments, p candidates) with bounds (k, S); the
symbolic form lists the same values in the same order (value, point, segment).
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.costs import SQUARED_DERIVATIVES, InstantCost, SquaredDerivative, instant_costs
from ocp_traj.exceptions import InputError
from ocp_traj.limits import DERIVATIVE_LIMITS, DerivativeLimit, InstantLimit, instant_limits
from ocp_traj.limits.limit import bound_scales, finite_joints
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.condensed.batch import CurveBatch
from ocp_traj.transcription.condensed.exact_rows import largest_ratio, write_exact, write_positions
from ocp_traj.transcription.condensed.extrema import LARGEST_DEGREE
from ocp_traj.transcription.condensed.limit_rows import LimitRows
from ocp_traj.transcription.condensed.samples import Buffers, Samples
from ocp_traj.transcription.quadrature import even_intervals, gauss_legendre, simpson_weights


class _ThreadBuffers(threading.local):
    def __init__(self) -> None:
        self.buffers = Buffers()


_BUFFERS = _ThreadBuffers()


@dataclass(frozen=True)
class KinematicRows:
    """One derivative limit: exact extrema where the degree allows, samples elsewhere."""

    limit: DerivativeLimit
    block: LimitRows
    exact: bool

    def write(self, samples: Samples, out: Array) -> None:
        """Write the violations (k, N, S, p)."""
        if self.exact:
            write_exact(samples.curves, self.limit.order, self.block, out)
        elif self.limit.order == 0:
            write_positions(samples.curves, self.block, out)
        else:
            values = samples.motion(self.limit.order)
            for k, joint in enumerate(self.block.joints):
                self.block.write_over(k, values[joint], out[k])

    def ratio(self, samples: Samples, floor: Array) -> Array:
        """Return the larger of `floor` (p,) and the largest value over its bound, (p,)."""
        if self.exact:
            return largest_ratio(samples.curves, self.limit.order, self.block, floor)
        values = samples.motion(self.limit.order)
        for k, joint in enumerate(self.block.joints):
            floor = np.maximum(floor, self.block.ratio(k, values[joint]))
        return floor


@dataclass(frozen=True)
class InstantRows:
    """One limit of a function of an instant (torque, torque rate, Cartesian speed, custom)."""

    limit: InstantLimit
    block: LimitRows
    function: Any = field(repr=False)

    def values(self, samples: Samples) -> Array:
        """Return the values (k, N, S, p)."""
        return self.limit.values(samples, self.function)

    def write(self, samples: Samples, out: Array) -> None:
        """Write the violations (k, N, S, p)."""
        values = self.values(samples)
        for k in range(len(values)):
            self.block.write_over(k, values[k], out[k])


@dataclass(frozen=True)
class InstantTerm:
    """One cost integrated from samples."""

    term: InstantCost
    weight: float
    function: Any = field(repr=False)


class CondensedRows:
    """All rows and cost terms of a task in the condensed form."""

    def __init__(self, task: TrajectoryTask, kinematic: list[KinematicRows], intervals: int) -> None:
        self.task, self.kinematic, self.simpson = task, kinematic, simpson_weights(intervals)
        self.fractions = grid_fractions(intervals)
        self.per_gap = task.virtual_knots + 1
        self.instants = [
            InstantRows(
                limit,
                LimitRows.of(
                    limit.name,
                    limit.joints(task),
                    np.repeat(limit.bounds(task), self.per_gap, axis=0),
                    np.repeat(limit.scales(task), self.per_gap, axis=0),
                    self.fractions,
                    self.per_gap,
                ),
                limit.function(task),
            )
            for limit in instant_limits(task)
        ]
        self.terms = [
            InstantTerm(cost, cost.weight(task), cost.function(task)) for cost in instant_costs(task)
        ]
        self.squared = [term for term in SQUARED_DERIVATIVES if term.weight(task) > 0]

    @cached_property
    def blocks(self) -> list[LimitRows]:
        """Blocks of rows in order."""
        return [*(entry.block for entry in self.kinematic), *(entry.block for entry in self.instants)]

    def samples(self, curves: CurveBatch) -> Samples:
        """Return the (lazy) samples of a population; the next call in the same thread overwrites them."""
        return Samples(self.task, curves, self.fractions, _BUFFERS.buffers)

    def term_integrand(self, term: InstantTerm, samples: Samples) -> Array:
        """Return the weighted integrand (N, S, p) of one cost term."""
        return term.weight * term.term.integrand(samples, term.function)

    def integrate(self, integrand: Array, h: Array) -> Array:
        """Integrate (N, S, p) over time with durations (S, p); returns (p,)."""
        segments = np.matmul(self.simpson, integrand.reshape(len(integrand), -1)).reshape(h.shape)
        return (segments * h).sum(axis=0)

    def squared_integral(self, term: SquaredDerivative, curves: CurveBatch) -> Array:
        """Return the weighted integral of a squared derivative, exact by Gauss-Legendre, (p,)."""
        nodes, weights = gauss_legendre(curves.degree - term.order + 1)
        values = curves.sample(term.order, tuple(nodes))
        integral: Array = np.einsum("insp,n,sp->p", values**2, weights, curves.h)
        return term.weight(self.task) * integral


def grid_fractions(intervals: int) -> tuple[float, ...]:
    """Return the points of the regular grid from 1 down to 0; see `Samples` for the order."""
    return tuple(float(fraction) for fraction in np.linspace(1.0, 0.0, intervals + 1))


def make_rows(task: TrajectoryTask, samples: int, extrema: str) -> CondensedRows:
    """Choose the rows of a task; see `CondensedNlp` for the parameters."""
    if extrema not in ("auto", "exact", "sampled"):
        raise InputError(f"extrema {extrema!r} is unknown, expected 'auto', 'exact' or 'sampled'")
    family = task.family
    if extrema == "exact" and family.degree > 5:
        raise InputError(
            f"exact extrema of {task.family} have no closed form, expected extrema 'sampled' or 'auto'"
        )
    per_gap = task.virtual_knots + 1
    intervals = even_intervals(samples, per_gap)
    kinematic = []
    for limit in DERIVATIVE_LIMITS:
        if not limit.applies(task):
            continue
        exact = extrema != "sampled" and family.degree <= 5 and family.degree - limit.order <= LARGEST_DEGREE
        joints = finite_joints(limit.bounds(task))
        bounds = np.repeat(limit.bounds(task)[:, :, joints], per_gap, axis=0)
        points = (0.0, 1.0) if exact else grid_fractions(intervals)
        kinematic.append(
            KinematicRows(
                limit, LimitRows.of(limit.name, joints, bounds, bound_scales(bounds), points, per_gap), exact
            )
        )
    return CondensedRows(task, kinematic, intervals)
