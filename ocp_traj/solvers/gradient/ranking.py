"""Which of several answers is best: the audit's verdict first, then the objective, never the solver's own status."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from metaheuristics import Status
from ocp_traj.audit.costs import objective_value
from ocp_traj.solvers.gradient.plugin_call import Answer
from ocp_traj.solvers.mending import slowed_into_limits
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory


def is_feasible(task: TrajectoryTask, trajectory: Trajectory) -> bool:
    """Return whether the audit passes a motion, slowed a little where that is all it needs."""
    return slowed_into_limits(task, trajectory)[1].feasible


def value(task: TrajectoryTask, trajectory: Trajectory) -> tuple[float, float]:
    """Return what motions are compared by, smaller first: excess over the limits, 0 where feasible; objective."""
    motion, verdict, _ = slowed_into_limits(task, trajectory)
    worst = np.inf if verdict.worst is None else max(verdict.worst.ratio, 1.0)
    return 0.0 if verdict.feasible else worst, objective_value(task, motion)


def best_answer(task: TrajectoryTask, answers: Sequence[Answer]) -> Answer:
    """Return the best of several answers; one that failed but has a feasible motion counts as stalled."""
    if len(answers) == 1:
        return answers[0]
    values = [value(task, answer.trajectory) for answer in answers]
    index = min(range(len(answers)), key=lambda each: (values[each], not answers[each].solved))
    best = answers[index]
    if values[index][0] == 0.0 and best.status in (Status.FAILED, Status.INFEASIBLE):
        return replace(best, status=Status.STALLED)
    return best
