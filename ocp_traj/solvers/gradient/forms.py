"""The numerical problem a gradient solver gets: the lifted form, or the condensed one of families without."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from ocp_traj.arrays import read_only
from ocp_traj.solvers.gradient.account import Account
from ocp_traj.solvers.gradient.plugins import plugin_named
from ocp_traj.solvers.gradient.settings import GradientSettings
from ocp_traj.spline import get_family
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.condensed.condensed import CondensedNlp
from ocp_traj.transcription.lifted.layout import Layout
from ocp_traj.transcription.lifted.lifted import ExtraPoints, LiftedNlp
from ocp_traj.transcription.nlp import Nlp

NO_POINTS = ExtraPoints()


def build_nlp(
    task: TrajectoryTask,
    guess: Trajectory,
    settings: GradientSettings,
    account: Account,
    *,
    extra: ExtraPoints = NO_POINTS,
    layout: Layout | None = None,
    samples: int = 0,
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
    """
    clock = time.perf_counter()
    nlp: Nlp
    if get_family(task.family).takes_virtual_knots:
        compiled = settings.compiled and plugin_named(settings.plugin).own_derivatives
        nlp = LiftedNlp(task, guess, samples or settings.samples, extra, layout=layout, compiled=compiled)
    else:
        first = max(settings.samples, settings.tuning.condensed_samples)
        nlp = condensed_from(task, guess, settings, samples or first)
    account.build_time += time.perf_counter() - clock
    return nlp


def condensed_from(
    task: TrajectoryTask, guess: Trajectory, settings: GradientSettings, samples: int, extrema: str = "auto"
) -> CondensedNlp:
    """Return the condensed form in logarithms of the durations, started from a guess."""
    durations, wide = np.asarray(guess.segment_durations), settings.tuning.duration_range
    search = replace(task.search, duration=(float(durations.min()) / wide, float(durations.max()) * wide))
    nlp = CondensedNlp(
        task.changed(search=search), encoding="log-durations", samples=samples, extrema=extrema
    )
    nlp.task = task
    nlp.guess = read_only(np.clip(nlp.encode(guess), nlp.lower, nlp.upper))
    return nlp
