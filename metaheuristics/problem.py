"""The shared statement of an optimisation problem: a box, a cost, and constraint rows."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from metaheuristics.arrays import FloatArray, freeze
from metaheuristics.evaluation import Evaluation

BatchFunction = Callable[[FloatArray], Any]


class Problem(ABC):
    """Minimise a cost over a box, subject to constraint rows whose violation is 0 when they are kept.

    Parameters
    ----------
    name
        A short name for reports and errors.
    lower, upper
        (d,) the box. Infinite bounds are allowed here; population methods refuse them at their start.

    Raises
    ------
    ValueError
        If the bounds are not two vectors of the same length with lower <= upper.
    """

    def __init__(self, name: str, lower: npt.ArrayLike, upper: npt.ArrayLike) -> None:
        self._name = name
        self._lower = freeze(lower)
        self._upper = freeze(upper)
        if self._lower.ndim != 1 or self._lower.shape != self._upper.shape or not self._lower.size:
            raise ValueError(
                f"The bounds of problem {name!r} have shapes {self._lower.shape} and {self._upper.shape}, "
                "expected two vectors of the same length (d,)."
            )
        wrong = ~(self._lower <= self._upper)
        if wrong.any():
            i = int(np.argmax(wrong))
            raise ValueError(
                f"Variable {i + 1} of problem {name!r} has bounds [{self._lower[i]}, {self._upper[i]}], "
                "expected lower <= upper."
            )

    @property
    def name(self) -> str:
        """Short name for reports and errors."""
        return self._name

    @property
    def lower(self) -> FloatArray:
        """(d,) lower bounds, read-only."""
        return self._lower

    @property
    def upper(self) -> FloatArray:
        """(d,) upper bounds, read-only."""
        return self._upper

    @property
    def dimension(self) -> int:
        """Number of variables d."""
        return int(self._lower.shape[0])

    @abstractmethod
    def evaluate(self, X: FloatArray) -> Evaluation:
        """Judge a batch of candidates.

        Parameters
        ----------
        X
            (p, d) candidates, one a row; may be read-only.

        Returns
        -------
        Evaluation
            Costs (p,) and violations (p, m); row k depends on candidate k alone.
        """

    @classmethod
    def from_function(
        cls, f: BatchFunction, lower: npt.ArrayLike, upper: npt.ArrayLike, name: str = "function"
    ) -> Problem:
        """Wrap a function of a whole batch.

        Parameters
        ----------
        f
            Takes X (p, d), returns costs (p,) or an `Evaluation`.
        lower, upper
            (d,) the box.
        name
            A short name for reports and errors.

        Returns
        -------
        Problem
            Whose `evaluate` calls `f`.
        """
        return FunctionProblem(f, lower, upper, name)


class FunctionProblem(Problem):
    """A problem given by one batch function; see `Problem.from_function`."""

    def __init__(self, f: BatchFunction, lower: npt.ArrayLike, upper: npt.ArrayLike, name: str) -> None:
        super().__init__(name, lower, upper)
        self._function = f

    def evaluate(self, X: FloatArray) -> Evaluation:
        """Call the function; see `Problem.evaluate`.

        Raises
        ------
        ValueError
            If the function does not answer with one number (or one row) a candidate.
        """
        answer = self._function(X)
        evaluation = answer if isinstance(answer, Evaluation) else Evaluation(answer)
        if evaluation.cost.shape[0] != X.shape[0]:
            raise ValueError(
                f"Problem {self.name!r} answered {evaluation.cost.shape[0]} costs for {X.shape[0]} "
                "candidates, expected one a candidate."
            )
        return evaluation
