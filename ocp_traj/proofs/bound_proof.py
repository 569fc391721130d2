"""Proofs that no motion is shorter."""

from __future__ import annotations

import math
import time
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal

from ocp_traj.proofs import checker
from ocp_traj.proofs.box_search import BoxSearch
from ocp_traj.proofs.family_leaves import FamilyLeaves
from ocp_traj.proofs.lemmas import prove_lemmas
from ocp_traj.proofs.not_proved import NotProved
from ocp_traj.proofs.resolve import resolve_task

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask

Of = Literal["every motion", "3-5-3"]

WIDER = 3e-6
"""Relative amount by which a bound falls where limits may be exceeded by 1e-6 and waypoints be missed by 1e-8."""
LEMMA_GAPS = 4
"""Gaps from which runs of gaps are proved first."""


def prove_bound(
    task: TrajectoryTask, time_limit: float = 60.0, *, duration: float | None = None, of: Of = "every motion"
) -> dict[str, Any]:
    """Return the proof that no motion is shorter than a duration.

    Parameters
    ----------
    task : TrajectoryTask
        At rest at both ends.
    time_limit : float
        Seconds for the search of evidence.
    duration : float, optional
        What to prove, s; the certified bound of `kinematic_bound`, or for the family of `certify`, when left out.
    of : {"every motion", "3-5-3"}
        Every motion of continuous velocity within the velocity and acceleration limits, or only the 3-5-3 curves.

    Returns
    -------
    dict
        The document of a proof file.

    Raises
    ------
    NotProved
        No evidence was found, or the task is not covered; says why.
    """
    section = resolve_task(task)
    resolved = checker.read_task(section)
    deadline = time.monotonic() + time_limit
    if duration is None:
        duration = _certified(task, of, time_limit)
    if not (math.isfinite(duration) and duration > 0):
        raise NotProved(f"a duration of {duration} s has no proof, expected a positive number")
    total = Fraction(duration)
    search = checker.Search(resolved, total, checker.chain(resolved, total), of == "3-5-3")
    lemmas: list[dict[str, Any]] = []
    if of == "3-5-3":
        refute = FamilyLeaves(search) if resolved.gaps == 3 else None
        tree = BoxSearch(search, 0, resolved.gaps, total, deadline, refute).run()
    else:
        if resolved.gaps >= LEMMA_GAPS:
            lemmas = prove_lemmas(search, deadline)
        tree = BoxSearch(search, 0, resolved.gaps, total, deadline).run()
    evidence = {"lemmas": lemmas, "tree": tree}
    try:
        checker.check_bound(resolved, total, of == "3-5-3", evidence)
    except (checker.Refused, checker.NotAProof) as reason:
        raise NotProved(str(reason)) from None
    claim = {"duration": duration.hex(), "of": of}
    return {"schema": 1, "kind": "bound", "task": section, "motion": None, "claim": claim, "evidence": evidence}


def _certified(task: TrajectoryTask, of: Of, time_limit: float) -> float:
    """Return the bound that floating-point arithmetic certifies, a little lowered.

    Raises
    ------
    NotProved
        There is none; says why.
    """
    from ocp_traj.references import certify, kinematic_bound

    if of == "3-5-3":
        found = certify(task, time_limit=time_limit)
        lower, message = found.lower, found.message
    else:
        bound = kinematic_bound(task, time_limit=0.5 * time_limit)
        lower, message = bound.lower, bound.message
    if not lower:
        raise NotProved(message)
    return float(lower) * (1.0 - WIDER)
