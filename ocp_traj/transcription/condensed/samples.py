"""The motion of a population on a regular grid of every segment, and the torques there."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.condensed.batch import CurveBatch


class Buffers:
    """Arrays that are used again for the next population of the same size: fresh ones cost more than their use."""

    def __init__(self) -> None:
        self._arrays: dict[str, Array] = {}

    def take(self, name: str, shape: tuple[int, ...]) -> Array:
        """Return an array of that shape, its content undefined."""
        if name not in self._arrays or self._arrays[name].shape != shape:
            self._arrays[name] = np.empty(shape)
        return self._arrays[name]


class Samples:
    """q, v, a, jerk and torque of a population on the grid, each computed when first needed.

    Arrays are (n, N, S, p). The fractions run from 1 down to 0: the start of a segment is the end of the one before
    it, so the points that need a torque of their own, all but the starts of the second and later segments, are the
    head of every joint's block.

    Parameters
    ----------
    task : TrajectoryTask
    curves : CurveBatch
    fractions : tuple
    buffers : Buffers, optional
        Where the arrays live; samples that share them overwrite each other.
    """

    def __init__(
        self,
        task: TrajectoryTask,
        curves: CurveBatch,
        fractions: tuple[float, ...],
        buffers: Buffers | None = None,
    ) -> None:
        self.task, self.curves, self.fractions = task, curves, fractions
        self.buffers = Buffers() if buffers is None else buffers
        self._motion: dict[int, Array] = {}

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """(n, N, S, p)."""
        return (self.task.n, len(self.fractions), *self.curves.h.shape)

    def motion(self, order: int) -> Array:
        """Return a derivative on the grid."""
        if order not in self._motion:
            out = self.buffers.take(f"derivative {order}", self.shape)
            self._motion[order] = self.curves.sample(order, self.fractions, out)
        return self._motion[order]

    @cached_property
    def torque(self) -> Array:
        """Joint torques."""
        return self._torque("torque", self.motion(1), self.motion(2))

    @cached_property
    def static_torque(self) -> Array:
        """Torques that hold the arm still (no friction)."""
        zero = np.zeros(self.shape)
        return self._torque("static torque", zero, zero)

    def _torque(self, name: str, v: Array, a: Array) -> Array:
        robot = self.task.robot
        assert robot is not None
        n, points, segments, p = v.shape
        own = (points - 1) * segments * p + p
        tau = self.buffers.take(name, self.shape)
        columns = [values.reshape(n, -1)[:, :own] for values in (self.motion(0), v, a)]
        robot.batch.torque_columns(columns[0], columns[1], columns[2], tau.reshape(n, -1)[:, :own])
        tau[:, -1, 1:] = tau[:, 0, :-1]
        return tau

    def call(self, function: Any) -> Array:
        """Evaluate a CasADi function (q, v, a, j) -> (k,) on the grid, (k, N, S, p)."""
        columns = [self.motion(order).reshape(self.task.n, -1) for order in range(4)]
        values = np.array(function.map(columns[0].shape[1])(*columns))
        return values.reshape(-1, *self.motion(0).shape[1:])
