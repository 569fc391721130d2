"""The pages: one for every paper, and one that sums them up."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.papers.measures import number
from ocp_traj.papers.method_table import markdown_table, method_table
from ocp_traj.papers.motions import certified_optimum, reference_numbers
from ocp_traj.papers.paper import MEASURED_SEEDS, Claim, Paper
from ocp_traj.papers.records import Records

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask

SAME_POSITION = 1e-6
"""Joint positions closer than this are the same, rad."""


JUDGING = (
    "Orders are judged by Friedman's test and Wilcoxon's signed ranks with Holm's correction over the seeds, single "
    "gains by Wilcoxon's test without correction, at 5 %; a gain is that of the medians."
)


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
    yield from (*seeds_of([len(records.runs(e.label, e.group)) for e in experiments if not e.once]), "")
    yield from _case(paper)
    yield from ("## Readings and stand-ins", "", *(f"- {sentence}" for sentence in paper.stand_ins), "")
    for group in dict.fromkeys(experiment.group for experiment in experiments):
        yield from method_table(
            paper, records, group, [entry for entry in experiments if entry.group == group]
        )
    yield from _references(paper, records)
    yield from _audited(paper, records)
    for table in paper.tables(records):
        yield from (f"## {table.title}", "", *markdown_table(table.header, table.rows), "")
        if table.note:
            yield from (table.note, "")
    yield from _figures(paper, records, folder)
    yield from ("## What the paper claims", "", *claims_table(paper.claims(records)), "", JUDGING, "")


def made_by(command: str, reduced: bool) -> list[str]:
    """Return the sentence that says where a page comes from."""
    lines = [f"Every number below was computed by `{command}`.", ""]
    if reduced:
        lines = ["**Reduced budgets, made to test the machinery: the numbers mean nothing.**", "", *lines]
    return lines


def seeds_of(counts: Sequence[int]) -> list[str]:
    """Return the sentence that says how many runs of every method there are."""
    least, most = min(counts, default=0), max(counts, default=0)
    if most < MEASURED_SEEDS:
        words = f"{least} runs" if least == most else f"{least} to {most} runs"
        return [f"**{words} of a method only: medians are rough, and tests can hardly prove a difference.**"]
    if least == most:
        return [f"{most} runs of every method, one a seed; what runs once says so."]
    return [
        f"{most} runs of a method, one a seed; what has fewer, down to {least}, or runs once says so and is not ranked."
    ]


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
    from ocp_traj.robot.inverse_kinematics import ClosedForm, inverse_kinematics_of
    from ocp_traj.robot.inverse_kinematics.screws import wrap

    assert task.robot is not None
    inverse = inverse_kinematics_of(task.robot)
    misses, poses, lost = [], [], []
    for index, q in enumerate(task.waypoints):
        pose = task.robot.pose(q)
        found = inverse.solve(pose)
        misses.append(float(np.abs(wrap(found - q)).max(axis=1).min()) if len(found) else np.inf)
        poses.append(min((float(np.abs(task.robot.pose(row) - pose).max()) for row in found), default=np.inf))
        if misses[-1] >= SAME_POSITION:
            lost.append(index + 1)
    same = [miss for miss in misses if miss < SAME_POSITION]
    words = (
        "Through forward kinematics, inverse kinematics and back, every pose is met within "
        f"{max(poses):.1e} (m, and entries of the rotation); {len(same)} of {len(task.waypoints)} waypoints are found "
        f"again among the branches (largest miss {max(same, default=0.0):.1e} rad)"
    )
    if lost:
        words += f"; not waypoint {', '.join(map(str, lost))}"
    if isinstance(inverse, ClosedForm):
        singular = np.flatnonzero(np.abs(inverse.factors(task.waypoints)).min(axis=1) < SAME_POSITION) + 1
        if len(singular):
            words += (
                f". The wrist is singular at waypoint {', '.join(map(str, singular))}: joints 4 and 6 turn about the "
                "same line there, and only their sum is determined"
            )
    return words + "."


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
    proved = certified_optimum(paper.task(), records)
    if proved["lower"] is not None:
        rows += [
            (
                "no motion of the paper's curve within its limits is shorter (certified)",
                number(proved["lower"]),
            ),
            ("the same, reached", number(proved["upper"])),
        ]
    yield from ("## References", "", *markdown_table(("reference", "duration, s"), rows), "")
    if proved["lower"] is None:
        yield from (f"No certified optimum of the paper's curve: {proved['message']}.", "")


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
