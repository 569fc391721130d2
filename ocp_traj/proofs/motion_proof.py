"""Proofs that a motion keeps every limit of a task at every instant."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from ocp_traj.proofs import checker
from ocp_traj.proofs.not_proved import NotProved
from ocp_traj.proofs.resolve import hexadecimal_values, resolve_motion, resolve_task
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

ROOM = 1e-9
"""Relative amount by which claimed costs are raised: the nodes of another platform may differ in their last bits."""


def prove(task: TrajectoryTask, trajectory: Trajectory) -> dict[str, Any]:
    """Return the proof that a motion keeps every limit, with its duration and upper bounds of its weighted costs.

    Parameters
    ----------
    task : TrajectoryTask
    trajectory : Trajectory

    Returns
    -------
    dict
        The document of a proof file; `write_proof` writes it, `check_file` checks it.

    Raises
    ------
    NotProved
        A limit does not hold, cannot be shown to hold, or is not covered; says which.
    """
    section = resolve_task(task)
    curve = resolve_motion(task, trajectory)
    try:
        resolved = checker.read_task(section)
        motion = checker.read_motion(curve, resolved)
        costs = checker.check_motion(resolved, motion)
    except (checker.Refused, checker.NotAProof) as reason:
        raise NotProved(str(reason)) from None
    duration = rounded_up(motion.times[-1] - motion.times[0])
    exact = ("time", *checker.EXACT_COSTS)
    upper = {
        name: rounded_up(cost) if name in exact else float(cost) * (1.0 + ROOM) for name, cost in costs.items()
    }
    claim = {"duration": duration.hex(), "costs": hexadecimal_values(upper)}
    return {"schema": 1, "kind": "motion", "task": section, "motion": curve, "claim": claim, "evidence": {}}


def rounded_up(exact: Fraction) -> float:
    """Return the least float that is not below a rational number."""
    value = float(exact)
    return value if Fraction(value) >= exact else math.nextafter(value, math.inf)
