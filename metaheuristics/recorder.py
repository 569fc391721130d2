"""The course of a run while it goes on: the best so far and its history."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from metaheuristics.arrays import FloatArray, freeze
from metaheuristics.evaluation import Evaluation
from metaheuristics.problem import Problem
from metaheuristics.solution import History, Solution, Status

COLUMNS = ("evaluations", "cost", "violation", "seconds", "spread")


@dataclass(eq=False)
class Recorder:
    """The mutable book-keeping of one run; owned by the loop, handed to nobody.

    Parameters
    ----------
    x
        (d,) the best candidate so far: least total violation, then least cost.
    cost, violation, rows
        Its cost, total violation and violation row by row (m,), as the problem gave them.
    evaluations, stalled
        Evaluations spent, generations since the best last improved.
    entries, positions
        One tuple of `COLUMNS` and one best x a generation.
    """

    x: FloatArray
    cost: float = math.inf
    violation: float = math.inf
    rows: FloatArray = field(default_factory=lambda: np.empty(0))
    evaluations: int = 0
    stalled: int = 0
    improved: bool = False
    entries: list[tuple[float, ...]] = field(default_factory=list)
    positions: list[FloatArray] = field(default_factory=list)

    def update(self, X: FloatArray, evaluation: Evaluation) -> None:
        """Count the candidates (p, d) and keep the best of them if it beats the best so far."""
        cost, violation = evaluation.scores
        self.evaluations += X.shape[0]
        if evaluation.violation.shape[1]:
            i = int(np.where(violation == violation.min(), cost, np.inf).argmin())
        else:
            i = int(cost.argmin())
        c, excess = cost.item(i), violation.item(i)
        if excess < self.violation or (excess == self.violation and c < self.cost):
            self.x, self.cost, self.violation = freeze(X[i]), c, excess
            self.rows = evaluation.violation[i].copy()
            self.improved = True

    def close_generation(self, seconds: float, spread: float) -> None:
        """Add one entry to the history."""
        self.stalled = 0 if self.improved else self.stalled + 1
        self.improved = False
        self.entries.append((self.evaluations, self.cost, self.violation, seconds, spread))
        self.positions.append(self.x)

    def make_history(self) -> History:
        """Return the history so far, read-only."""
        table = np.array(self.entries, dtype=np.float64).reshape(-1, len(COLUMNS))
        columns: dict[str, Any] = {name: freeze(table[:, i]) for i, name in enumerate(COLUMNS)}
        columns["evaluations"] = table[:, 0].astype(np.intp)
        columns["evaluations"].flags.writeable = False
        return History(**columns, x=freeze(np.array(self.positions).reshape(-1, self.x.shape[0])))

    def make_solution(
        self, problem: Problem, status: Status, message: str, *, solve_time: float, build_time: float = 0.0
    ) -> Solution:
        """Return the best candidate as an answer, whatever the solver itself called its own.

        Parameters
        ----------
        problem
            What was solved.
        status, message
            Why the run ended; failed or infeasible where the best candidate says so.
        solve_time, build_time
            Seconds spent.
        """
        if not math.isfinite(self.cost):
            status, message = Status.FAILED, f"No candidate had finite values. {message}"
        elif self.violation > 0.0:
            status = Status.INFEASIBLE
            message = f"The least total violation found is {self.violation:.3g}. {message}"
        return Solution(
            problem=problem,
            x=self.x,
            cost=self.cost,
            violation=freeze(self.rows),
            status=status,
            message=message,
            evaluations=self.evaluations,
            build_time=build_time,
            solve_time=solve_time,
            history=self.make_history(),
        )

    def pack(self) -> dict[str, Any]:
        """Return everything as arrays, for a checkpoint."""
        return {
            "x": self.x,
            "rows": self.rows,
            "numbers": np.array([self.cost, self.violation]),
            "counts": np.array([self.evaluations, self.stalled, int(self.improved)]),
            "entries": np.array(self.entries, dtype=np.float64).reshape(-1, len(COLUMNS)),
            "positions": np.array(self.positions, dtype=np.float64).reshape(-1, self.x.shape[0]),
        }

    @classmethod
    def unpack(cls, data: dict[str, Any]) -> Recorder:
        """Return the recorder that `pack` described."""
        evaluations, stalled, improved = (int(count) for count in data["counts"])
        return cls(
            freeze(data["x"]),
            float(data["numbers"][0]),
            float(data["numbers"][1]),
            rows=data["rows"],
            evaluations=evaluations,
            stalled=stalled,
            improved=bool(improved),
            entries=[tuple(row) for row in data["entries"].tolist()],
            positions=[freeze(row) for row in data["positions"]],
        )


def measure_spread(positions: FloatArray, inverse_width: FloatArray) -> float:
    """Return the standard deviation of a population relative to the box, mean over the coordinates.

    Parameters
    ----------
    positions
        (n, d) the population.
    inverse_width
        (d,) 1 / (upper - lower), 0 for a fixed variable.
    """
    deviation = find_deviation(positions)
    return float(deviation.dot(inverse_width) / positions.shape[1])


def find_deviation(positions: FloatArray) -> FloatArray:
    """Return the standard deviation of a population (n, d) in each coordinate, (d,).

    By products with a weight vector: `numpy.std` takes four times longer for a small population.
    """
    weights = list_equal_weights(positions.shape[0])
    centred = positions - weights.dot(positions)
    centred *= centred
    return np.sqrt(weights.dot(centred))


@lru_cache(maxsize=64)
def list_equal_weights(n: int) -> FloatArray:
    """Return 1 / n, n times, read-only; kept, since every generation asks for the same."""
    return freeze(np.full(n, 1.0 / n))
