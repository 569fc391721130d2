"""Tasks that give the duration of every gap: solved with held knots first, which without torques is convex.

Free knots inside given durations make one problem with many optima of it: where limits are broken between samples,
the peak wanders from segment to segment as points are added.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ocp_traj.solvers.gradient.account import Account
from ocp_traj.solvers.gradient.attempt import refine
from ocp_traj.solvers.gradient.plugin_call import Answer
from ocp_traj.solvers.gradient.ranking import best_answer, is_feasible
from ocp_traj.solvers.gradient.settings import GradientSettings
from ocp_traj.solvers.mending import tightened
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.curve import build_trajectory
from ocp_traj.transcription.guess import initial_guess

DRAWN_IN = (1e-3, 1e-4)
"""Fractions by which limits are drawn in where evenly spaced knots allow no motion, tried in turn."""


def gives_durations(task: TrajectoryTask) -> bool:
    """Return whether the durations of all gaps are given, and knots are free inside."""
    gaps = np.asarray(task.objective.gap_durations)
    return bool((gaps[:, 0] == gaps[:, 1]).all()) and task.virtual_knots > 0 and task.family.has_lifted_form


def attempt_held(task: TrajectoryTask, settings: GradientSettings, account: Account) -> Answer:
    """Return the best answer with evenly spaced knots held, with free ones from there, and with those held again.

    Where evenly spaced knots allow no motion, free ones are found within limits drawn in a little.
    """
    even = refine(task, evenly_spaced(task), settings, account, warm=False, held=True)
    found = [even]
    if even.solved:
        tries = [(task, even.trajectory, settings.tuning.freeing_iterations)]
    else:
        drawn_in = [task.changed(limits=tightened(task, part)) for part in DRAWN_IN]
        tries = [(tight, initial_guess(task), settings.iterations) for tight in drawn_in]
    for tight, start, iterations in tries:
        if account.exhausted():
            break
        some = replace(settings, iterations=min(iterations, settings.iterations))
        free = refine(tight, start, some, account, warm=even.solved)
        found.append(free)
        if not is_feasible(task, free.trajectory) and not account.exhausted():
            found.append(refine(task, free.trajectory, settings, account, warm=True, held=True))
        if any(is_feasible(task, answer.trajectory) for answer in found):
            break
    return best_answer(task, found)


def evenly_spaced(task: TrajectoryTask) -> Trajectory:
    """Return a motion through the first guess's positions with evenly spaced knots in every gap."""
    guess = initial_guess(task)
    share = np.repeat(guess.segment_durations / (task.virtual_knots + 1), task.virtual_knots + 1)
    positions = np.array(guess(np.concatenate([[0.0], np.cumsum(share)])))
    positions[:: task.virtual_knots + 1] = task.waypoints
    return build_trajectory(task, share, positions)
