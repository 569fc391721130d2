"""Paper C: the names of its methods and what it prints."""

from __future__ import annotations

from typing import Any

from ocp_traj.papers.experiments import PUBLISHED_PROTOCOL
from ocp_traj.papers.paper import Paper
from ocp_traj.papers.records import Records

SSA, T_SSA, ADF_SSA, TADF_SSA = "SSA", "T-SSA", "ADF-SSA", "TADF-SSA"
BEST_OF_TEN = {SSA: 10.83, T_SSA: 12.07, ADF_SSA: 9.85, TADF_SSA: 8.99}
"""Fig. 7, seconds."""


def durations(paper: Paper, records: Records) -> dict[str, Any]:
    """Return every method's feasible durations with the paper's own protocol, s, one a seed."""
    return {label: records.values(label, "duration", PUBLISHED_PROTOCOL) for label in paper.protocol.labels}
