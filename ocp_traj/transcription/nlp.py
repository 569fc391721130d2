"""The numerical problem a task becomes: the same object for gradient and population solvers."""

from __future__ import annotations

import copy
from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from metaheuristics import Evaluation, Problem
from ocp_traj.arrays import Array, read_only
from ocp_traj.task import TrajectoryTask
from ocp_traj.task.preparing import PreparedTask
from ocp_traj.trajectory import Trajectory

Symbol = Any
"""A CasADi expression, MX or SX; CasADi itself has no types."""

NlpT = TypeVar("NlpT", bound="Nlp")


@dataclass(frozen=True)
class RowBlock:
    """Labels of consecutive constraint rows.

    Attributes
    ----------
    limit : str
        ``velocity``, ``torque``, ...; ``continuity`` for the equations between knot states.
    joint, gap : (rows,) integer arrays from 0; joint -1 where a row belongs to none
    fraction : (rows,) where in the gap, 0 to 1
    """

    limit: str
    joint: Any
    gap: Any
    fraction: Any

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.joint)


class Nlp(Problem):
    """min f(x) subject to lower <= x <= upper and g_lower <= g(x) <= g_upper, made from a task.

    Attributes
    ----------
    task : TrajectoryTask
    form : str
        ``"condensed"`` or ``"lifted"``.
    encoding : Encoding or str
        What the variables mean; its text is the name: ``"durations"``, ``"log-durations"``, ``"scaled"``, or one's
        own; the lifted form has ``"knot-states"``.
    x, f, g : MX or SX
        Symbols; f in the objective's own unit, every row of g scaled by its limit (1e-3 means 0.1 % over).
    derivatives : dict
        Ready derivative functions for CasADi's nlpsol; may be empty.
    g_lower, g_upper : (m,)
    guess : (d,)
    rows : list of RowBlock
    preparation : PreparedTask or None
        The way back to the task that was asked for, where `task` is that one made ready.
    """

    form: str
    encoding: object

    def __init__(
        self,
        task: TrajectoryTask,
        *,
        lower: Array,
        upper: Array,
        guess: Array,
        g_lower: Array,
        g_upper: Array,
        rows: list[RowBlock],
    ) -> None:
        super().__init__(task.name, lower, upper)
        self.task = task
        self.guess = read_only(guess)
        self.g_lower = read_only(g_lower)
        self.g_upper = read_only(g_upper)
        self.rows = rows
        self.preparation: PreparedTask | None = None

    x: Symbol
    f: Symbol
    g: Symbol
    derivatives: dict[str, Any]

    def restoring(self: NlpT, preparation: PreparedTask) -> NlpT:
        """Return the same problem, whose motions and labels are those of the task it was made ready from."""
        restoring = copy.copy(self)
        restoring.preparation = preparation
        return restoring

    def decode(self, x: Array) -> Trajectory:
        """Return the exact trajectory that variables x (d,) stand for, of the task that was asked for."""
        return self.motion(x) if self.preparation is None else self.preparation.restored(self.motion(x))

    @abstractmethod
    def motion(self, x: Array) -> Trajectory:
        """Return the exact trajectory that variables x (d,) stand for, of `task`."""

    def label(self, row: int) -> str:
        """Return the words for one constraint row, such as ``torque, joint 3, gap 2, 0.42``."""
        index = row
        for block in self.rows:
            if index < len(block):
                joint = f", joint {block.joint[index] + 1}" if block.joint[index] >= 0 else ""
                label = f"{block.limit}{joint}, gap {block.gap[index] + 1}, {block.fraction[index]:.2f}"
                return label if self.preparation is None else self.preparation.in_original_numbers(label)
            index -= len(block)
        raise IndexError(f"row {row} of {sum(map(len, self.rows))}")

    def violations(self, g: Array) -> Array:
        """Return max(g - g_upper, g_lower - g, 0) of rows (..., m)."""
        over = np.maximum(g - self.g_upper, self.g_lower - g)
        return np.maximum(over, 0.0)

    def evaluate(self, X: Array) -> Evaluation:
        """Evaluate candidates one by one through the symbolic functions; forms for populations do better."""
        import casadi as ca

        function = ca.Function("nlp", [self.x], [self.f, self.g])
        values = [function(row) for row in np.atleast_2d(X)]
        cost = np.array([float(f) for f, _ in values])
        g = np.array([np.array(g).ravel() for _, g in values]).reshape(len(values), -1)
        return Evaluation(cost, self.violations(g))
