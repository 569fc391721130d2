"""The tables of methods: what each found, from how many evaluations, and whether the order is proved."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.comparison.report.document import ReportSection
from ocp_traj.comparison.report.statistics import quartiles
from ocp_traj.papers.experiments import EQUAL_EVALUATIONS, PUBLISHED_PROTOCOL, Experiment, Protocol
from ocp_traj.papers.measures import number, ranking_words, spread_of
from ocp_traj.papers.paper import Paper, table_of
from ocp_traj.papers.records import Records

APART = (
    "Every joint alone, then the largest duration of each segment over the joints that move in it. The total of that "
    "synchronised motion is shown whether or not it keeps the limits; the audit's verdict stands beside it."
)

ONCE = "Gradient solvers and hybrids, those that can be loaded, run once, with seed 0, and are not ranked."


def method_section(
    paper: Paper, records: Records, group: str, experiments: Sequence[Experiment]
) -> ReportSection:
    """Return one group of experiments: what was spent, a row per method, and the ranking."""
    apart = group == PUBLISHED_PROTOCOL and paper.protocol.joints > 0
    unit = "J" if paper.minimised == "energy" else "s"
    paragraphs = (APART,) if apart else ()
    if group == EQUAL_EVALUATIONS and paper.protocol.budget:
        paragraphs = (_spent(paper.protocol, experiments),)
    seeds = max((len(records.runs(entry.label, group)) for entry in experiments), default=0)
    header = (
        "method",
        "published",
        f"{paper.minimised}, {unit}: median (quartiles)",
        f"best of {min(paper.best_of, seeds)}",
        "feasible runs",
        "worst ratio of a limit (median)",
        *(("total once slowed into the limits, s",) if apart else ()),
        "evaluations",
        "generations to 0.1 %",
        "wall time, s",
        "processor time, s",
    )
    rows = [_row(paper, records, entry, apart) for entry in experiments]
    table = table_of("", header, rows, _ranking(paper, records, experiments, seeds, apart))
    return ReportSection("", f"{group[0].upper()}{group[1:]}", paragraphs, (table,))


def _ranking(
    paper: Paper, records: Records, experiments: Sequence[Experiment], seeds: int, apart: bool
) -> str:
    """Say in which order the methods with all seeds stand; nothing where there are not two with seeds."""
    many = [entry for entry in experiments if not entry.once]
    if len(many) < 2:
        return ""
    ranked = [entry for entry in many if len(records.runs(entry.label, entry.group)) == seeds]
    columns = {entry.label: _values(paper, records, entry, apart) for entry in ranked}
    left_out = ", ".join(entry.label for entry in many if entry not in ranked)
    words = f" (without {left_out}: fewer runs)" if left_out else ""
    return f"Ranking{words}: {ranking_words(columns)}."


def _spent(protocol: Protocol, experiments: Sequence[Experiment]) -> str:
    """Say how many evaluations every method gets, and why."""
    given = {entry.budget for entry in experiments if entry.budget is not None}
    words = f"Every method gets {', '.join(str(budget) for budget in sorted(given))} evaluations of all joints together"
    if given != {protocol.budget}:
        return f"{words}, fewer than the {protocol.budget} of a full run."
    words += f", the paper's {protocol.population} candidates times {protocol.generations} generations"
    if protocol.joints:
        words += (
            f" (its own protocol spends as many on each of {protocol.joints} joints), with durations shared by all "
            "joints"
        )
    return f"{words}. {ONCE}"


def _values(paper: Paper, records: Records, entry: Experiment, apart: bool) -> Array:
    read = records.raw if apart else records.values
    return read(entry.label, paper.minimised, entry.group)


def _row(paper: Paper, records: Records, entry: Experiment, apart: bool) -> list[str]:
    runs = [row.record for row in records.runs(entry.label, entry.group)]
    if not runs:
        return [entry.label, entry.published or "—", *["not run"] * (9 if apart else 8)]
    values = _values(paper, records, entry, apart)
    cells = [
        f"{entry.label} (`{entry.solver}`)",
        entry.published or "—",
        number(float(values[0])) if entry.once else spread_of(values),
        number(float(values[: paper.best_of].min())),
        f"{sum(run.feasible for run in runs)} of {len(runs)}",
    ]
    ratios = np.array([np.inf if run.worst is None else run.worst["ratio"] for run in runs])
    cells.append(number(quartiles(ratios)[1], 3))
    generations = records.raw(entry.label, "generations", entry.group)
    if apart:
        slowed = [(run.duration or np.nan) * (run.smallest_feasible_scale or np.nan) for run in runs]
        cells.append(number(quartiles(np.array(slowed))[1]))
        parts = [part["generations"] for run in runs for part in run.details.get("parts", [])]
        generations = np.array(parts, dtype=np.float64)
    evaluations = [run.evaluations for run in runs if run.evaluations is not None]
    seconds = (records.raw(entry.label, field, entry.group) for field in ("seconds", "processor"))
    return [
        *cells,
        " to ".join(map(str, sorted({min(evaluations), max(evaluations)}))) if evaluations else "—",
        "—" if entry.once else spread_of(generations, 0),
        *(number(quartiles(times[np.isfinite(times)])[1], 2) for times in seconds),
    ]
