"""What Ma et al. 2024 (paper B) print and claim; every claim held against the records."""

from __future__ import annotations

import numpy as np

from ocp_traj.audit import audit
from ocp_traj.comparison.report.statistics import quartiles
from ocp_traj.papers.experiments import PUBLISHED_PROTOCOL
from ocp_traj.papers.joints_apart import slowed_totals, totals
from ocp_traj.papers.measures import claim_gain, claim_order, number
from ocp_traj.papers.motions import certified_optimum, claim_smooth, joint_optima, synchronised_optima
from ocp_traj.papers.paper import Claim, Paper
from ocp_traj.papers.records import Records
from ocp_traj.transcription import trajectory_from_durations

ISSA, SSA, PSO = "ISSA of B", "SSA", "PSO"
"""The paper's methods."""

PUBLISHED_TOTALS = {ISSA: 3.17564, SSA: 3.33759, PSO: 3.77099}
"""Section 5, seconds; SSA's is called an average, the others are not said to be."""

SLOWED, RAW = ", once slowed into the limits", ", as synchronised, within the limits or not"
"""Two ways to compare totals; the paper says that its motions keep the limits."""

UNOPTIMISED = 6.0
"""2 s a segment, section 5."""

ACCURACY = ((2, SSA, 0.13), (2, PSO, 0.33), (3, PSO, 0.06), (4, SSA, 0.188), (4, PSO, 0.48), (5, SSA, 0.065),
            (5, PSO, 0.093), (6, SSA, 0.024), (6, PSO, 0.188))  # fmt: skip
"""Table 4: joint, compared with, gain of ISSA in the fitness reached."""

SPEED = ((4, SSA, 0.25), (4, PSO, 0.167), (5, SSA, 0.52), (5, PSO, 0.80), (6, SSA, 0.444), (6, PSO, 0.56))
"""Table 5: joint, compared with, gain of ISSA in generations to convergence."""


def claims(paper: Paper, records: Records) -> list[Claim]:
    """Return every claim of paper B with what was measured."""
    shared = certified_optimum(paper.task(), records)
    return [
        claim_order(f"total time{SLOWED}: ISSA < SSA < PSO", "section 5", slowed_totals(paper, records), "s"),
        claim_order(f"total time{RAW}: ISSA < SSA < PSO", "section 5", totals(paper, records), "s"),
        *_total_claims(paper, records),
        *(_joint_claim(records, "cost", *entry) for entry in ACCURACY),
        *(_joint_claim(records, "generations", *entry) for entry in SPEED),
        *_contradictions(),
        *_misprints(paper, shared["durations"]),
        claim_smooth(paper.task(), shared["durations"], "section 5, Fig. 7"),
    ]


def _total_claims(paper: Paper, records: Records) -> list[Claim]:
    task, found = paper.task(), totals(paper, records)
    optima = joint_optima(task, records)
    slowest = max(optima, key=lambda joint: float(optima[joint]["upper"]))
    together = sum(synchronised_optima(task, optima))
    shared = certified_optimum(task, records)
    mine = quartiles(found[ISSA])[1]
    return [
        Claim(
            "ISSA's motion takes 3.17564 s and keeps the kinematic limits",
            "section 5, Fig. 7",
            f"slowest joint alone (joint {slowest}) {number(optima[slowest]['upper'])} s; largest duration of each "
            f"segment over the joints {number(together)} s; least feasible with shared durations "
            f"{number(shared['upper'])} s (proved above {number(shared['lower'])} s)",
            "does not hold: 3.17564 s is none of the three, and below every feasible 3-5-3 motion",
        ),
        Claim(
            "47 % less than the unoptimised 6 s",
            "section 5",
            f"printed totals: {100 * (1 - PUBLISHED_TOTALS[ISSA] / UNOPTIMISED):.1f} %; our ISSA, feasible or not: "
            f"{100 * (1 - mine / UNOPTIMISED):.1f} %; feasible 3-5-3 optimum: "
            f"{100 * (1 - shared['upper'] / UNOPTIMISED):.1f} %",
            "arithmetic holds; for a feasible motion it does not",
        ),
        *(
            claim_gain(
                f"ISSA {100 * gain:.3g} % shorter than {other}{words}",
                "section 5",
                gain,
                column[ISSA],
                column[other],
            )
            for other, gain in ((SSA, 0.049), (PSO, 0.158))
            for words, column in ((SLOWED, slowed_totals(paper, records)), (RAW, found))
        ),
        Claim(
            "each joint's running time is reduced by 0.59535 s compared to the unoptimised model",
            "section 5",
            f"PSO minus ISSA of the printed totals: {PUBLISHED_TOTALS[PSO] - PUBLISHED_TOTALS[ISSA]:.5f} s; "
            f"unoptimised minus ISSA: {UNOPTIMISED - PUBLISHED_TOTALS[ISSA]:.5f} s",
            "contradiction inside the paper: it is the difference to PSO",
        ),
    ]


def _joint_claim(records: Records, field: str, joint: int, other: str, gain: float) -> Claim:
    """Judge an entry of Table 4 (``"cost"``) or Table 5 (``"generations"``)."""
    accuracy = field == "cost"
    sentence = (
        f"joint {joint}: ISSA's accuracy {100 * gain:.3g} % better than {other}'s"
        if accuracy
        else f"joint {joint}: ISSA converges in {100 * gain:.3g} % fewer generations than {other}"
    )
    return claim_gain(
        sentence,
        "Table 4" if accuracy else "Table 5",
        gain,
        records.part(ISSA, joint, field, PUBLISHED_PROTOCOL),
        records.part(other, joint, field, PUBLISHED_PROTOCOL),
        4 if accuracy else 0,
    )


def _contradictions() -> list[Claim]:
    table = {(joint, other): gain for joint, other, gain in ACCURACY}
    best = max(gain for _, other, gain in SPEED if other == SSA)
    return [
        Claim(
            "convergence up to 73 % faster than SSA",
            "text of section 5",
            f"the largest entry of Table 5 against SSA is {100 * best:.3g} % (joint 5)",
            "contradiction inside the paper",
        ),
        Claim(
            "joint 6: 2.4 % better accuracy than PSO",
            "text of section 5",
            f"Table 4 has 2.4 % against SSA and {100 * table[6, PSO]:.3g} % against PSO",
            "contradiction inside the paper",
        ),
        Claim(
            "joint 3: ISSA's accuracy is similar to SSA's",
            "text, Table 4 (a dash)",
            "see the table of joints",
            "no number is claimed",
        ),
        Claim(
            "the fitness curves of the methods hardly differ in joint 1",
            "text",
            "joint 1 has the same angle at all four points: it does not move, and its time means nothing",
            "holds trivially",
        ),
    ]


def _misprints(paper: Paper, durations: list[float]) -> list[Claim]:
    task = paper.task()
    printed, mended = misses_of_equation_5(paper)
    verdict = audit(task, trajectory_from_durations(task, durations))
    return [
        Claim(
            "the inverse kinematics of Eqs. (5) to (15) hold for the position p of the tool",
            "Eqs. (5) to (15)",
            f"Eq. (5), -s1 px + c1 py = d3, at 100 random positions: missed by up to {printed:.3f} m with p as "
            f"printed, {mended:.0e} m with the wrist centre p - d6 a",
            "misprint: p is the wrist centre",
        ),
        Claim(
            "Eq. (3) is the product of Eq. (1)",
            "Eqs. (1), (3)",
            "p_y has a2 c2 s2 where the product has a2 c2 s1, and o_y has s4 c5 c6 where it has s4 c5 s6, as in o_x",
            "misprints",
        ),
        Claim(
            "the weight of Eq. (46) decreases ever more slowly",
            "Eq. (46) and text",
            "w = w_max - (w_max - w_min) (t / T)^2 falls at the rate 2 (w_max - w_min) t / T^2, which grows with t",
            "contradiction inside the paper",
        ),
        Claim(
            "the coefficients follow from Eq. (28), Eq. (31) and the matrix A",
            "Eqs. (28), (31)",
            "factors of a_23 and the order of X_1 are misprinted; derived from the fourteen conditions instead, the "
            f"curve meets its points within {verdict.waypoint_error:.0e} rad and its ends within "
            f"{verdict.boundary_error:.0e} of the limits",
            "misprints",
        ),
    ]


def misses_of_equation_5(paper: Paper) -> tuple[float, float]:
    """Return the largest miss of Eq. (5), m, with p as printed and with the wrist centre, at random positions."""
    robot = paper.task().robot
    assert robot is not None
    d3, d6 = -0.0944, 0.0838
    misses = []
    for q in np.random.default_rng(0).uniform(-np.pi, np.pi, (100, 6)):
        pose = robot.pose(q)
        points = np.stack([pose[:3, 3], pose[:3, 3] - d6 * pose[:3, 2]])
        misses.append(np.abs(-np.sin(q[0]) * points[:, 0] + np.cos(q[0]) * points[:, 1] - d3))
    printed, mended = np.max(misses, axis=0)
    return float(printed), float(mended)
