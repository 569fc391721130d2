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
from ocp_traj.transcription.condensed.encodings.offsets import find_offsets
from ocp_traj.transcription.condensed.rows import CondensedRows, InstantRows, KinematicRows
from ocp_traj.transcription.condensed.samples import Samples
from ocp_traj.transcription.curve import build_trajectory
from ocp_traj.transcription.duration_rows import duration_rows
from ocp_traj.transcription.nlp import RowBlock, Symbol

LARGEST_RATIO = 4.5
"""Largest ratio of a segment's duration to that of its gap's first segment in the box, and one over the smallest."""


class Encoding(ABC):
    """What the variables x of a condensed problem mean: durations of gaps, their shares, offsets of virtual knots.

    First comes one variable a gap, for its duration; with virtual knots there follow the logarithms of the ratios of
    the segments' durations to that of their gap's first segment, gap by gap, then the offsets, knot by knot.

    Parameters
    ----------
    task : TrajectoryTask
    rows : CondensedRows
        The constraint rows and cost terms of the task.
    bounds : (2,), optional
        Of the duration of a gap, s; by default the task's search box.
    offsets : str
        What positions of virtual knots are measured from: ``"spline"`` or ``"chord"``; see `Offsets`.

    Attributes
    ----------
    name : str
        In names of solvers and in results.
    decides_speed : bool
        Whether the durations are scaled to a total of the encoding's own choice.
    offsets : Offsets
    segments : int
        Number S of segments.
    lower, upper : (d,)
        The box of the variables.
    """

    name: ClassVar[str]
    decides_speed: ClassVar[bool] = False

    def __init__(
        self,
        task: TrajectoryTask,
        rows: CondensedRows,
        bounds: ArrayLike | None = None,
        offsets: str = "spline",
    ) -> None:
        self.task, self.rows = task, rows
        self.sums = duration_rows(task)
        self.per_gap = task.virtual_knots + 1
        self.segments = task.gaps * self.per_gap
        self.offsets = find_offsets(offsets)(task)
        self.unit = self.offsets.unit
        low, high = np.asarray(task.search.duration if bounds is None else bounds)
        beside = np.concatenate(
            [
                np.full(self.segments - task.gaps, np.log(LARGEST_RATIO)),
                np.full(self.unit.size, self.offsets.half_width),
            ]
        )
        self.lower = np.concatenate([self.from_durations(np.full(task.gaps, low)), -beside])
        self.upper = np.concatenate([self.from_durations(np.full(task.gaps, high)), beside])

    def __str__(self) -> str:
        """Return the name."""
        return self.name

    @property
    def measured_from(self) -> dict[str, Any] | None:
        """What offsets are measured ``from`` and the half-width of their ``box``, in units; None without offsets."""
        if not self.unit.size:
            return None
        own = type(self).anchors is not Encoding.anchors
        return {"from": "own" if own else self.offsets.name, "box": self.offsets.half_width}

    @abstractmethod
    def from_durations(self, durations: Array) -> Array:
        """Return the variables of the durations of gaps (G,), s; a longer duration has a larger variable."""

    @abstractmethod
    def to_durations(self, x: Array) -> Array:
        """Return the durations (p, G) of gaps, s, of the first G variables of p candidates, before any scaling."""

    def symbolic_durations(self, x: Symbol) -> Symbol:
        """Return the durations (G,) of gaps of symbols.

        Raises
        ------
        UnavailableError
            The encoding has no symbols.
        """
        raise UnavailableError(
            f"the {self.name} encoding has no symbols, expected encoding 'durations' or 'log-durations'"
        )

    def anchors(self, durations: Array) -> Array:
        """Return what offsets are measured from, (S + 1, n, 1 or p).

        Parameters
        ----------
        durations : (p, S) s
        """
        return self.offsets.anchors(durations)

    def symbolic_anchors(self, durations: Symbol) -> list[Any]:
        """Return the anchors of symbolic durations, S + 1 rows (1, n)."""
        return self.offsets.symbolic_anchors(durations)

    def durations(self, X: Array) -> Array:
        """Return the durations (p, S), s, that variables X (p, d) stand for, before any scaling."""
        gaps = self.task.gaps
        totals = self.to_durations(X[:, :gaps])
        if self.per_gap == 1:
            return totals
        parts = np.ones((len(X), gaps, self.per_gap))
        np.exp(X[:, gaps : self.segments].reshape(len(X), gaps, -1), out=parts[:, :, 1:])
        parts *= (totals / parts.sum(axis=2))[:, :, None]
        return parts.reshape(len(X), -1)

    def positions(self, X: Array) -> Array:
        """Return the positions at all knots, (S + 1, n, p or 1), rad (m)."""
        anchors = self.anchors(self.durations(X))
        if not self.unit.size:
            return anchors
        offsets = X[:, self.segments :].reshape(len(X), *self.unit.shape)
        positions = np.empty((*anchors.shape[:2], len(X)))
        positions[...] = anchors
        positions[self.offsets.knots] += offsets.transpose(1, 2, 0) * self.unit[:, :, None]
        return positions

    def symbolic_curve(self, x: Symbol) -> tuple[Symbol, list[Any]]:
        """Return the durations (S,) and the positions at all knots, S + 1 rows (1, n), of symbols (d,)."""
        gaps, n = self.task.gaps, self.task.n
        durations = self.symbolic_durations(x[:gaps])
        if self.per_gap > 1:
            ratios = ca.reshape(ca.exp(x[gaps : self.segments]), self.per_gap - 1, gaps)
            parts = ca.vertcat(ca.DM.ones(1, gaps), ratios)
            durations = ca.vec(parts * ca.repmat(durations.T / ca.sum1(parts), self.per_gap, 1))
        positions = [
            ca.DM(row) if isinstance(row, np.ndarray) else row for row in self.symbolic_anchors(durations)
        ]
        first = self.segments
        for knot, unit in zip(self.offsets.knots.tolist(), self.unit):
            positions[knot] = positions[knot] + (ca.DM(unit) * x[first : first + n]).T
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
        breakpoints, knots = np.asarray(trajectory.breakpoints), self.offsets.knots
        durations = np.diff(breakpoints)
        parts = durations.reshape(self.task.gaps, self.per_gap)
        away = trajectory(breakpoints[knots]) - self.anchors(durations[None, :])[knots, :, 0]
        offsets = np.divide(away, self.unit, out=np.zeros_like(away), where=self.unit > 0)
        shares = np.log(parts[:, 1:] / parts[:, :1])
        return np.concatenate([self.from_durations(parts.sum(axis=1)), shares.ravel(), offsets.ravel()])

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
