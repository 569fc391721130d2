"""The pages: one for every paper, and one that sums them up."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.papers.measures import number, order_with_tests, quartiles, reference_numbers, spread_of
from ocp_traj.papers.paper import MEASURED_SEEDS, PUBLISHED_PROTOCOL, Claim, Experiment, Paper
from ocp_traj.papers.records import Records

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask

SAME_POSITION = 1e-6
"""Joint positions closer than this are the same, rad."""


def write_page(paper: Paper, records: Records, folder: Path, command: str, reduced: bool) -> Path:
    """Write one paper's page and figures into a folder; return the page's path."""
    path = folder / f"paper-{paper.key.lower()}.md"
    folder.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(_page(paper, records, folder, command, reduced)) + "\n", encoding="utf-8")
    return path


def _page(paper: Paper, records: Records, folder: Path, command: str, reduced: bool) -> Iterator[str]:
    yield from (f"# Paper {paper.key}: {paper.title}", "", f"{paper.reference}. {paper.summary}", "")
    yield from ("## What came out", "", *(f"- {sentence}" for sentence in paper.story(records)), "")
    yield from made_by(command, reduced)
    experiments = paper.experiments(reduced)
    seeds = max((len(records.runs(entry.label, entry.group)) for entry in experiments), default=0)
    if seeds < MEASURED_SEEDS:
        yield from (
            f"**{seeds} seeds only: medians are rough, and tests can hardly prove a difference.**",
            "",
        )
    yield from _case(paper)
    yield from ("## Readings and stand-ins", "", *(f"- {sentence}" for sentence in paper.stand_ins), "")
    for group in dict.fromkeys(experiment.group for experiment in experiments):
        yield from _group(paper, records, group, [entry for entry in experiments if entry.group == group])
    yield from _references(paper, records)
    yield from _audited(paper, records)
    for table in paper.tables(records):
        yield from (f"## {table.title}", "", *markdown_table(table.header, table.rows), "")
        if table.note:
            yield from (table.note, "")
    yield from _figures(paper, records, folder)
    yield from ("## What the paper claims", "", *claims_table(paper.claims(records)), "")


def made_by(command: str, reduced: bool) -> list[str]:
    """Return the sentence that says where a page comes from."""
    lines = [f"Every number below was computed by `{command}`.", ""]
    if reduced:
        lines = ["**Reduced budgets, made to test the machinery: the numbers mean nothing.**", "", *lines]
    return lines


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a table; bars inside cells are escaped."""
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    lines += ["| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |" for row in rows]
    return lines


def claims_table(claims: Sequence[Claim]) -> list[str]:
    """Return the table of claims."""
    rows = [(claim.sentence, claim.source, claim.measured, f"**{claim.verdict}**") for claim in claims]
    return markdown_table(("the paper claims", "where", "we measured", "verdict"), rows)


def _case(paper: Paper) -> Iterator[str]:
    task = paper.task()
    degrees = np.rad2deg(task.waypoints)
    yield from ("## The case", "", f"`{paper.case}`: {task.title}. Source: {task.source}.", "")
    rows = [[f"{k + 1}", *(f"{value:.3f}" for value in point)] for k, point in enumerate(degrees)]
    header = ["waypoint", *(f"joint {joint + 1}, deg" for joint in range(task.n))]
    for name, unit in (("velocity", "deg/s"), ("acceleration", "deg/s²"), ("jerk", "deg/s³")):
        limits = task.limits.get(name)[0, 1]
        if np.isfinite(limits).any():
            rows.append([f"limit of {name}, {unit}", *(f"{np.rad2deg(value):.4g}" for value in limits)])
    yield from (*markdown_table(header, rows), "")
    if task.robot is not None:
        yield from (_closure(task), "")


def _closure(task: TrajectoryTask) -> str:
    """Say how far the waypoints come back from forward and inverse kinematics."""
    from ocp_traj.robot.inverse_kinematics import inverse_kinematics_of
    from ocp_traj.robot.inverse_kinematics.screws import wrap

    assert task.robot is not None
    inverse = inverse_kinematics_of(task.robot)
    misses, singular = [], []
    for index, q in enumerate(task.waypoints):
        found = inverse.solve(task.robot.pose(q))
        miss = float(np.abs(wrap(found - q)).max(axis=1).min()) if len(found) else np.inf
        if miss < SAME_POSITION:
            misses.append(miss)
        else:
            singular.append(index + 1)
    words = (
        f"Through forward kinematics, inverse kinematics and back, {len(misses)} of {len(task.waypoints)} waypoints "
        f"are found again among the branches (largest miss {max(misses, default=0.0):.1e} rad)"
    )
    if singular:
        words += (
            f"; the wrist is singular at waypoint {', '.join(map(str, singular))}: that branch is not unique"
        )
    return words + "."


def _group(paper: Paper, records: Records, group: str, experiments: list[Experiment]) -> Iterator[str]:
    yield from (f"## {group[0].upper()}{group[1:]}", "")
    apart = group == PUBLISHED_PROTOCOL and paper.joints_apart
    unit = "J" if paper.minimised == "energy" else "s"
    if apart:
        yield (
            "Every joint alone, then the largest duration of each segment over the joints that move in it. The "
            "total of "
            "that synchronised motion is shown whether or not it keeps the limits; the audit's verdict stands "
            "beside it."
        )
        yield ""
    seeds = max((len(records.runs(entry.label, group)) for entry in experiments), default=0)
    header = (
        "method",
        "published",
        f"{paper.minimised}, {unit}: median (quartiles)",
        f"best of {min(paper.runs, seeds)}",
        "feasible runs",
        *(("worst ratio", "total once slowed into the limits, s") if apart else ()),
        "evaluations",
        "generations to 0.1 %",
        "wall time, s",
        "processor time, s",
    )
    yield from markdown_table(header, [_row(paper, records, entry, apart) for entry in experiments])
    yield ""
    many = [entry for entry in experiments if not entry.once]
    if len(many) > 1:
        columns = {entry.label: _values(paper, records, entry, apart) for entry in many}
        yield from (f"Ranking: {order_with_tests(columns)[2]}.", "")


def _values(paper: Paper, records: Records, entry: Experiment, apart: bool) -> Any:
    read = records.raw if apart else records.values
    return read(entry.label, paper.minimised, entry.group)


def _row(paper: Paper, records: Records, entry: Experiment, apart: bool) -> list[str]:
    runs = records.runs(entry.label, entry.group)
    if not runs:
        return [entry.label, entry.published or "—", *["not run"] * (9 if apart else 7)]
    values = _values(paper, records, entry, apart)
    middle = number(float(values[0])) if entry.once else spread_of(values)
    cells = [
        f"{entry.label} (`{entry.solver}`)",
        entry.published or "—",
        middle,
        number(float(values[: paper.runs].min())),
        f"{sum(row['feasible'] for row in runs)} of {len(runs)}",
    ]
    if apart:
        ratios = np.array([row["worst"]["ratio"] for row in runs], dtype=np.float64)
        slowed = np.array([row["duration"] * (row["scale"] or np.nan) for row in runs])
        cells += [number(quartiles(ratios)[1], 3), number(quartiles(slowed)[1])]
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
            number(quartiles(records.raw(entry.label, field, entry.group))[1], 2)
            for field in ("seconds", "processor")
        ),
    ]
    return cells


def _references(paper: Paper, records: Records) -> Iterator[str]:
    found = reference_numbers(paper, records)
    bound = found["kinematic_bound"]
    rows = [
        (
            "no C1 motion within the velocity and acceleration limits is shorter (certified)",
            number(bound["lower"]),
        ),
        ("the same, best found", number(bound["estimate"])),
        *((f"TOPP-RA, {path} path parameter", number(value)) for path, value in found["toppra"].items()),
        *(
            (f"convex path tracking, {path} path parameter", number(value))
            for path, value in found["convex"].items()
        ),
    ]
    yield from ("## References", "", *markdown_table(("reference", "duration, s"), rows), "")


def _audited(paper: Paper, records: Records) -> Iterator[str]:
    motions = paper.audited(records)
    if not motions:
        return
    rows = [
        (
            motion.words,
            number(motion.duration, 5),
            "feasible" if motion.feasible else "**not feasible**",
            number(motion.ratio, 4),
            number(motion.smallest_feasible_scale, 4),
            motion.finding,
        )
        for motion in motions
    ]
    header = ("motion", "duration, s", "verdict", "worst ratio", "smallest feasible slowing", "finding")
    yield from ("## Reported motions before the judge", "", *markdown_table(header, rows), "")


def _figures(paper: Paper, records: Records, folder: Path) -> Iterator[str]:
    yield from ("## Figures", "")
    for figure in paper.figures(records, folder):
        if figure.file:
            yield from (
                f"![Fig. {figure.number}]({figure.file})",
                "",
                f"Fig. {figure.number}: {figure.caption}",
                "",
            )
        else:
            yield from (f"Fig. {figure.number}, {figure.caption}: not regenerated, {figure.impossible}.", "")


def write_summary(pages: Sequence[tuple[Paper, Records]], folder: Path, command: str, reduced: bool) -> Path:
    """Write the page that sums all papers up; return its path."""
    path = folder / "index.md"
    lines = ["# Four papers, run again", "", *made_by(command, reduced)]
    lines += [
        "```{toctree}",
        ":maxdepth: 1",
        "",
        *(f"paper-{paper.key.lower()}" for paper, _ in pages),
        "```",
        "",
    ]
    for paper, records in pages:
        claims = paper.claims(records)
        lines += [
            f"## Paper {paper.key}: {paper.title}",
            "",
            *(f"- {sentence}" for sentence in paper.story(records)),
            "",
            f"Of {len(claims)} claims and remarks: {_count(claims)}. [All of them](paper-{paper.key.lower()}.md)",
            "",
        ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _count(claims: Sequence[Claim]) -> str:
    words: dict[str, int] = {}
    for claim in claims:
        first = claim.verdict.split(":")[0].split(";")[0].split(",")[0]
        words[first] = words.get(first, 0) + 1
    return ", ".join(f"{count} × {word}" for word, count in words.items())
