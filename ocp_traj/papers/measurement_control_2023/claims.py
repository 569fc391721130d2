"""What paper A claims and how it calls its methods; every claim held against the records."""

from __future__ import annotations

from ocp_traj.papers.drawings import best_motion
from ocp_traj.papers.experiments import PUBLISHED_PROTOCOL
from ocp_traj.papers.measures import STAND_IN, claim_first, claim_last, claim_order, spread_of
from ocp_traj.papers.paper import Claim, Paper
from ocp_traj.papers.records import Records

ISSA, SSA, PSO = "ISSA of A", "SSA", "PSO"
"""The paper's methods."""


def claims(paper: Paper, records: Records) -> list[Claim]:
    """Return every claim of paper A with what was measured."""
    energies = {label: records.values(label, "energy", PUBLISHED_PROTOCOL) for label in (ISSA, SSA, PSO)}
    return [
        claim_order("energy: ISSA < SSA < PSO", "Fig. 2, text", energies, "J", where=STAND_IN),
        *_speed_claims(paper, records),
        *_motion_claims(paper, records),
        Claim(
            "printed energies, running times and time series",
            "Tables 1 to 3",
            "lost in the text we have",
            "cannot be checked",
        ),
    ]


def _speed_claims(paper: Paper, records: Records) -> list[Claim]:
    spent, seconds, evaluations = (
        {label: records.raw(label, field, PUBLISHED_PROTOCOL) for label in (ISSA, SSA, PSO)}
        for field in ("generations", "processor", "evaluations")
    )
    return [
        Claim(
            "PSO converges after 43 generations",
            "Fig. 2, text",
            f"PSO {spread_of(spent[PSO], 0)} of {paper.protocol.generations} generations, median and quartiles",
            "another case (stand-in); one run there",
        ),
        claim_last("PSO converges slowest of the three", "Fig. 2, text", spent, "generations", STAND_IN),
        claim_first(
            "ISSA's average running time is significantly lower than that of SSA and PSO",
            "Table 2 (lost), text, 20 runs; here processor time",
            seconds,
            "s",
            STAND_IN,
        ),
        Claim(
            "equal population and generations compare the methods fairly",
            "implied by section 4",
            "evaluations really spent: "
            + ", ".join(f"{label} {int(values[0])}" for label, values in evaluations.items()),
            "does not hold: scouts, opposite points and mutants cost evaluations",
        ),
    ]


def _motion_claims(paper: Paper, records: Records) -> list[Claim]:
    from ocp_traj.audit import audit

    motion = best_motion(paper.task(), records.runs(ISSA, PUBLISHED_PROTOCOL), "energy")
    if motion is None:
        return []
    verdict = audit(paper.task(), motion)
    exact = verdict.boundary_error <= 1e-8 and verdict.waypoint_error <= 1e-8
    return [
        Claim(
            "velocity, acceleration and jerk are zero at start and end, and every point is met",
            "Figs. 3 to 6",
            f"ISSA's best motion: ends missed by {verdict.boundary_error:.1g} of the limits, points by "
            f"{verdict.waypoint_error:.1g} rad",
            "holds" if exact else "does not hold",
        ),
        Claim(
            "the motion keeps the kinematic limits",
            "conclusion 3",
            "ISSA's best motion keeps every limit" if verdict.feasible else verdict.findings[0],
            "holds" if verdict.feasible else "does not hold",
        ),
    ]
