"""Proportions of durations; the total is the best feasible one, found in closed form or by a search along a line."""

from __future__ import annotations

import numpy as np

from metaheuristics import Evaluation
from ocp_traj.arrays import Array, ArrayLike
from ocp_traj.exceptions import InputError, UnavailableError
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.condensed.batch import CurveBatch
from ocp_traj.transcription.condensed.encodings.durations import LogDurations
from ocp_traj.transcription.condensed.rows import CondensedRows, InstantRows, KinematicRows
from ocp_traj.transcription.condensed.scaling import Scaling
from ocp_traj.transcription.nlp import RowBlock, Symbol


class Scaled(LogDurations):
    """Only proportions count: every candidate is run at its own best feasible speed, so none needs a penalty.

    From rest to rest, slowing a motion by s divides velocity, acceleration and jerk by s, s^2, s^3 and the torque
    above gravity by s^2, so the smallest feasible s is closed form. For costs other than time the best s above it
    is found by a one-dimensional search that reuses the sampled torques.
    """

    name = "scaled"
    decides_speed = True

    def __init__(
        self,
        task: TrajectoryTask,
        rows: CondensedRows,
        bounds: ArrayLike | None = None,
        offsets: str = "spline",
    ) -> None:
        super().__init__(task, rows, bounds, offsets)
        if not task.boundary.is_rest:
            raise InputError(
                "the scaled encoding needs a motion from rest to rest, expected encoding 'durations'"
            )
        self.scaling = Scaling(task, rows)

    def symbolic_durations(self, x: Symbol) -> Symbol:
        """Refuse; see `Encoding.symbolic_durations`."""
        raise UnavailableError(
            "the scaled encoding has no symbols: its total duration is a maximum over all limits; "
            "expected encoding 'durations' or 'log-durations'"
        )

    @property
    def entries(self) -> list[KinematicRows | InstantRows]:
        """The limits that no scaling can mend: positions."""
        return [entry for entry in self.rows.kinematic if entry.limit.order == 0]

    @property
    def singles(self) -> list[tuple[float, float, RowBlock]]:
        """The rows of what exceeds limits at rest, and of durations."""
        stuck = RowBlock("limits at rest", np.array([-1]), np.array([0]), np.array([0.0]))
        return [(-np.inf, 0.0, stuck), *super().singles]

    def scale(self, curves: CurveBatch) -> Array:
        """Return the best feasible scale of every candidate, (p,)."""
        return self.scaling.best(curves, self.rows.samples(curves))[0]

    def distance(self, x: Array, y: Array) -> float:
        """Return how far two candidates are apart; only the proportions of their durations count."""
        difference = x - y
        difference[: self.task.gaps] -= difference[: self.task.gaps].mean()
        return super().distance(difference, np.zeros_like(y))

    def evaluate(self, curves: CurveBatch) -> Evaluation:
        """Return cost and violation at every candidate's best scale."""
        samples = self.rows.samples(curves)
        scale, cost, stuck = self.scaling.best(curves, samples)
        rest = np.concatenate([stuck[None], self.duration_violation(curves.h * scale)])
        return Evaluation(cost, self.violation(samples, rest))
