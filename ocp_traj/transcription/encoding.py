"""What the variables of a condensed problem mean: durations, their logarithms, or proportions only."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from metaheuristics import Evaluation
from ocp_traj.arrays import Array
from ocp_traj.constraints.cartesian_speed import CartesianSpeedLimit
from ocp_traj.constraints.torque import TorqueLimit
from ocp_traj.exceptions import InputError
from ocp_traj.nlp import RowBlock
from ocp_traj.transcription.batch import CurveBatch
from ocp_traj.transcription.rows import CondensedRows, Samples
from ocp_traj.transcription.scaling import Scaling

if TYPE_CHECKING:
    from ocp_traj.transcription.condensed import CondensedNlp


class Durations:
    """x holds the durations themselves, s; every limit is a constraint row."""

    def __init__(self, nlp: CondensedNlp) -> None:
        from ocp_traj.transcription.condensed import duration_rows

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
        lower = [np.broadcast_to(block.lower[:, None, :], block.shape).ravel() for block in self.rows.blocks]
        upper = [np.broadcast_to(block.upper[:, None, :], block.shape).ravel() for block in self.rows.blocks]
        return (
            np.concatenate([*lower, [row[2] for row in self.sums]]),
            np.concatenate([*upper, [row[3] for row in self.sums]]),
        )

    def labels(self) -> list[RowBlock]:
        """Return the labels of the rows."""
        return [*[block.row_block() for block in self.rows.blocks], *[row[4] for row in self.sums]]

    def scale(self, curves: CurveBatch) -> Array:
        """Return the factor on the durations, (p,)."""
        return np.ones(curves.durations.shape[0])

    def evaluate(self, curves: CurveBatch) -> Evaluation:
        """Return cost and violation of a population."""
        samples = self.rows.samples(curves)
        return Evaluation(self._cost(curves, samples), self._violation(curves, samples))

    def _cost(self, curves: CurveBatch, samples: Samples) -> Array:
        cost = self.task.objective.time * curves.durations.sum(axis=1)
        for term in self.rows.squared:
            cost = cost + self.rows.squared_integral(term, curves)
        for instant in self.rows.terms:
            cost = cost + self.rows.integrate(self.rows.term_integrand(instant, samples), curves.durations)
        return cost

    def _violation(self, curves: CurveBatch, samples: Samples) -> Array:
        p = curves.durations.shape[0]
        blocks = self.rows.blocks
        violation = np.empty((p, sum(int(np.prod(block.shape)) for block in blocks) + len(self.sums)))
        offset = 0
        values = [
            *(rows.values(curves) for rows in self.rows.kinematic),
            *(self.rows.instant_values(rows, samples) for rows in self.rows.instants),
        ]
        for block, value in zip(blocks, values):
            size = int(np.prod(block.shape))
            target = violation[:, offset : offset + size].reshape(p, *block.shape)
            target[...] = np.moveaxis(block.over(value), 2, 0)
            offset += size
        violation[:, offset:] = duration_violation(self.sums, curves.durations)
        return violation


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
        for rows in self.rows.instants:
            if not isinstance(rows.constraint, TorqueLimit | CartesianSpeedLimit):
                raise InputError(
                    f"the scaled encoding does not know how {rows.constraint.name} scales, expected encoding 'durations'"
                )
        self.scaling = Scaling(nlp.task, self.rows)

    def bounds(self) -> tuple[Array, Array]:
        """Return bounds of the rows that scaling cannot mend: positions, gravity, durations."""
        blocks = self.scaling.position_blocks
        lower = [np.broadcast_to(block.lower[:, None, :], block.shape).ravel() for block in blocks]
        upper = [np.broadcast_to(block.upper[:, None, :], block.shape).ravel() for block in blocks]
        rest = np.zeros(1 + len(self.sums))
        return np.concatenate([*lower, np.full_like(rest, -np.inf)]), np.concatenate([*upper, rest])

    def labels(self) -> list[RowBlock]:
        """Return the labels of the rows."""
        gravity = RowBlock("torque of gravity", np.array([-1]), np.array([0]), np.array([0.0]))
        return [
            *[block.row_block() for block in self.scaling.position_blocks],
            gravity,
            *[row[4] for row in self.sums],
        ]

    def scale(self, curves: CurveBatch) -> Array:
        """Return the best feasible scale of every candidate, (p,)."""
        return self.scaling.best(curves, self.rows.samples(curves))[0]

    def evaluate(self, curves: CurveBatch) -> Evaluation:
        """Return cost and violation at every candidate's best scale."""
        samples = self.rows.samples(curves)
        scale, cost, gravity = self.scaling.best(curves, samples)
        p = len(scale)
        parts = []
        for rows in self.rows.kinematic:
            if rows.limit.order == 0:
                parts.append(np.moveaxis(rows.block.over(rows.values(curves)), 2, 0).reshape(p, -1))
        parts += [gravity[:, None], duration_violation(self.sums, curves.durations * scale[:, None])]
        return Evaluation(cost, np.concatenate(parts, axis=1))


def duration_violation(sums: list[Any], durations: Array) -> Array:
    """Return how far every bounded sum of durations (p, S) is outside its bounds, (p, rows)."""
    violation = np.zeros((len(durations), len(sums)))
    for index, (segments, scale, lower, upper, _) in enumerate(sums):
        value = durations[:, segments].sum(axis=1) / scale
        violation[:, index] = np.maximum(np.maximum(value - upper, lower - value), 0.0)
    return violation


ENCODINGS: dict[str, type[Durations]] = {
    "durations": Durations,
    "log-durations": LogDurations,
    "scaled": Scaled,
}
"""Encodings by name; a new one is a class above and a line here."""
