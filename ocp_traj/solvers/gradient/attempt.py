"""One start of a gradient solver: few knots first, then all, then the points between samples."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from ocp_traj.exceptions import InputError, TaskError
from ocp_traj.limits import instant_limits
from ocp_traj.solvers.gradient.account import Account
from ocp_traj.solvers.gradient.plugin_call import Answer, call_plugin, condensed_from
from ocp_traj.solvers.gradient.plugins import plugin_named
from ocp_traj.solvers.gradient.refinement import broken_points, new_points
from ocp_traj.solvers.gradient.settings import GradientSettings
from ocp_traj.solvers.mending import can_be_mended
from ocp_traj.spline import Family
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.guess import initial_guess, insert_knots
from ocp_traj.transcription.lifted.layout import Layout
from ocp_traj.transcription.lifted.lifted import ExtraPoints, LiftedNlp
from ocp_traj.transcription.nlp import Nlp

NO_POINTS = ExtraPoints()


def attempt(
    task: TrajectoryTask,
    guess: Trajectory | None,
    settings: GradientSettings,
    account: Account,
    *,
    continued: bool,
) -> Answer:
    """Solve from one start: few knots first if wanted, then the task with points added until none is broken.

    Parameters
    ----------
    task : TrajectoryTask
    guess : Trajectory or None
        A motion to start from, of any family; None takes the closed-form timing.
    settings : GradientSettings
    account : Account
        Pays for it.
    continued : bool
        Whether motions with fewer virtual knots are solved first, from as many on as the guess has.
    """
    if continued:
        own = 0 if guess is None else (len(guess.breakpoints) - 1) // task.gaps - 1
        for knots in [each for each in continuation(task.family, task.virtual_knots)[:-1] if each >= own]:
            guess = _solve_few_knots(task, knots, guess, settings, account)
    start = initial_guess(task) if guess is None else fit_guess(task, guess)
    rough = min(settings.tuning.rough_rounds, settings.rounds) if _starts_roughly(task, settings) else 0
    return refine(task, start, settings, account, warm=guess is not None, rough=rough)


def refine(
    task: TrajectoryTask,
    start: Trajectory,
    settings: GradientSettings,
    account: Account,
    *,
    warm: bool,
    rough: int = 0,
    held: bool = False,
) -> Answer:
    """Solve, add what is found broken and solve again.

    Parameters
    ----------
    task : TrajectoryTask
    start : Trajectory
        Of the task's family, with its knots.
    settings : GradientSettings
    account : Account
        Pays for it.
    warm : bool
        The start is near the answer.
    rough : int
        Rounds at first that are solved loosely only; when one fails after these, all is done again without them.
    held : bool
        Hold the durations of all segments at the start's.
    """
    extra, samples, answer, loose = NO_POINTS, 0, None, False
    tuning, nlp = settings.tuning, build_nlp(task, start, settings, account, held=held)
    for _ in range(settings.rounds + 1):
        found = call_plugin(nlp, loosened(settings) if rough else settings, account, warm=warm, before=answer)
        if not found.solved:
            if loose and not account.exhausted():  # a motion that is only nearly the best is no answer
                return refine(task, start, settings, account, warm=warm, held=held)
            if answer is None or not can_be_mended(task, answer.trajectory):
                return found
            return replace(answer, message=found.message, status=found.status if loose else answer.status)
        answer, loose = found, rough > 0
        layout = nlp.layout if isinstance(nlp, LiftedNlp) else None
        moving = np.arange(task.n) if layout is None else layout.moving
        broken = broken_points(task, answer.trajectory, moving, settings.peaks, compiled=settings.compiled)
        fresh = broken if layout is None else new_points(extra, broken, settings.peaks)
        if fresh and samples <= tuning.most_samples:
            if layout is None:  # the condensed form takes no points, so take more samples everywhere
                samples = 2 * max(samples, tuning.condensed_samples)
            extra, rough = extra.joined(fresh), max(0, rough - 1)
            motion = answer.trajectory
            nlp = build_nlp(
                task, motion, settings, account, extra=extra, layout=layout, samples=samples, held=held
            )
        elif rough:
            rough = 0
        else:
            return answer
    assert answer is not None
    return answer


def build_nlp(
    task: TrajectoryTask,
    guess: Trajectory,
    settings: GradientSettings,
    account: Account,
    *,
    extra: ExtraPoints = NO_POINTS,
    layout: Layout | None = None,
    samples: int = 0,
    held: bool = False,
) -> Nlp:
    """Return the lifted form, or the condensed one of families that have no other.

    Parameters
    ----------
    task : TrajectoryTask
    guess : Trajectory
        Of the task's family, with its knots.
    settings : GradientSettings
    account : Account
        Pays for it.
    extra : ExtraPoints
        Points of the lifted form whose limits are kept besides its samples.
    layout : Layout, optional
        Of the same task's earlier problem.
    samples : int
        Samples per gap; 0 leaves them to the settings.
    held : bool
        Hold the durations of all segments at the guess's, in the lifted form.
    """
    clock = time.perf_counter()
    nlp: Nlp
    if task.family.has_lifted_form:
        compiled = settings.compiled and plugin_named(settings.plugin).own_derivatives
        first = samples or settings.samples
        nlp = LiftedNlp(task, guess, first, extra, layout=layout, compiled=compiled, held=held)
    else:
        first = max(settings.samples, settings.tuning.condensed_samples)
        nlp = condensed_from(task, guess, settings, samples or first)
    account.build_time += time.perf_counter() - clock
    return nlp


def loosened(settings: GradientSettings) -> GradientSettings:
    """Return the settings of a call that only has to give a start."""
    return replace(settings, tolerance=max(settings.tuning.loose_tolerance, settings.tolerance))


def _starts_roughly(task: TrajectoryTask, settings: GradientSettings) -> bool:
    """Return whether the first rounds of added points are solved loosely only."""
    follows = plugin_named(settings.plugin).takes_multipliers and task.family.has_lifted_form
    return follows and bool(instant_limits(task))


def _solve_few_knots(
    task: TrajectoryTask,
    knots: int,
    guess: Trajectory | None,
    settings: GradientSettings,
    account: Account,
) -> Trajectory | None:
    """Return a motion with fewer virtual knots, None where there is none."""
    try:
        stage = task.changed(virtual_knots=knots, boundary=task.boundary)
    except TaskError:  # too few knots for the boundary conditions
        return guess
    start = initial_guess(stage) if guess is None else fit_guess(stage, guess)
    nlp = build_nlp(stage, start, settings, account)
    short = replace(settings, iterations=min(settings.tuning.few_knots_iterations, settings.iterations))
    answer = call_plugin(nlp, loosened(short), account, warm=guess is not None)
    return answer.trajectory if answer.solved else guess


def continuation(family: Family, virtual_knots: int) -> list[int]:
    """Return the numbers of virtual knots to solve one after the other, the last one the number wanted.

    One knot leads a cubic to good optima; higher degrees with knots are solved from the motion without any.
    """
    first = family.first_virtual_knots
    stages = [virtual_knots]
    while stages[0] > 7:
        stages.insert(0, (stages[0] - 1) // 2)
    return [first, *stages] if stages[0] > first else stages


def fit_guess(task: TrajectoryTask, trajectory: Trajectory) -> Trajectory:
    """Return a motion of the task's family and knots that starts near a given one."""
    same = trajectory.family == task.family
    wanted = task.gaps * (task.virtual_knots + 1)
    if len(trajectory.waypoint_times) != task.gaps + 1:
        raise InputError(
            f"the motion to start from passes {len(trajectory.waypoint_times)} waypoints, expected {task.gaps + 1}"
        )
    if same and len(trajectory.breakpoints) - 1 == wanted:
        return trajectory
    if same and task.virtual_knots and len(trajectory.breakpoints) - 1 < wanted:
        return insert_knots(trajectory, task.virtual_knots)
    return initial_guess(task, trajectory.segment_durations)
