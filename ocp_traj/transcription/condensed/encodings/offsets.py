"""What the positions of virtual knots are measured from, and in which units."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError
from ocp_traj.quantities import RATES
from ocp_traj.spline import EndConditions
from ocp_traj.task import Boundary, TrajectoryTask
from ocp_traj.transcription.condensed.batch import build_curves
from ocp_traj.transcription.curve import decided_knots, end_conditions, pieces_through
from ocp_traj.transcription.nlp import Symbol

REST = 1e-9
"""Fraction of the largest travel below which a joint rests."""

REST_UNIT = 0.1
"""Unit of a joint that rests, as a fraction of the largest travel of any joint."""


class Offsets(ABC):
    """Where virtual knots are when their offsets are zero, and how far an offset of one moves them.

    Parameters
    ----------
    task : TrajectoryTask

    Attributes
    ----------
    name : str
        In names of solvers and in results.
    knots : (V,) of int
        The virtual knots that have an offset: those the end conditions do not decide.
    unit : (V, n) rad (m)
    half_width : float
        Of the box of an offset, in units.
    passed : (S + 1, n) rad (m)
        The waypoint that every knot is, or comes after.
    """

    name: ClassVar[str]

    def __init__(self, task: TrajectoryTask) -> None:
        self.task = task
        self.per_gap = task.virtual_knots + 1
        knots = np.arange(task.gaps * self.per_gap + 1)
        decided = np.concatenate(decided_knots(task)).astype(int)
        self.knots = np.setdiff1d(knots[knots % self.per_gap > 0], decided)
        self.passed = np.asarray(task.waypoints)[knots // self.per_gap]

    @property
    @abstractmethod
    def unit(self) -> Array:
        """Distance that an offset of one stands for, (V, n), rad (m)."""

    @property
    @abstractmethod
    def half_width(self) -> float:
        """Half of the box's width, in units."""

    @abstractmethod
    def anchors(self, durations: Array) -> Array:
        """Return where the knots are without offsets, (S + 1, n, 1 or p).

        Parameters
        ----------
        durations : (p, S) s
        """

    @abstractmethod
    def symbolic_anchors(self, durations: Symbol) -> list[Any]:
        """Return the anchors of symbolic durations (S,), S + 1 rows (1, n)."""


class ChordOffsets(Offsets):
    """From the chord between the waypoints, evenly divided, in units of half the joint's whole travel."""

    name = "chord"
    half_width = 1.0

    def __init__(self, task: TrajectoryTask) -> None:
        super().__init__(task)
        rise = np.repeat(np.diff(task.waypoints, axis=0), self.per_gap, axis=0)
        share = np.arange(len(rise))[:, None] % self.per_gap / self.per_gap
        self.chord = self.passed + np.concatenate([rise * share, np.zeros((1, task.n))])

    @property
    def unit(self) -> Array:
        """Half the joint's travel over all waypoints, (V, n)."""
        return np.tile(np.ptp(self.task.waypoints, axis=0) / 2, (self.knots.size, 1))

    def anchors(self, durations: Array) -> Array:
        """Return the chord, (S + 1, n, 1)."""
        return self.chord[:, :, None]

    def symbolic_anchors(self, durations: Symbol) -> list[Any]:
        """Return the chord."""
        return [ca.DM(row[None, :]) for row in self.chord]


class SplineOffsets(Offsets):
    """From the spline of the family's degree through the waypoints, at the candidate's own durations.

    Its end conditions are those the degree has room for; a cubic is clamped, with free end accelerations. An offset
    is in units of the joint's largest travel over the knot's gap and that gap's neighbours; where it rests in all of
    them, in units of a tenth of the largest such travel of any joint.
    """

    name = "spline"

    def __init__(self, task: TrajectoryTask) -> None:
        super().__init__(task)
        room = (task.family.degree - 1) // 2
        ends: dict[str, Any] = {name: getattr(task.boundary, name) for name in RATES[:room]}
        ends |= dict.fromkeys(RATES[room:])
        self.bare = task.changed(virtual_knots=0, boundary=Boundary(**ends)) if self.knots.size else task

    @property
    def half_width(self) -> float:
        """The task's ``search.offset``."""
        return float(self.task.search.offset)

    @property
    def unit(self) -> Array:
        """Local travel, (V, n)."""
        travel = np.abs(np.diff(self.task.waypoints, axis=0))
        padded = np.pad(travel, ((1, 1), (0, 0)))
        local = np.maximum(np.maximum(padded[:-2], padded[2:]), travel)
        largest = local.max(axis=1, keepdims=True)
        largest = np.where(largest > 0, largest, travel.max())
        return np.where(local > REST * largest, local, REST_UNIT * largest)[self.knots // self.per_gap]

    def anchors(self, durations: Array) -> Array:
        """Return the spline at the knots, (S + 1, n, p)."""
        task, waypoints = self.task, np.asarray(self.task.waypoints)
        if not self.knots.size:
            return self.passed[:, :, None]
        ends = durations.reshape(len(durations), task.gaps, self.per_gap).cumsum(axis=2)
        totals = ends[:, :, -1]
        inside = (ends[:, :, :-1] / totals[:, :, None]).transpose(2, 1, 0)
        values = build_curves(self.bare, totals, waypoints[:, :, None]).positions(inside)
        anchors = np.empty((durations.shape[1] + 1, task.n, len(durations)))
        anchors[:: self.per_gap] = waypoints[:, :, None]
        for k in range(self.per_gap - 1):
            anchors[k + 1 :: self.per_gap] = values[:, k].transpose(1, 0, 2)
        return anchors

    def symbolic_anchors(self, durations: Symbol) -> list[Any]:
        """Return the spline at the knots."""
        if not self.knots.size:
            return [ca.DM(row[None, :]) for row in self.passed]
        waypoints = [ca.DM(row[None, :]) for row in self.task.waypoints]
        ends = ca.cumsum(ca.reshape(durations, self.per_gap, self.task.gaps), 0)
        totals = ca.horzsplit(ends[-1, :])
        given = end_conditions(self.bare)
        start, end = ({order: ca.DM(value) for order, value in side.items()} for side in (given.start, given.end))
        pieces = pieces_through(self.bare, totals, waypoints, EndConditions(start, end))
        anchors: list[Any] = []
        for gap, piece in enumerate(pieces):
            anchors.append(waypoints[gap])
            coefficients = piece.coefficients()
            for k in range(self.per_gap - 1):
                fraction = ends[k, gap] / totals[gap]
                value = coefficients[-1]
                for coefficient in reversed(coefficients[:-1]):
                    value = value * fraction + coefficient
                anchors.append(value)
        return [*anchors, waypoints[-1]]


OFFSETS: dict[str, type[Offsets]] = {entry.name: entry for entry in (SplineOffsets, ChordOffsets)}
"""What offsets can be measured from, by name."""


def find_offsets(name: str) -> type[Offsets]:
    """Return the offsets of that name.

    Raises
    ------
    InputError
        There are none; the message lists those there are.
    """
    if name not in OFFSETS:
        raise InputError(f"offsets {name!r} are unknown, expected one of {', '.join(OFFSETS)}")
    return OFFSETS[name]


__all__ = ["OFFSETS", "ChordOffsets", "Offsets", "SplineOffsets", "find_offsets"]
