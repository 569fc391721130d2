"""From a task to a numerical problem: nothing else builds x, f and g."""

from __future__ import annotations

from ocp_traj.exceptions import InputError
from ocp_traj.task import TrajectoryTask
from ocp_traj.task.preparing import prepare
from ocp_traj.transcription.condensed.condensed import CondensedNlp
from ocp_traj.transcription.condensed.encodings import Encoding
from ocp_traj.transcription.curve import (
    build_trajectory,
    trajectory_from_durations,
)
from ocp_traj.transcription.guess import initial_guess, insert_knots
from ocp_traj.transcription.lifted.lifted import ExtraPoints, LiftedNlp
from ocp_traj.transcription.nlp import Nlp

FORMS = ("condensed", "lifted")


def transcribe(
    task: TrajectoryTask,
    form: str = "condensed",
    encoding: str | type[Encoding] = "durations",
    samples: int = 16,
    offsets: str = "spline",
) -> Nlp:
    """Return a task as a numerical problem, to look at or to solve.

    Parameters
    ----------
    task : TrajectoryTask
    form : str
        ``"condensed"``: durations (and offsets of virtual knots) alone, as in the papers. ``"lifted"``: every
        knot's state, tied by continuity equations; what gradient solvers get.
    encoding : str or Encoding class
        Of the condensed form: ``"durations"``, ``"log-durations"``, ``"scaled"``, or one of your own.
    samples : int
        Samples a gap of limits that have no closed-form extrema.
    offsets : str
        Of the condensed form: whether virtual knots are measured from the ``"spline"`` through the waypoints or from
        the ``"chord"``.

    Returns
    -------
    Nlp
        A `metaheuristics.Problem` with symbols ``x``, ``f``, ``g`` and labelled rows, of the task made ready
        (`ocp_traj.task.prepare`); `Nlp.decode` gives motions of the task itself.

    Raises
    ------
    InputError
        The form or the encoding is unknown, or the family has no such form.
    """
    prepared = prepare(task)
    ready = prepared.task
    if form == "condensed":
        return CondensedNlp(ready, encoding=encoding, samples=samples, offsets=offsets).restoring(prepared)
    if form == "lifted":
        if not task.family.has_lifted_form:
            raise InputError(f"{task.family} has the condensed form only, expected form 'condensed'")
        return LiftedNlp(ready, initial_guess(ready), samples, ExtraPoints()).restoring(prepared)
    raise InputError(f"form {form!r} is unknown, expected one of {', '.join(FORMS)}")


__all__ = [
    "FORMS",
    "CondensedNlp",
    "ExtraPoints",
    "LiftedNlp",
    "build_trajectory",
    "initial_guess",
    "insert_knots",
    "trajectory_from_durations",
    "transcribe",
]
