"""What of a condensed problem's derivatives can be built in the time that is left.

CasADi differentiates the closed forms of a whole spline, which for many joints and waypoints takes seconds that no
solver's own time limit sees. The time its symbols took tells how long that will be.
"""

from __future__ import annotations

from ocp_traj.transcription.condensed.condensed import CondensedNlp
from ocp_traj.transcription.nlp import Nlp

EXACT_WORK = 9.0
"""First and second derivatives take about so many times as long to build as the symbols of the problem."""

GRADIENT_WORK = 3.5
"""The same of first derivatives alone."""

NO_TIME = "The time limit left no time to build the problem's derivatives; the motion is the one started from."


def derivatives_in_time(nlp: Nlp, seconds: float | None) -> tuple[int, float | None]:
    """Return the highest order of derivatives, 2, 1 or 0, that can be built in time, and the seconds left then.

    Parameters
    ----------
    nlp : Nlp
        Only the condensed form is slow to differentiate; its symbols are made here.
    seconds : float or None
        Left when this is asked; None without a time limit.
    """
    if seconds is None or not isinstance(nlp, CondensedNlp):
        return 2, seconds
    unit = nlp.symbol_seconds
    left = seconds - unit
    for order, work in ((2, EXACT_WORK), (1, GRADIENT_WORK)):
        if work * unit <= left:
            return order, left - work * unit
    return 0, left
