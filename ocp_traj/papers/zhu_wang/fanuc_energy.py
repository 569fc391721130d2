"""Energies of the motions of Zhu and Wang (paper D): their outlook, with inertia from FANUC's robot description."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ocp_traj.comparison.report.document import Table
from ocp_traj.papers.measures import number
from ocp_traj.papers.motions import certified_optimum
from ocp_traj.papers.paper import table_of
from ocp_traj.papers.records import Records
from ocp_traj.papers.zhu_wang.claims import PUBLISHED, UNOPTIMISED
from ocp_traj.papers.zhu_wang.fanuc_inertia import SOURCE, with_inertia

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask


def energy_table(task: TrajectoryTask, records: Records) -> Table:
    """Return durations and energies of known motions and of the least-energy ones within given times."""
    shortest = certified_optimum(task, records)["durations"]
    found = records.computed("energies", lambda: {"rows": _compute_energies(with_inertia(task), shortest)})
    rows = [(row["motion"], number(row["duration"]), number(row["energy"], 1)) for row in found["rows"]]
    return table_of(
        "Our extension: energy, the paper's outlook",
        ("motion", "duration, s", "energy, J"),
        rows,
        f"Integral of the sum of |torque times velocity|; inertia of the links from {SOURCE}, without payload, "
        "rotors, friction and gravity balancing, which it does not state.",
    )


def _compute_energies(task: TrajectoryTask, shortest: list[float]) -> list[dict[str, Any]]:
    from ocp_traj.audit.costs import energy
    from ocp_traj.solving import solve
    from ocp_traj.task import Objective
    from ocp_traj.transcription import trajectory_from_durations

    known = {
        "certified shortest": shortest,
        "printed durations": PUBLISHED,
        "unoptimised, 2 s a segment": UNOPTIMISED,
    }
    rows: list[dict[str, Any]] = []
    for words, durations in known.items():
        motion = trajectory_from_durations(task, durations)
        rows.append({"motion": words, "duration": motion.duration, "energy": energy(task, motion)})
    for allowed in (1.5, sum(PUBLISHED), sum(UNOPTIMISED)):
        economical = replace(task, objective=Objective(energy=1.0, duration=(0.1, allowed)))
        result = solve(economical, "de", seed=0, budget=10_000)
        verdict = "" if result.feasible else ", not feasible"
        rows.append(
            {
                "motion": f"least energy within {allowed:.3f} s (DE, 10 000 evaluations{verdict})",
                "duration": result.duration,
                "energy": result.energy,
            }
        )
    return rows
