"""What Zhang et al. 2022 (paper C) print and claim; every claim held against the records."""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.comparison.report.statistics import quartiles
from ocp_traj.papers.experiments import PUBLISHED_PROTOCOL
from ocp_traj.papers.measures import STAND_IN, claim_order, number, order_with_tests, spread_of
from ocp_traj.papers.paper import Claim, Paper
from ocp_traj.papers.records import Records
from ocp_traj.papers.zhang_2022.inverse_timing import inverse_timing, timing_claims
from ocp_traj.papers.zhang_2022.tent import evenness_claim

SSA, T_SSA, ADF_SSA, TADF_SSA = "SSA", "T-SSA", "ADF-SSA", "TADF-SSA"
"""The paper's methods."""

BEST_OF_TEN = {SSA: 10.83, T_SSA: 12.07, ADF_SSA: 9.85, TADF_SSA: 8.99}
"""Fig. 7, seconds."""

FINAL, INITIAL = 8.6618, 50.0
"""Section 5, seconds."""


def claims(paper: Paper, records: Records) -> list[Claim]:
    """Return every claim of paper C with what was measured."""
    return [
        *_order_claims(paper, records),
        *_number_claims(paper, records),
        *timing_claims(inverse_timing(paper.task(), records)),
        *_curve_claims(paper, records),
        evenness_claim(),
    ]


def durations(paper: Paper, records: Records) -> dict[str, Array]:
    """Return every method's feasible durations with the paper's own protocol, s, one per seed."""
    return {label: records.values(label, "duration", PUBLISHED_PROTOCOL) for label in paper.protocol.labels}


def _order_claims(paper: Paper, records: Records) -> list[Claim]:
    columns = durations(paper, records)
    generations = {label: records.raw(label, "generations", PUBLISHED_PROTOCOL) for label in columns}
    return [
        claim_order(
            "durations: TADF-SSA < ADF-SSA < SSA < T-SSA (8.99, 9.85, 10.83, 12.07 s)",
            "Fig. 7",
            {label: columns[label] for label in (TADF_SSA, ADF_SSA, SSA, T_SSA)},
            "s",
            where=STAND_IN,
        ),
        claim_order(
            "generations to convergence: TADF-SSA 18 < ADF-SSA 23 < T-SSA 34 < SSA 46",
            "Fig. 7",
            {label: generations[label] for label in (TADF_SSA, ADF_SSA, T_SSA, SSA)},
            "generations",
            where=STAND_IN,
        ),
        _no_gain_claim(columns),
        claim_order(
            "the adaptive factor alone improves",
            "section 5",
            columns,
            "s",
            order=(ADF_SSA, SSA),
            where=STAND_IN,
        ),
    ]


def _no_gain_claim(columns: dict[str, Array]) -> Claim:
    """Judge that Tent chaos alone is no significant improvement, within the family of all four methods."""
    _, proven, tests = order_with_tests(columns)
    return Claim(
        "Tent chaos alone does not improve the result significantly (12.07 against 10.83 s)",
        "Fig. 7, text",
        f"medians: SSA {number(quartiles(columns[SSA])[1])} s, T-SSA {number(quartiles(columns[T_SSA])[1])} s. {tests}",
        f"does not hold{STAND_IN}" if (T_SSA, SSA) in proven else "holds",
    )


def _number_claims(paper: Paper, records: Records) -> list[Claim]:
    columns = durations(paper, records)
    best = "; ".join(f"{label} {number(float(columns[label][: paper.best_of].min()))} s" for label in columns)
    medians = "; ".join(f"{label} {spread_of(columns[label])} s" for label in columns)
    return [
        Claim("best of ten runs 10.83, 12.07, 9.85, 8.99 s", "Fig. 7", best, "another case (stand-in)"),
        Claim(
            "the averages of ten runs float around the best results: stable",
            "Table 5 (lost), text",
            f"medians and quartiles: {medians}; bests of ten: {best}",
            "no number to compare with",
        ),
        Claim(
            f"final {FINAL} s, the mean of five runs",
            "section 5",
            f"the best of ten runs of the same method is {BEST_OF_TEN[TADF_SSA]} s: a mean of five cannot be below "
            "it unless the runs are others",
            "contradiction inside the paper",
        ),
        Claim(
            f"82.68 % shorter than the initial {INITIAL:.0f} s",
            "section 5",
            f"printed numbers: {100 * (1 - FINAL / INITIAL):.2f} %; our TADF-SSA, median: "
            f"{100 * (1 - quartiles(columns[TADF_SSA])[1] / INITIAL):.2f} %",
            "arithmetic holds; the share measures the start",
        ),
    ]


def _curve_claims(paper: Paper, records: Records) -> list[Claim]:
    rows = [row for label in paper.protocol.labels for row in records.runs(label, PUBLISHED_PROTOCOL)]
    kept = sum(row.record.feasible for row in rows)
    travel = np.ptp(paper.task().waypoints[:, 5])
    return [
        Claim(
            "velocity, acceleration and jerk stay below their limits",
            "Fig. 8",
            f"{kept} of {len(rows)} runs keep every limit at every time",
            "holds" if kept == len(rows) else "does not hold for every run",
        ),
        Claim(
            "joint 6 does not move",
            "section 5",
            f"largest travel of joint 6 between the waypoints: {travel:.1e} rad",
            "holds" if travel < 1e-6 else "does not hold",
        ),
    ]
