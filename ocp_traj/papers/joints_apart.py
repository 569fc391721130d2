"""What papers B and D share: every joint optimised alone, then the largest duration of each segment."""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.comparison.report.document import Table
from ocp_traj.papers.experiments import PUBLISHED_PROTOCOL
from ocp_traj.papers.measures import number, spread_of
from ocp_traj.papers.motions import certified_optimum, joint_optima
from ocp_traj.papers.paper import Paper, table_of
from ocp_traj.papers.records import Records


def totals(paper: Paper, records: Records) -> dict[str, Array]:
    """Return every method's synchronised totals, s, one per seed, whether or not the motion keeps the limits."""
    return {label: records.raw(label, "duration", PUBLISHED_PROTOCOL) for label in paper.protocol.labels}


def slowed_totals(paper: Paper, records: Records) -> dict[str, Array]:
    """Return the totals once each synchronised motion is slowed into its limits, s; infinite where no slowing does."""
    return {
        label: found * records.raw(label, "smallest_feasible_scale", PUBLISHED_PROTOCOL)
        for label, found in totals(paper, records).items()
    }


def joints_table(paper: Paper, records: Records, note: str = "") -> Table:
    """Return the table of the joints alone: the optimum, and what each method found after how many generations."""
    shortest = float(np.asarray(paper.task().search.duration)[0])
    header = ["joint", "optimum found, s", "proof"]
    for label in paper.protocol.labels:
        header += [f"{label}, s", f"{label}, generations"]
    rows = []
    for joint, found in joint_optima(paper.task(), records).items():
        cells = [f"{joint}", number(found["upper"]), found["message"]]
        for label in paper.protocol.labels:
            cells.append(spread_of(records.part(label, joint, "cost", PUBLISHED_PROTOCOL)))
            cells.append(spread_of(records.part(label, joint, "generations", PUBLISHED_PROTOCOL), 0))
        rows.append(cells)
    return table_of(
        "Every joint alone",
        header,
        rows,
        "Medians and quartiles over seeds; generations until within 0.1 % of the run's final best. The methods "
        f"search durations from {shortest:g} s on; the optimum has no such bound, so where a joint may pass a gap in "
        f"no time at all it is shorter by up to {shortest:g} s a gap, and has no proof.{note}",
    )


def segments_table(paper: Paper, records: Records, printed: list[float] | None = None) -> Table:
    """Return the synchronised durations of the segments: printed, found, and best for all joints together."""
    shared = certified_optimum(paper.task(), records)["durations"]
    rows = [] if printed is None else [_segments_row("printed", printed)]
    for label in paper.protocol.labels:
        rows_found = [row.record.details for row in records.runs(label, PUBLISHED_PROTOCOL)]
        runs = [details["segments"] for details in rows_found if details.get("segments")]
        if runs:
            best = min(runs, key=sum)
            rows.append(_segments_row(f"{label}, shortest of {len(runs)} runs", best))
    rows.append(_segments_row("shared by all joints, least feasible", shared))
    header = ("motion", *(f"segment {gap + 1}, s" for gap in range(len(shared))), "total, s")
    return table_of(
        "Durations of the segments", header, rows, "The largest over the joints that move in it."
    )


def _segments_row(words: str, durations: list[float]) -> tuple[str, ...]:
    return (words, *(number(h, 3) for h in durations), number(sum(durations), 3))
