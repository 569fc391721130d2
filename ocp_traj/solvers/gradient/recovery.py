"""What a gradient solver does after a failed start: try from elsewhere, or explain why there is no solution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from metaheuristics import Status
from ocp_traj.exceptions import TaskError
from ocp_traj.solvers.gradient.account import Account
from ocp_traj.solvers.gradient.attempt import attempt, build_nlp, continuation, fit_guess
from ocp_traj.solvers.gradient.plugin_call import Answer, first_point
from ocp_traj.solvers.gradient.reasons.diagnosis import too_short
from ocp_traj.solvers.gradient.reasons.elastic import elastic_phase
from ocp_traj.solvers.gradient.reasons.reach import proved_longer
from ocp_traj.solvers.gradient.settings import GradientSettings
from ocp_traj.solvers.gradient.slow import slow_motion
from ocp_traj.solvers.gradient.starts import other_starts
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.lifted.lifted import LiftedNlp

NOT_FOUND = "No motion was found. In the way: "


def recover(
    task: TrajectoryTask, failed: Answer, settings: GradientSettings, account: Account
) -> tuple[Answer, str]:
    """Try again from elsewhere after a failure, or explain it; return an answer and the explanation.

    A motion with fewer virtual knots is a start, and the answer if that fails too: the task contains it. So is a
    slow motion in closed form. Only a proof makes the status `infeasible`; else the answer stalled, and what stood in
    the way is named: a shortest motion that takes too long, or the limits that the elastic phase had to break. As
    that looks near its start only, more starts have to fail, too.
    """
    if failed.status is Status.TIME_EXHAUSTED:
        return failed, ""
    contained = with_fewer_knots(task, failed, settings, account)
    if contained is not None:
        answer = attempt(task, contained.trajectory, settings, account, continued=False)
        return (answer if answer.solved else contained), ""
    proof = "" if account.exhausted() else proved_longer(task, account.left.time_limit)
    if proof:
        return replace(failed, status=Status.INFEASIBLE), proof

    def shortest(longer: TrajectoryTask, sampled: bool) -> float | None:
        kept = replace(settings, rounds=0) if sampled else settings
        answer = attempt(longer, None, kept, account, continued=True)
        return answer.trajectory.duration if answer.solved else None

    sentence = too_short(task, shortest)
    if sentence:
        return replace(failed, status=Status.STALLED), NOT_FOUND + sentence
    best, possible = from_slow_motion(task, failed, settings, account)
    sentence = ""
    if not best.solved:
        best, sentence = relax(task, best, settings, account)
    count = settings.attempts - 1
    if sentence:
        most = min(settings.iterations, settings.tuning.confirming_iterations)
        count, settings = settings.tuning.confirming_starts, replace(settings, iterations=most)
    best = try_elsewhere(task, best, count, settings, account)
    if best.solved:
        return best, ""
    stop = account.exhausted()
    if stop is not None:
        return replace(best, status=stop), ""
    if best.status is Status.INFEASIBLE or sentence:  # the word of a solver that looked near its start only
        best = replace(best, status=Status.STALLED)
    return best, NOT_FOUND + sentence if sentence and not possible else ""


def from_slow_motion(
    task: TrajectoryTask, failed: Answer, settings: GradientSettings, account: Account
) -> tuple[Answer, bool]:
    """Start from a slow motion in closed form; return the better answer, and whether there is such a motion."""
    slow = None if account.exhausted() else slow_motion(task)
    if slow is None:
        return failed, False
    answer = attempt(task, slow, settings, account, continued=False)
    return min(failed, answer, key=lambda each: each.rank), True


def try_elsewhere(
    task: TrajectoryTask, best: Answer, count: int, settings: GradientSettings, account: Account
) -> Answer:
    """Return the best answer after up to `count` other starts, which end with the first solution."""
    starts = other_starts(task, np.random.default_rng(account.request.seed), count)
    while not best.solved and not account.exhausted() and (guess := next(starts, None)) is not None:
        answer = attempt(task, guess, settings, account, continued=False)
        best = min(best, answer, key=lambda each: each.rank)
    return best


def with_fewer_knots(
    task: TrajectoryTask, failed: Answer, settings: GradientSettings, account: Account
) -> Answer | None:
    """Return the best motion with fewer virtual knots, its knots inserted; the status stays the failure's."""
    if not isinstance(failed.nlp, LiftedNlp) or failed.status is Status.INFEASIBLE:
        return None
    fewer = {0, *continuation(task.family, task.virtual_knots)} - {task.virtual_knots}
    for knots in sorted(fewer, reverse=True):
        if account.exhausted():
            break
        try:
            smaller = task.changed(virtual_knots=knots, boundary=task.boundary)
        except TaskError:  # too few knots for the boundary conditions
            continue
        answer = attempt(smaller, None, settings, account, continued=knots > 0)
        if answer.solved:
            motion = fit_guess(task, answer.trajectory)
            nlp = build_nlp(task, motion, settings, account)
            message = (
                f"{failed.message}; the motion is the best one found with {knots} virtual knots per gap, "
                f"which the task with {task.virtual_knots} contains."
            )
            return replace(first_point(nlp, message), trajectory=motion, status=failed.status)
    return None


def relax(
    task: TrajectoryTask, failed: Answer, settings: GradientSettings, account: Account
) -> tuple[Answer, str]:
    """Start from motions of the elastic phase until one leads to a solution or a conflict has a name.

    An attempt may fail when points between samples are added; the elastic phase then takes those, too.
    """
    best = answer = failed
    for _ in range(settings.tuning.elastic_phases):
        if account.exhausted() or not (isinstance(answer.nlp, LiftedNlp) and answer.nlp.derivatives):
            break
        least = elastic_phase(answer.nlp, np.asarray(answer.nlp.guess), account, settings.tuning)
        if least is None:
            break
        if least.excess > settings.tuning.conflict_excess:
            return best, least.sentence
        answer = attempt(task, least.trajectory, settings, account, continued=False)
        best = min(best, answer, key=lambda each: each.rank)
        if best.solved:
            break
    return best, ""
