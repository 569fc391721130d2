"""The tables of methods: what each found, from how many evaluations, and whether the order is proved."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.papers.experiments import EQUAL_EVALUATIONS, PUBLISHED_PROTOCOL, Experiment
from ocp_traj.papers.measures import number, quartiles, ranking_words, spread_of
from ocp_traj.papers.paper import Paper
from ocp_traj.papers.records import Records

APART = (
    "Every joint alone, then the largest duration of each segment over the joints that move in it. The total of that "
    "synchronised motion is shown whether or not it keeps the limits; the audit's verdict stands beside it."
)


ONCE = "Gradient solvers and hybrids, those that can be loaded, run once, with seed 0, and are not ranked."


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a table; bars inside cells are escaped."""
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    lines += ["| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |" for row in rows]
    return lines


def method_table(paper: Paper, records: Records, group: str, experiments: list[Experiment]) -> Iterator[str]:
    """Yield the lines of one group of experiments: heading, table and ranking."""
    yield from (f"## {group[0].upper()}{group[1:]}", "")
    apart = group == PUBLISHED_PROTOCOL and paper.protocol.joints > 0
    unit = "J" if paper.minimised == "energy" else "s"
    if apart:
        yield from (APART, "")
    if group == EQUAL_EVALUATIONS and paper.protocol.budget:
        yield from (_spent(paper, experiments), "")
    seeds = max((len(records.runs(entry.label, group)) for entry in experiments), default=0)
    header = (
        "method",
        "published",
        f"{paper.minimised}, {unit}: median (quartiles)",
        f"best of {min(paper.runs, seeds)}",
        "feasible runs",
        "worst ratio of a limit (median)",
        *(("total once slowed into the limits, s",) if apart else ()),
        "evaluations",
        "generations to 0.1 %",
        "wall time, s",
        "processor time, s",
    )
    yield from markdown_table(header, [_row(paper, records, entry, apart) for entry in experiments])
    yield ""
    many = [entry for entry in experiments if not entry.once]
    ranked = [entry for entry in many if len(records.runs(entry.label, group)) == seeds]
    if len(many) > 1:
        columns = {entry.label: _values(paper, records, entry, apart) for entry in ranked}
        left_out = ", ".join(entry.label for entry in many if entry not in ranked)
        words = f" (without {left_out}: fewer runs)" if left_out else ""
        yield from (f"Ranking{words}: {ranking_words(columns)}.", "")


def _spent(paper: Paper, experiments: list[Experiment]) -> str:
    """Say how many evaluations every method gets, and why."""
    protocol = paper.protocol
    given = {entry.budget for entry in experiments if entry.budget is not None}
    words = f"Every method gets {', '.join(str(budget) for budget in sorted(given))} evaluations of all joints together"
    if given != {protocol.budget}:
        return f"{words}, fewer than the {protocol.budget} of a full run."
    words += f", the paper's {protocol.population} candidates times {protocol.generations} generations"
    if protocol.joints:
        words += f" (its own protocol spends as many on each of {protocol.joints} joints)"
    if protocol.joints:
        words += ", with durations shared by all joints"
    return f"{words}. {ONCE}"


def _values(paper: Paper, records: Records, entry: Experiment, apart: bool) -> Array:
    read = records.raw if apart else records.values
    return read(entry.label, paper.minimised, entry.group)


def _row(paper: Paper, records: Records, entry: Experiment, apart: bool) -> list[str]:
    runs = records.runs(entry.label, entry.group)
    if not runs:
        return [entry.label, entry.published or "—", *["not run"] * (9 if apart else 8)]
    values = _values(paper, records, entry, apart)
    middle = number(float(values[0])) if entry.once else spread_of(values)
    cells = [
        f"{entry.label} (`{entry.solver}`)",
        entry.published or "—",
        middle,
        number(float(values[: paper.runs].min())),
        f"{sum(row['feasible'] for row in runs)} of {len(runs)}",
    ]
    ratios = np.array([np.inf if row["worst"] is None else row["worst"]["ratio"] for row in runs])
    cells.append(number(quartiles(ratios)[1], 3))
    if apart:
        slowed = np.array([row["duration"] * (row["scale"] or np.nan) for row in runs])
        cells.append(number(quartiles(slowed)[1]))
        generations = np.array(
            [part["generations"] for row in runs for part in row["parts"]], dtype=np.float64
        )
    else:
        generations = records.raw(entry.label, "generations", entry.group)
    evaluations = sorted({row["evaluations"] for row in runs})
    cells += [
        str(evaluations[0]) if len(evaluations) == 1 else f"{evaluations[0]} to {evaluations[-1]}",
        "—" if entry.once else spread_of(generations, 0),
        *(
            number(quartiles(np.array([row[field] for row in runs if field in row]))[1], 2)
            for field in ("seconds", "processor")
        ),
    ]
    return cells
