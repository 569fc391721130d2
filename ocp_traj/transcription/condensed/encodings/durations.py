"""Durations themselves, or their logarithms; every limit is a constraint row."""

from __future__ import annotations

import numpy as np

from metaheuristics import Evaluation
from ocp_traj.arrays import Array
from ocp_traj.transcription.condensed.batch import CurveBatch
from ocp_traj.transcription.condensed.encodings.encoding import Encoding, write_rows
from ocp_traj.transcription.condensed.samples import Samples
from ocp_traj.transcription.nlp import RowBlock, Symbol


class Durations(Encoding):
    """x holds the durations themselves, s; every limit is a constraint row."""

    name = "durations"

    def from_durations(self, durations: Array) -> Array:
        """Return the durations."""
        return durations

    def to_durations(self, x: Array) -> Array:
        """Return the variables."""
        return x

    def symbolic_durations(self, x: Symbol) -> Symbol:
        """Return the variables."""
        return x

    def bounds(self) -> tuple[Array, Array]:
        """Return lower and upper bounds of the rows g."""
        sides = [block.row_bounds() for block in self.rows.blocks]
        return (
            np.concatenate([*(lower for lower, _ in sides), [row.lower for row in self.sums]]),
            np.concatenate([*(upper for _, upper in sides), [row.upper for row in self.sums]]),
        )

    def labels(self) -> list[RowBlock]:
        """Return the labels of the rows."""
        return [*[block.row_block() for block in self.rows.blocks], *[row.label for row in self.sums]]

    def evaluate(self, curves: CurveBatch) -> Evaluation:
        """Return cost and violation of a population."""
        samples = self.rows.samples(curves)
        entries = [*self.rows.kinematic, *self.rows.instants]
        cost = self._cost(curves, samples)
        return Evaluation(cost, write_rows(entries, samples, self.duration_violation(curves.h)))

    def _cost(self, curves: CurveBatch, samples: Samples) -> Array:
        cost: Array = self.task.objective.time * curves.h.sum(axis=0)
        for term in self.rows.squared:
            cost = cost + self.rows.squared_integral(term, curves)
        for instant in self.rows.terms:
            cost = cost + self.rows.integrate(self.rows.term_integrand(instant, samples), curves.h)
        return cost


class LogDurations(Durations):
    """x holds the natural logarithms of the durations: a factor of two is the same step everywhere."""

    name = "log-durations"

    def from_durations(self, durations: Array) -> Array:
        """Return the logarithms."""
        return np.log(durations)

    def to_durations(self, x: Array) -> Array:
        """Return the exponentials."""
        return np.exp(x)

    def symbolic_durations(self, x: Symbol) -> Symbol:
        """Return the exponentials."""
        import casadi as ca

        return ca.exp(x)
