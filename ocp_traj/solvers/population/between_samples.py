"""Limits that a population's answer breaks between its samples: the search goes on beside it until the judge agrees.

Slowing mends most of them. Where it may not, because durations are bounded or the motion does not start and end at
rest, some of the budget is kept for a search with more samples and limits tightened by what was missed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from metaheuristics import Solution
from ocp_traj.arrays import Array
from ocp_traj.solvers.mending import LARGEST_OVERSIGHT, slowed_into_limits, tightened
from ocp_traj.solvers.solver import Request
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.condensed.condensed import CondensedNlp

KEPT = 0.1
"""Fraction of the budget kept for an answer that may have to be refined."""

ROUNDS = 4
"""Most searches beside the answer; each gets half of what is left, the last one all of it."""

DENSER = 2
"""Factor on the samples from round to round."""

BESIDE = 0.02
"""Half-width of the box around the answer, relative to the whole box."""

SPARE = 1.5
"""Tightening of a limit, relative to what was found above it."""


@dataclass(frozen=True)
class Missed:
    """An answer that keeps its own rows, and what the judge finds above a limit.

    Parameters
    ----------
    nlp : CondensedNlp
        What was searched.
    x : (d,) the answer.
    excess : float
        Above the limit, relative to it; 0 where the judge agrees.
    """

    nlp: CondensedNlp
    x: Array
    excess: float


def may_be_refused(task: TrajectoryTask, nlp: CondensedNlp) -> bool:
    """Return whether an answer of this problem can be over a limit between samples, and slowing not mend it."""
    sampled = bool(nlp.encoding.rows.instants) or not all(row.exact for row in nlp.encoding.rows.kinematic)
    longest = [np.asarray(task.objective.duration)[1], *np.asarray(task.objective.gap_durations)[:, 1]]
    return sampled and (not task.boundary.is_rest or bool(np.isfinite(longest).any()))


def look_between(task: TrajectoryTask, nlp: CondensedNlp, x: Array) -> Missed:
    """Return what the judge finds above a limit in the motion that x (d,) stands for."""
    _, verdict, _ = slowed_into_limits(task, nlp.decode(x))
    worst = 1.0 if verdict.feasible or verdict.worst is None else verdict.worst.ratio
    return Missed(nlp, x, max(worst - 1.0, 0.0))


def refine(
    task: TrajectoryTask,
    solution: Solution,
    request: Request,
    make: Callable[[TrajectoryTask, int, tuple[Array, Array]], CondensedNlp],
    search: Callable[[CondensedNlp, Request, Array], Solution],
) -> Solution:
    """Return the answer of a search that goes on beside a solution until the judge has nothing to add.

    Parameters
    ----------
    task : TrajectoryTask
        With its own limits.
    solution : metaheuristics.Solution
        Of a `CondensedNlp`.
    request : Request
        What is left of budget and time.
    make : callable
        From a task, a factor on the samples and a box to the problem.
    search : callable
        From a problem, a request and a start (k, d) to a solution.
    """
    assert isinstance(solution.problem, CondensedNlp)
    whole = solution.problem
    missed, searches, answer, tighter = look_between(task, whole, solution.x), [solution], solution, 0.0
    for number in range(1, ROUNDS + 1):
        if not (solution.feasible and 0.0 < missed.excess < LARGEST_OVERSIGHT):
            break
        left = request.budget or 0
        part = replace(request, budget=left if number == ROUNDS else left // 2, seed=request.seed + number)
        if part.exhausted():
            break
        tighter += SPARE * missed.excess
        reach = BESIDE * (whole.upper - whole.lower)
        box = np.maximum(whole.lower, missed.x - reach), np.minimum(whole.upper, missed.x + reach)
        nlp = make(task.changed(limits=tightened(task, tighter)), DENSER**number, box)
        found = search(nlp, part, missed.x[None])
        searches.append(found)
        request = request.less(found.evaluations, found.seconds)
        if found.feasible:
            missed, answer = look_between(task, nlp, found.x), found
    message = f"{answer.message} {len(searches) - 1} searches beside it looked between samples." * (len(searches) > 1)
    return answer.paying_for(searches, message=message or answer.message, history=solution.history)
