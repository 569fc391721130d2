"""The pages: one for every paper, and one that sums them up."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.comparison.report.document import Document, ReportSection, Table, to_markdown
from ocp_traj.papers.measures import number
from ocp_traj.papers.methods import method_section
from ocp_traj.papers.motions import certified_optimum, reference_numbers
from ocp_traj.papers.paper import MEASURED_SEEDS, AuditedMotion, Claim, Paper, table_of
from ocp_traj.papers.records import Records
from ocp_traj.pictures.matplotlib_ import save_picture

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask

SAME_POSITION = 1e-6
"""Joint positions closer than this are the same, rad."""

SCREEN_DPI, SMALL_DPI = 100, 66
"""Dots per inch of a page's pictures, and of those with more panels than `FEW_PANELS`."""

FEW_PANELS = 4

JUDGING = (
    "Orders are judged by Friedman's test and Wilcoxon's signed ranks with Holm's correction over the seeds, single "
    "gains by Wilcoxon's test without correction, at 5 %; a gain is that of the medians."
)


def write_page(paper: Paper, records: Records, folder: Path, command: str, reduced: bool) -> Path:
    """Write one paper's page and pictures into a folder; return the page's path."""
    path = folder / f"{paper.stem}.md"
    folder.mkdir(parents=True, exist_ok=True)
    path.write_text(to_markdown(_page(paper, records, folder, command, reduced)), encoding="utf-8")
    return path


def _page(paper: Paper, records: Records, folder: Path, command: str, reduced: bool) -> Document:
    experiments = paper.experiments(reduced)
    counts = [len(records.runs(entry.label, entry.group)) for entry in experiments if not entry.once]
    groups = dict.fromkeys(entry.group for entry in experiments)
    sections = [
        ReportSection(
            "", "What came out", (_bullets(paper.story(records)), *made_by(command, reduced), seeds_of(counts))
        ),
        _case(paper),
        ReportSection("", "Readings and stand-ins", (_bullets(paper.stand_ins),)),
        *(
            method_section(paper, records, group, [entry for entry in experiments if entry.group == group])
            for group in groups
        ),
        _headed(_references(paper.task(), records)),
        *(_headed(_audited(motions)) for motions in (paper.audited(records),) if motions),
        *(_headed(table) for table in paper.tables(records)),
        ReportSection("", "Figures", _figures(paper, records, folder)),
        _headed(claims_table(paper.claims(records))),
    ]
    return Document(paper.heading, f"{paper.reference}. {paper.summary}", (), tuple(sections))


def _headed(table: Table) -> ReportSection:
    """Return a section of one table, whose caption becomes the heading."""
    return ReportSection("", table.caption, tables=(Table("", table.columns, table.rows, table.note),))


def _bullets(sentences: Sequence[str]) -> str:
    return "\n".join(f"- {sentence}" for sentence in sentences)


def made_by(command: str, reduced: bool) -> list[str]:
    """Return the sentences that say where a page comes from."""
    warning = "**Reduced budgets, made to test the machinery: the numbers mean nothing.**"
    return [*((warning,) if reduced else ()), f"Every number below was computed by `{command}`."]


def seeds_of(counts: Sequence[int]) -> str:
    """Return the sentence that says how many runs of every method there are."""
    least, most = min(counts, default=0), max(counts, default=0)
    if most < MEASURED_SEEDS:
        words = f"{least} runs" if least == most else f"{least} to {most} runs"
        return f"**{words} of a method only: medians are rough, and tests can hardly prove a difference.**"
    if least == most:
        return f"{most} runs of every method, one a seed; what runs once says so."
    return (
        f"{most} runs of a method, one a seed; what has fewer, down to {least}, or runs once says so and is not ranked."
    )


def claims_table(claims: Sequence[Claim]) -> Table:
    """Return the table of claims."""
    return table_of(
        "What the paper claims",
        ("the paper claims", "where", "we measured", "verdict"),
        [(claim.sentence, claim.source, claim.measured, f"**{claim.verdict}**") for claim in claims],
        JUDGING,
    )


def _case(paper: Paper) -> ReportSection:
    task = paper.task()
    degrees = np.rad2deg(task.waypoints)
    rows = [[f"{k + 1}", *(f"{value:.3f}" for value in point)] for k, point in enumerate(degrees)]
    header = ["waypoint", *(f"joint {joint + 1}, deg" for joint in range(task.n))]
    for name, unit in (("velocity", "deg/s"), ("acceleration", "deg/s²"), ("jerk", "deg/s³")):
        limits = task.limits.get(name)[0, 1]
        if np.isfinite(limits).any():
            rows.append([f"limit of {name}, {unit}", *(f"{np.rad2deg(value):.4g}" for value in limits)])
    closure = "" if task.robot is None else _closure(task)
    source = f"`{paper.case}`: {task.title}. Source: {task.source}."
    return ReportSection("", "The case", (source,), (table_of("", header, rows, closure),))


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


def _references(task: TrajectoryTask, records: Records) -> Table:
    found, proved = reference_numbers(task, records), certified_optimum(task, records)
    bound = found["kinematic_bound"]
    rows = [
        ("no C1 motion within the velocity and acceleration limits is shorter (certified)", bound["lower"]),
        ("the same, best found", bound["estimate"]),
        *((f"TOPP-RA, {path} path parameter", value) for path, value in found["toppra"].items()),
        *((f"convex path tracking, {path} path parameter", value) for path, value in found["convex"].items()),
    ]
    if proved["lower"] is not None:
        rows += [
            ("no motion of the paper's curve within its limits is shorter (certified)", proved["lower"]),
            ("the same, reached", proved["upper"]),
        ]
        note = ""
    else:
        note = f"No certified optimum of the paper's curve: {proved['message']}."
    numbers = [(words, number(value)) for words, value in rows]
    return table_of("References", ("reference", "duration, s"), numbers, note)


def _audited(motions: Sequence[AuditedMotion]) -> Table:
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
    return table_of("Reported motions before the judge", header, rows)


def _figures(paper: Paper, records: Records, folder: Path) -> tuple[str, ...]:
    """Save the pictures; return the lines that show them."""
    shown: list[str] = []
    for figure in paper.figures(records):
        if isinstance(figure, str):
            shown.append(figure)
        else:
            file = f"{paper.stem}-{figure.name}.png"
            save_picture(figure, folder / file, SCREEN_DPI if len(figure.panels) <= FEW_PANELS else SMALL_DPI)
            shown += [f"![{figure.title}]({file})", f"{figure.title}: {figure.caption}"]
    return tuple(shown)


def write_summary(pages: Sequence[tuple[Paper, Records]], folder: Path, command: str, reduced: bool) -> Path:
    """Write the page that sums all papers up; return its path."""
    path = folder / "index.md"
    names = "\n".join(paper.stem for paper, _ in pages)
    top = [*made_by(command, reduced), f"```{{toctree}}\n:maxdepth: 1\n\n{names}\n```"]
    sections = [_summary(paper, records) for paper, records in pages]
    document = Document("Four papers, run again", "\n\n".join(top), (), tuple(sections))
    path.write_text(to_markdown(document), encoding="utf-8")
    return path


def _summary(paper: Paper, records: Records) -> ReportSection:
    claims = paper.claims(records)
    counted = f"Of {len(claims)} claims and remarks: {_count(claims)}. [All of them]({paper.stem}.md)"
    return ReportSection("", paper.heading, (_bullets(paper.story(records)), counted))


def _count(claims: Sequence[Claim]) -> str:
    verdicts = Counter(re.split("[:;,]", claim.verdict)[0] for claim in claims)
    return ", ".join(f"{count} × {word}" for word, count in verdicts.items())
