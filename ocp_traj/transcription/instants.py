"""Symbolic functions of one instant of a motion: torques, powers, speeds and a user's own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca

from ocp_traj.costs import SAMPLED_TERMS, SampledTerm
from ocp_traj.limits import SAMPLED_CONSTRAINTS, SampledConstraint, SymbolicSample
from ocp_traj.task import TrajectoryTask


@dataclass(frozen=True)
class Instant:
    """What a task asks of every instant.

    Attributes
    ----------
    constraints : constraints that apply
    terms : cost terms with weight
    needs_jerk : whether any of them needs the jerk
    """

    constraints: tuple[SampledConstraint, ...]
    terms: tuple[SampledTerm, ...]

    @property
    def needs_jerk(self) -> bool:
        """Whether any constraint needs the jerk."""
        return any(constraint.needs_jerk for constraint in self.constraints)

    def __bool__(self) -> bool:
        """Whether there is anything."""
        return bool(self.constraints or self.terms)


def instant_of(task: TrajectoryTask) -> Instant:
    """Return the sampled constraints and terms that apply to a task."""
    return Instant(
        tuple(constraint for constraint in SAMPLED_CONSTRAINTS if constraint.applies(task)),
        tuple(term for term in SAMPLED_TERMS if term.weight(task) > 0),
    )


def instant_function(task: TrajectoryTask, part: SampledConstraint | SampledTerm) -> Any:
    """Return the CasADi function (q, v, a, j) -> values of one constraint or term."""
    symbols = [ca.SX.sym(name, task.n) for name in "qvaj"]
    return ca.Function(part.name, symbols, [part.expression(SymbolicSample(task, *symbols))])
