"""The condensed form: durations (and positions at virtual knots) alone; the spline's conditions are solved inside.

This is the form of the papers and of population methods: few variables, every candidate a complete motion through
the waypoints. `evaluate` judges a whole population with batched NumPy; the symbols x, f, g give a gradient solver
the same rows with the same numbers.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from metaheuristics import Evaluation
from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError, UnavailableError
from ocp_traj.spline import get_family
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.condensed.batch import build_curves, knot_positions
from ocp_traj.transcription.condensed.encoding import ENCODINGS
from ocp_traj.transcription.condensed.rows import CondensedRows, make_rows
from ocp_traj.transcription.curve import build_trajectory
from ocp_traj.transcription.guess import initial_guess
from ocp_traj.transcription.nlp import Nlp


class CondensedNlp(Nlp):
    """The condensed form of a task.

    Parameters
    ----------
    task : TrajectoryTask
    encoding : str
        ``"durations"``: x holds the duration of every segment, s; ``"log-durations"``: their logarithms;
        ``"scaled"``: only the proportions of the durations count, the total is the smallest feasible one (or, for
        costs other than time, the best feasible one), found in closed form. After the durations come, for every
        virtual knot and joint, the offset from the chord in units of half the joint's travel, in [-1, 1].
    samples : int
        Samples a gap of limits without closed-form extrema and of integrated costs.
    extrema : str
        ``"exact"``: velocity, acceleration and jerk by closed-form extrema where the family has them (cubic,
        3-5-3); ``"sampled"``; ``"auto"`` chooses exact where there is.
    """

    form = "condensed"

    def __init__(
        self, task: TrajectoryTask, *, encoding: str = "durations", samples: int = 16, extrema: str = "auto"
    ) -> None:
        if encoding not in ENCODINGS:
            raise InputError(f"encoding {encoding!r} is unknown, expected one of {', '.join(ENCODINGS)}")
        self.encoding = encoding
        self.segments = task.gaps * (task.virtual_knots + 1)
        self.task = task
        self.rows_of: CondensedRows = make_rows(task, samples, extrema)
        self._code = ENCODINGS[encoding](self)
        per_gap = task.virtual_knots + 1
        low, high = np.asarray(task.search.duration) / per_gap
        offsets = task.gaps * task.virtual_knots * task.n
        lower = np.concatenate(
            [np.full(self.segments, self._code.from_duration(low)), np.full(offsets, -1.0)]
        )
        upper = np.concatenate(
            [np.full(self.segments, self._code.from_duration(high)), np.full(offsets, 1.0)]
        )
        g_lower, g_upper = self._code.bounds()
        super().__init__(
            task,
            lower=lower,
            upper=upper,
            guess=np.clip(self.encode(initial_guess(task)), lower, upper),
            g_lower=g_lower,
            g_upper=g_upper,
            rows=self._code.labels(),
        )

    def durations(self, X: Array) -> Array:
        """Return the durations (p, S) that the first variables of X (p, d) stand for, before any scaling."""
        return self._code.to_duration(X[:, : self.segments])

    def offsets(self, X: Array) -> Array:
        """Return the offsets (p, virtual knots, n)."""
        count = self.task.gaps * self.task.virtual_knots
        return X[:, self.segments :].reshape(len(X), count, self.task.n)

    def evaluate(self, X: Array) -> Evaluation:
        """Judge a population; see `metaheuristics.Problem.evaluate`."""
        X = np.atleast_2d(np.asarray(X, dtype=np.float64))
        return self._code.evaluate(build_curves(self.task, self.durations(X), self.offsets(X)))

    def decode(self, x: Array) -> Trajectory:
        """Return the exact trajectory that variables x (d,) stand for."""
        X = np.asarray(x, dtype=np.float64)[None, :]
        curves = build_curves(self.task, self.durations(X), self.offsets(X))
        scale = self._code.scale(curves)[0]
        return build_trajectory(self.task, curves.h[:, 0] * scale, self._positions(X))

    def encode(self, trajectory: Trajectory) -> Array:
        """Return the variables of a motion of this family with the same number of knots (not clipped)."""
        breakpoints = np.asarray(trajectory.breakpoints)
        per_gap = self.task.virtual_knots + 1
        half = np.ptp(self.task.waypoints, axis=0) / 2
        values = [self._code.from_duration(np.diff(breakpoints))]
        for gap in range(self.task.gaps):
            start, end = self.task.waypoints[gap], self.task.waypoints[gap + 1]
            for knot in range(1, per_gap):
                chord = start + (end - start) * (knot / per_gap)
                away = trajectory(breakpoints[gap * per_gap + knot]) - chord
                values.append(np.divide(away, half, out=np.zeros_like(away), where=half > 0))
        return np.concatenate(values)

    def _positions(self, X: Array) -> Array:
        """Return the positions at all knots of one candidate, (S + 1, n)."""
        return knot_positions(self.task, self.offsets(X))[:, :, 0]

    @cached_property
    def _symbols(self) -> tuple[Any, Any, Any]:
        from ocp_traj.transcription.condensed.symbolic import condensed_symbols

        if self.encoding == "scaled":
            raise UnavailableError(
                "the scaled encoding has no symbols: its total duration is a maximum over all limits; "
                "expected encoding 'durations' or 'log-durations'"
            )
        return condensed_symbols(self)

    @property
    def x(self) -> Any:
        """Symbol of the variables (d,)."""
        return self._symbols[0]

    @property
    def f(self) -> Any:
        """Symbolic cost."""
        return self._symbols[1]

    @property
    def g(self) -> Any:
        """Symbolic constraint rows (m,)."""
        return self._symbols[2]

    @property
    def derivatives(self) -> dict[str, Any]:  # type: ignore[override]
        """Empty: CasADi differentiates the few variables itself."""
        return {}


def family_has_closed_extrema(task: TrajectoryTask) -> bool:
    """Return whether velocities of the family have closed-form extrema (degree <= 5)."""
    return get_family(task.family).degree <= 5
