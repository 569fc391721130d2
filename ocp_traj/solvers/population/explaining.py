"""Why a search of the condensed form found no feasible motion: the box it searched, or the limit broken most."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from metaheuristics import Solution, Status
from ocp_traj.arrays import Array
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.condensed.condensed import CondensedNlp

AT_BOUND = 0.01
"""A duration counts as at a bound of the search when it is nearer than this fraction of the bound."""


def explained(nlp: CondensedNlp, solution: Solution) -> tuple[Solution, str]:
    """Return the solution of a search, and why it is not feasible; empty where it is.

    That no candidate kept the limits proves nothing of the task, so such a search has stalled. `search.duration`
    belongs to it, not to the task, and is named where it stands in the way.

    Parameters
    ----------
    nlp : CondensedNlp
    solution : metaheuristics.Solution
        With the word for "no candidate that keeps every limit was found", or any other.
    """
    if solution.status is not Status.INFEASIBLE:
        return solution, ""
    stalled = replace(solution, status=Status.STALLED)
    forbidden = outside_search(nlp.task)
    if forbidden:
        return stalled, f"No motion was found: {forbidden}."
    worst = nlp.label(int(np.argmax(solution.violation))) if len(solution.violation) else ""
    reason = f"the best candidate breaks {worst} most" if worst else "no candidate kept every limit"
    return stalled, f"No motion was found: {reason}{_at_bound(nlp, solution.x)}."


def outside_search(task: TrajectoryTask) -> str:
    """Return which bound of `search.duration` no motion of the task can keep, by its velocity limits; empty if none."""
    low, high = np.asarray(task.search.duration)
    needed, joints = fastest_gaps(task)
    gap = int(np.argmax(needed))
    if needed[gap] > high * (1.0 + 1e-9):
        return (
            f"search.duration binds: gaps of at most {high:.6g} s are searched, but gap {gap + 1} takes joint "
            f"{joints[gap] + 1} at least {needed[gap]:.6g} s at its velocity limit"
        )
    longest = float(np.asarray(task.objective.duration)[1])
    if low * task.gaps > longest * (1.0 + 1e-9):
        return (
            f"search.duration binds: gaps of at least {low:.6g} s are searched, together {low * task.gaps:.6g} s, "
            f"but the motion may last at most {longest:.6g} s"
        )
    bounds = np.asarray(task.objective.gap_durations)
    outside = np.flatnonzero((bounds[:, 0] > high * (1.0 + 1e-9)) | (bounds[:, 1] < low * (1.0 - 1e-9)))
    if outside.size:
        least, most = bounds[outside[0]]
        return (
            f"search.duration binds: gaps of {low:.6g} to {high:.6g} s are searched, but gap {outside[0] + 1} has to "
            f"last {least:.6g} to {most:.6g} s"
        )
    return ""


def fastest_gaps(task: TrajectoryTask) -> tuple[Array, Array]:
    """Return how long each gap takes at full speed, (K - 1,) s, and the joint that decides, from 0."""
    slack = np.asarray(task.tolerance)
    travel = np.diff(task.waypoints, axis=0)
    least = np.maximum(np.abs(travel) - slack[1:] - slack[:-1], 0.0)
    limit = task.limits.get("velocity")
    speed = np.where(travel > 0, limit[:, 1], -limit[:, 0])
    needed = np.divide(least, speed, out=np.zeros_like(least), where=(least > 0) & (speed > 0))
    return needed.max(axis=1), needed.argmax(axis=1)


def _at_bound(nlp: CondensedNlp, x: Array) -> str:
    """Say which gap of the best candidate lasts as long as is searched at most, if one does."""
    if nlp.encoding.decides_speed or not np.isfinite(x).all():
        return ""
    high = float(np.asarray(nlp.task.search.duration)[1])
    gaps = nlp.durations(x[None, :])[0].reshape(nlp.task.gaps, -1).sum(axis=1)
    longest = int(np.argmax(gaps))
    if gaps[longest] < high * (1.0 - AT_BOUND):
        return ""
    return f"; search.duration binds: its gap {longest + 1} lasts as long as is searched at most, {high:.6g} s"
