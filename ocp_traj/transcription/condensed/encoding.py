"""What the variables of a condensed problem mean: durations, their logarithms, or proportions only."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from metaheuristics import Evaluation
from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.condensed.batch import CurveBatch
from ocp_traj.transcription.condensed.rows import CondensedRows
from ocp_traj.transcription.condensed.samples import Samples
from ocp_traj.transcription.condensed.scaling import Scaling
from ocp_traj.transcription.nlp import RowBlock

if TYPE_CHECKING:
    from ocp_traj.transcription.condensed.condensed import CondensedNlp


def duration_rows(task: TrajectoryTask) -> list[tuple[Any, float, float, float, RowBlock]]:
    """Return (segments, scale, lower, upper, label) of every bounded sum of durations."""
    per_gap = task.virtual_knots + 1
    every = np.arange(task.gaps * per_gap)
    intervals = [(every, np.asarray(task.objective.duration), 0)]
    for gap, interval in enumerate(np.asarray(task.objective.gap_durations)):
        intervals.append((gap * per_gap + np.arange(per_gap), interval, gap))
    rows = []
    for segments, (low, high), gap in intervals:
        if low > 0 or np.isfinite(high):
            scale = float(high if np.isfinite(high) else low)
            label = RowBlock("duration", np.array([-1]), np.array([gap]), np.array([0.0]))
            rows.append(
                (segments, scale, float(low) / scale if low > 0 else -np.inf, float(high) / scale, label)
            )
    return rows


class Durations:
    """x holds the durations themselves, s; every limit is a constraint row."""

    def __init__(self, nlp: CondensedNlp) -> None:
        self.rows: CondensedRows = nlp.rows_of
        self.task = nlp.task
        self.sums = duration_rows(nlp.task)

    def from_duration(self, durations: Any) -> Any:
        """Return the variables of durations."""
        return durations

    def to_duration(self, x: Array) -> Array:
        """Return the durations of variables."""
        return x

    def bounds(self) -> tuple[Array, Array]:
        """Return lower and upper bounds of the rows g."""
        sides = [block.row_bounds() for block in self.rows.blocks]
        return (
            np.concatenate([*(lower for lower, _ in sides), [row[2] for row in self.sums]]),
            np.concatenate([*(upper for _, upper in sides), [row[3] for row in self.sums]]),
        )

    def labels(self) -> list[RowBlock]:
        """Return the labels of the rows."""
        return [*[block.row_block() for block in self.rows.blocks], *[row[4] for row in self.sums]]

    def scale(self, curves: CurveBatch) -> Array:
        """Return the factor on the durations, (p,)."""
        return np.ones(curves.h.shape[1])

    def evaluate(self, curves: CurveBatch) -> Evaluation:
        """Return cost and violation of a population."""
        samples = self.rows.samples(curves)
        return Evaluation(self._cost(curves, samples), self._violation(curves, samples))

    def _cost(self, curves: CurveBatch, samples: Samples) -> Array:
        cost: Array = self.task.objective.time * curves.h.sum(axis=0)
        for term in self.rows.squared:
            cost = cost + self.rows.squared_integral(term, curves)
        for instant in self.rows.terms:
            cost = cost + self.rows.integrate(self.rows.term_integrand(instant, samples), curves.h)
        return cost

    def _violation(self, curves: CurveBatch, samples: Samples) -> Array:
        """Return the violations (p, m), candidates next to each other in memory as everywhere below."""
        entries = [*self.rows.kinematic, *self.rows.instants]
        return write_rows(entries, samples, duration_violation(self.sums, curves.h))


class LogDurations(Durations):
    """x holds the natural logarithms of the durations: a factor of two is the same step everywhere."""

    def from_duration(self, durations: Any) -> Any:
        """Return the variables of durations."""
        return np.log(durations)

    def to_duration(self, x: Array) -> Array:
        """Return the durations of variables."""
        return np.exp(x)


class Scaled(LogDurations):
    """Only proportions count: every candidate is run at its own best feasible speed, so none needs a penalty.

    From rest to rest, slowing a motion by s divides velocity, acceleration and jerk by s, s^2, s^3 and the torque
    above gravity by s^2, so the smallest feasible s is closed form. For costs other than time the best s above it
    is found by a one-dimensional search that reuses the sampled torques.
    """

    def __init__(self, nlp: CondensedNlp) -> None:
        super().__init__(nlp)
        if not nlp.task.boundary.is_rest:
            raise InputError(
                "the scaled encoding needs a motion from rest to rest, expected encoding 'durations'"
            )
        self.scaling = Scaling(nlp.task, self.rows)
        self.positions = [entry for entry in self.rows.kinematic if entry.limit.order == 0]

    def bounds(self) -> tuple[Array, Array]:
        """Return bounds of the rows that scaling cannot mend: positions, what exceeds at rest, durations."""
        sides = [entry.block.row_bounds() for entry in self.positions]
        lower = np.array([-np.inf, *(row[2] for row in self.sums)])
        upper = np.array([0.0, *(row[3] for row in self.sums)])
        return (
            np.concatenate([*(low for low, _ in sides), lower]),
            np.concatenate([*(high for _, high in sides), upper]),
        )

    def labels(self) -> list[RowBlock]:
        """Return the labels of the rows."""
        stuck = RowBlock("limits at rest", np.array([-1]), np.array([0]), np.array([0.0]))
        return [
            *[entry.block.row_block() for entry in self.positions],
            stuck,
            *[row[4] for row in self.sums],
        ]

    def scale(self, curves: CurveBatch) -> Array:
        """Return the best feasible scale of every candidate, (p,)."""
        return self.scaling.best(curves, self.rows.samples(curves))[0]

    def evaluate(self, curves: CurveBatch) -> Evaluation:
        """Return cost and violation at every candidate's best scale."""
        samples = self.rows.samples(curves)
        scale, cost, stuck = self.scaling.best(curves, samples)
        rest = np.concatenate([stuck[None], duration_violation(self.sums, curves.h * scale)])
        return Evaluation(cost, write_rows(self.positions, samples, rest))


def write_rows(entries: list[Any], samples: Samples, rest: Array) -> Array:
    """Return the violations (p, m) of kinematic and instant rows, followed by ready ones `rest` (rows, p)."""
    p = samples.curves.h.shape[1]
    sizes = [entry.block.size for entry in entries]
    violation = np.empty((sum(sizes) + len(rest), p))
    start = 0
    for entry, size in zip(entries, sizes):
        entry.write(samples, violation[start : start + size].reshape(*entry.block.shape, p))
        start += size
    violation[start:] = rest
    result: Array = violation.T
    return result


def duration_violation(sums: list[Any], h: Array) -> Array:
    """Return how far every bounded sum of durations (S, p) is outside its bounds, (rows, p)."""
    violation = np.zeros((len(sums), h.shape[1]))
    for index, (segments, scale, lower, upper, _) in enumerate(sums):
        value = h[segments].sum(axis=0) / scale
        violation[index] = np.maximum(np.maximum(value - upper, lower - value), 0.0)
    return violation


ENCODINGS: dict[str, type[Durations]] = {
    "durations": Durations,
    "log-durations": LogDurations,
    "scaled": Scaled,
}
"""Encodings by name; a new one is a class above and a line here."""
