"""The condensed form: durations (and positions at virtual knots) alone; the spline's conditions are solved inside.

This is the form of the papers and of population methods: few variables, every candidate a complete motion through
the waypoints. `evaluate` judges a whole population with batched NumPy; the symbols x, f, g give a gradient solver
the same rows with the same numbers.
"""

from __future__ import annotations

import time
from functools import cached_property
from typing import Any

import numpy as np

from metaheuristics import Evaluation
from ocp_traj.arrays import Array, ArrayLike
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.condensed.encodings import Encoding, find_encoding
from ocp_traj.transcription.condensed.rows import make_rows
from ocp_traj.transcription.condensed.symbolic import condensed_symbols
from ocp_traj.transcription.guess import initial_guess
from ocp_traj.transcription.nlp import Nlp, Symbol


class CondensedNlp(Nlp):
    """The condensed form of a task.

    Parameters
    ----------
    task : TrajectoryTask
    encoding : str or Encoding class
        ``"durations"``: x holds the duration of every gap, s; ``"log-durations"``: their logarithms;
        ``"scaled"``: only the proportions of the durations count, the total is the smallest feasible one (or, for
        costs other than time, the best feasible one), found in closed form. With virtual knots, how a gap's
        duration is divided follows, then the offsets of the knots.
    samples : int
        Samples a gap of limits without closed-form extrema and of integrated costs.
    extrema : str
        ``"exact"``: velocity, acceleration and jerk by closed-form extrema where the family has them (cubic,
        3-5-3); ``"sampled"``; ``"auto"`` chooses exact where there is.
    bounds : (2,), optional
        Of the duration of a gap, s; by default the task's search box.
    offsets : str
        ``"spline"``: offsets of virtual knots are measured from the spline of the family's degree through the
        waypoints, in units of the local travel, in +-``search.offset``; ``"chord"``: from the chord, in units of half
        the joint's travel, in [-1, 1].
    guess : Trajectory, optional
        A motion of the task's family and number of knots to start from; by default one from the limits alone.
    box : pair of (d,), optional
        Bounds of the variables; by default the encoding's own.

    Attributes
    ----------
    encoding : Encoding
        What the variables mean.
    """

    form = "condensed"
    encoding: Encoding

    def __init__(
        self,
        task: TrajectoryTask,
        *,
        encoding: str | type[Encoding] = "durations",
        samples: int = 16,
        extrema: str = "auto",
        bounds: ArrayLike | None = None,
        offsets: str = "spline",
        guess: Trajectory | None = None,
        box: tuple[Array, Array] | None = None,
    ) -> None:
        chosen = find_encoding(encoding)
        self.encoding = chosen(task, make_rows(task, samples, extrema), bounds, offsets)
        self.segments = self.encoding.segments
        start = self.encoding.encode(initial_guess(task) if guess is None else guess)
        lower, upper = (self.encoding.lower, self.encoding.upper) if box is None else box
        g_lower, g_upper = self.encoding.bounds()
        super().__init__(
            task,
            lower=lower,
            upper=upper,
            guess=np.clip(start, lower, upper),
            g_lower=g_lower,
            g_upper=g_upper,
            rows=self.encoding.labels(),
        )

    def durations(self, X: Array) -> Array:
        """Return the durations (p, S) that the first variables of X (p, d) stand for, before any scaling."""
        return self.encoding.durations(X)

    def evaluate(self, X: Array) -> Evaluation:
        """Judge a population; see `metaheuristics.Problem.evaluate`."""
        X = np.atleast_2d(np.asarray(X, dtype=np.float64))
        return self.encoding.evaluate(self.encoding.curves(X))

    def motion(self, x: Array) -> Trajectory:
        """Return the exact trajectory that variables x (d,) stand for; see `Nlp.motion`."""
        return self.encoding.decode(x)

    def encode(self, trajectory: Trajectory) -> Array:
        """Return the variables of a motion of this family with the same number of knots (not clipped)."""
        known = trajectory if self.preparation is None else self.preparation.prepared(trajectory)
        return self.encoding.encode(known)

    @cached_property
    def _symbols(self) -> tuple[float, tuple[Symbol, Symbol, Symbol]]:
        begin = time.perf_counter()
        symbols = condensed_symbols(self.encoding)
        return time.perf_counter() - begin, symbols

    @property
    def symbol_seconds(self) -> float:
        """Seconds that making the symbols took."""
        return self._symbols[0]

    @property
    def x(self) -> Symbol:
        """Symbol of the variables (d,)."""
        return self._symbols[1][0]

    @property
    def f(self) -> Symbol:
        """Symbolic cost."""
        return self._symbols[1][1]

    @property
    def g(self) -> Symbol:
        """Symbolic constraint rows (m,)."""
        return self._symbols[1][2]

    @property
    def derivatives(self) -> dict[str, Any]:  # type: ignore[override]
        """Empty: CasADi differentiates the few variables itself."""
        return {}
