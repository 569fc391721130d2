"""What an encoding is: how variables, durations and virtual knots follow from each other, and how they are judged.

By default every limit is a constraint row.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from metaheuristics import Evaluation
from ocp_traj.arrays import Array, ArrayLike
from ocp_traj.exceptions import UnavailableError
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.condensed.batch import CurveBatch, build_curves
from ocp_traj.transcription.condensed.rows import CondensedRows, InstantRows, KinematicRows
from ocp_traj.transcription.condensed.samples import Samples
from ocp_traj.transcription.curve import build_trajectory
from ocp_traj.transcription.duration_rows import duration_rows
from ocp_traj.transcription.nlp import RowBlock, Symbol


class Encoding(ABC):
    """What the variables x of a condensed problem mean: S that give the durations, then the offsets of virtual knots.

    An offset is one joint's distance of one virtual knot from its anchor, in units of half the joint's travel, in
    [-1, 1]; what it says where the end conditions decide the position is ignored.

    Parameters
    ----------
    task : TrajectoryTask
    rows : CondensedRows
        The constraint rows and cost terms of the task.
    bounds : (2,), optional
        Of the duration of a gap, s; by default the task's search box.

    Attributes
    ----------
    name : str
        In names of solvers and in results.
    decides_speed : bool
        Whether the durations are scaled to a total of the encoding's own choice.
    lower, upper : (d,)
        The box of the variables.
    """

    name: ClassVar[str]
    decides_speed: ClassVar[bool] = False

    def __init__(self, task: TrajectoryTask, rows: CondensedRows, bounds: ArrayLike | None = None) -> None:
        self.task, self.rows = task, rows
        self.sums = duration_rows(task)
        per_gap = task.virtual_knots + 1
        self.segments = task.gaps * per_gap
        knots = np.arange(self.segments + 1)
        self.virtual = knots[knots % per_gap > 0]
        self.unit = np.ptp(task.waypoints, axis=0) / 2
        self.chord = np.repeat(task.waypoints, per_gap, axis=0)[: self.segments + 1]
        rise = np.repeat(np.diff(task.waypoints, axis=0), per_gap, axis=0)
        self.chord[:-1] += rise * (knots[:-1, None] % per_gap / per_gap)
        offsets = np.ones(self.virtual.size * task.n)
        low, high = np.asarray(task.search.duration if bounds is None else bounds) / per_gap
        self.lower = np.concatenate([self.from_durations(np.full(self.segments, low)), -offsets])
        self.upper = np.concatenate([self.from_durations(np.full(self.segments, high)), offsets])

    def __str__(self) -> str:
        """Return the name."""
        return self.name

    @abstractmethod
    def from_durations(self, durations: Array) -> Array:
        """Return the variables of durations (S,), s; a longer duration has a larger variable."""

    @abstractmethod
    def to_durations(self, x: Array) -> Array:
        """Return the durations (p, S), s, of the first S variables of p candidates, before any scaling."""

    def symbolic_durations(self, x: Symbol) -> Symbol:
        """Return the durations (S,) of symbols.

        Raises
        ------
        UnavailableError
            The encoding has no symbols.
        """
        raise UnavailableError(
            f"the {self.name} encoding has no symbols, expected encoding 'durations' or 'log-durations'"
        )

    def anchors(self, durations: Array) -> Array:
        """Return what offsets are measured from, (S + 1, n, 1 or p): the chord between the waypoints, evenly divided.

        Parameters
        ----------
        durations : (p, S) s
        """
        return self.chord[:, :, None]

    def symbolic_anchors(self, durations: Symbol) -> list[Any]:
        """Return the anchors of symbolic durations, S + 1 rows (1, n)."""
        return [row[None, :] for row in self.chord]

    def durations(self, X: Array) -> Array:
        """Return the durations (p, S), s, that variables X (p, d) stand for, before any scaling."""
        return self.to_durations(X[:, : self.segments])

    def positions(self, X: Array) -> Array:
        """Return the positions at all knots, (S + 1, n, p or 1), rad (m)."""
        anchors = self.anchors(self.durations(X))
        if not self.virtual.size:
            return anchors
        offsets = X[:, self.segments :].reshape(len(X), self.virtual.size, self.task.n)
        positions = np.empty((*anchors.shape[:2], len(X)))
        positions[...] = anchors
        positions[self.virtual] += offsets.transpose(1, 2, 0) * self.unit[:, None]
        return positions

    def symbolic_curve(self, x: Symbol) -> tuple[Symbol, list[Any]]:
        """Return the durations (S,) and the positions at all knots, S + 1 rows (1, n), of symbols (d,)."""
        durations = self.symbolic_durations(x[: self.segments])
        positions = [
            ca.DM(row) if isinstance(row, np.ndarray) else row for row in self.symbolic_anchors(durations)
        ]
        first, n = self.segments, self.task.n
        for knot in self.virtual.tolist():
            positions[knot] = positions[knot] + (ca.DM(self.unit) * x[first : first + n]).T
            first += n
        return durations, positions

    def curves(self, X: Array) -> CurveBatch:
        """Return the curves of candidates X (p, d), before any scaling."""
        return build_curves(self.task, self.durations(X), self.positions(X))

    def decode(self, x: Array) -> Trajectory:
        """Return the exact trajectory that variables x (d,) stand for."""
        X = np.asarray(x, dtype=np.float64)[None, :]
        curves = self.curves(X)
        durations = curves.h[:, 0] * self.scale(curves)[0]
        return build_trajectory(self.task, durations, self.positions(X)[:, :, 0])

    def encode(self, trajectory: Trajectory) -> Array:
        """Return the variables of a motion of this family with the same number of knots (not clipped)."""
        breakpoints = np.asarray(trajectory.breakpoints)
        durations = np.diff(breakpoints)
        anchors = self.anchors(durations[None, :])[self.virtual, :, 0]
        away = trajectory(breakpoints[self.virtual]) - anchors
        offsets = np.divide(away, self.unit, out=np.zeros_like(away), where=self.unit > 0)
        return np.concatenate([self.from_durations(durations), offsets.ravel()])

    def distance(self, x: Array, y: Array) -> float:
        """Return how far two candidates are apart: the mean difference of their variables, in widths of the box."""
        difference, width = x - y, self.upper - self.lower
        share = np.divide(difference, width, out=np.zeros_like(difference), where=width > 0)
        return float(np.abs(share).mean())

    @property
    def entries(self) -> list[KinematicRows | InstantRows]:
        """The limits that are constraint rows."""
        return [*self.rows.kinematic, *self.rows.instants]

    @property
    def singles(self) -> list[tuple[float, float, RowBlock]]:
        """Lower bound, upper bound and label of each row that comes after those of the limits."""
        return [(row.lower, row.upper, row.label) for row in self.sums]

    def bounds(self) -> tuple[Array, Array]:
        """Return lower and upper bounds of the rows g, (m,) each."""
        sides = [entry.block.row_bounds() for entry in self.entries]
        lower, upper = ([single[side] for single in self.singles] for side in (0, 1))
        return np.concatenate([*(low for low, _ in sides), lower]), np.concatenate(
            [*(high for _, high in sides), upper]
        )

    def labels(self) -> list[RowBlock]:
        """Return the labels of the rows."""
        return [*(entry.block.row_block() for entry in self.entries), *(label for *_, label in self.singles)]

    def evaluate(self, curves: CurveBatch) -> Evaluation:
        """Return cost and violation of the curves of a population."""
        samples = self.rows.samples(curves)
        cost: Array = self.task.objective.time * curves.h.sum(axis=0)
        for term in self.rows.squared:
            cost = cost + self.rows.squared_integral(term, curves)
        for instant in self.rows.terms:
            cost = cost + self.rows.integrate(self.rows.term_integrand(instant, samples), curves.h)
        return Evaluation(cost, self.violation(samples, self.duration_violation(curves.h)))

    def scale(self, curves: CurveBatch) -> Array:
        """Return the factor on the durations, (p,)."""
        return np.ones(curves.h.shape[1])

    def duration_violation(self, h: Array) -> Array:
        """Return how far every bounded sum of durations h (S, p) is outside its bounds, (rows, p)."""
        violation = np.zeros((len(self.sums), h.shape[1]))
        for index, row in enumerate(self.sums):
            value = h[row.segments].sum(axis=0) / row.scale
            violation[index] = np.maximum(np.maximum(value - row.upper, row.lower - value), 0.0)
        return violation

    def violation(self, samples: Samples, rest: Array) -> Array:
        """Return the violations (p, m) of the limits that are rows, followed by ready ones `rest` (rows, p).

        Candidates lie next to each other in memory, as everywhere below.
        """
        entries, p = self.entries, samples.curves.h.shape[1]
        sizes = [entry.block.size for entry in entries]
        violation = np.empty((sum(sizes) + len(rest), p))
        start = 0
        for entry, size in zip(entries, sizes):
            entry.write(samples, violation[start : start + size].reshape(*entry.block.shape, p))
            start += size
        violation[start:] = rest
        return violation.T
