"""Write ``report.html`` and ``report.md`` of a comparison, finished or not: one document, two forms."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ocp_traj.comparison.report import tables
from ocp_traj.comparison.report.comparison_pictures import (
    convergence_picture,
    data_picture,
    performance_picture,
    problem_entries,
    runtime_picture,
)
from ocp_traj.comparison.report.document import Document, Fold, ReportSection, to_markdown
from ocp_traj.comparison.report.judging import ComparedProblem, Judgement, judge, objective_of
from ocp_traj.comparison.report.story import LIMITATIONS, describe_machine, tell_story
from ocp_traj.comparison.runs.store import Store, StoredRun
from ocp_traj.exceptions import InputError, OcpTrajError
from ocp_traj.files import write_atomically
from ocp_traj.pictures.bounds import bounds_picture
from ocp_traj.pictures.motion import motion_picture, path_picture, power_picture
from ocp_traj.pictures.picture import Picture
from ocp_traj.pictures.svg import draw_picture
from ocp_traj.pictures.viewer import Scene, viewer_html
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

MOTIONS_SHOWN = 24
"""Motions drawn at most in one report; `ocp-traj plot` draws any other."""

CONVERGENCE_SHOWN = 24
"""Problems whose convergence, and whose bounds, are drawn at most."""

TEMPLATES = Path(__file__).parent / "templates"


@dataclass(frozen=True)
class ShownMotion:
    """The best motion of one solver on one problem, with the task it answers."""

    problem: ComparedProblem
    solver: str
    task: TrajectoryTask
    trajectory: Trajectory


@dataclass(frozen=True)
class ReportFiles:
    """Where a report was written, and what it says first."""

    html: Path
    markdown: Path
    judgement: Judgement
    story: tuple[str, ...]


def write_report(folder: Path) -> ReportFiles:
    """Write the report of a comparison folder about the problems of its newest plan.

    Raises
    ------
    InputError
        The folder holds no comparison, or a damaged one, or cannot be written.
    """
    with Store(folder) as store:
        wanted = store.problems()
        rows = [row for row in store.rows() if (row.case_digest, row.settings_digest) in wanted]
        judgement = judge(rows, store.cases())
        motions, untold = _best_motions(store, judgement)
        document = build_document(store, rows, judgement, motions, untold)
    html, markdown = folder / "report.html", folder / "report.md"
    _replace(markdown, to_markdown(document))
    _replace(html, render_html(document, motions))
    return ReportFiles(html, markdown, judgement, document.story)


def _replace(path: Path, content: str) -> None:
    try:
        write_atomically(path, content)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}") from None


def build_document(
    store: Store,
    rows: Sequence[StoredRun],
    judgement: Judgement,
    motions: Sequence[ShownMotion],
    untold: Sequence[str],
) -> Document:
    """Return everything the report says."""
    plans = store.plans()
    plan, environment = plans[-1]
    planned = [row for row in rows if row.solver in plan.solvers and row.seed_index < plan.seeds]
    story = tell_story(judgement, plan.size, len(planned))
    subtitle = (
        f"{len(judgement.problems)} problems × {len(judgement.solvers)} solvers × {plan.seeds} seeds, "
        f"{len(rows)} runs; every answer judged by the audit, never by the solver's claim."
    )
    sections = [
        *(_findings(judgement, motions, untold) if judgement.groups else []),
        ReportSection("runs", "Single runs", folds=(Fold("All runs", tables=(tables.run_table(rows),)),)),
        ReportSection("machine", "Machine and versions", (describe_machine(environment), *_plan_text(plans))),
        ReportSection("limitations", "Limitations", LIMITATIONS),
    ]
    return Document("Trajectory solvers compared", subtitle, tuple(story), tuple(sections))


def _findings(
    judgement: Judgement, motions: Sequence[ShownMotion], untold: Sequence[str]
) -> list[ReportSection]:
    return [
        _results(judgement),
        _tests(judgement),
        _costs(judgement),
        *_motion_sections(motions, untold),
        _audit(judgement),
    ]


def _results(judgement: Judgement) -> ReportSection:
    gone = [
        f"{problem.label} has no {reason}"
        for problem in judgement.problems
        for reason in problem.missing_references
    ]
    return ReportSection(
        "results",
        "Results",
        tuple(gone),
        tables=(
            tables.solver_table(judgement),
            tables.result_table(judgement),
            tables.reference_table(judgement),
        ),
        folds=tuple(_bound_folds(judgement)),
    )


def _bound_folds(judgement: Judgement) -> Iterator[Fold]:
    for problem in judgement.problems[:CONVERGENCE_SHOWN]:
        entries = problem_entries(judgement, problem)
        if entries:
            yield Fold(f"How far from the best: {problem.label}", (bounds_picture(entries, problem.label),))


def _tests(judgement: Judgement) -> ReportSection:
    ranks = judgement.ranks
    said = ""
    if ranks.p is not None:
        said = f"Friedman: statistic {ranks.statistic:.4g} over {ranks.blocks} blocks, p = {ranks.p:.3g}."
    found = (tables.pair_table(judgement),) if judgement.pairs else ()
    return ReportSection("tests", "How sure is the order?", (said,) if said else (), found)


def _costs(judgement: Judgement) -> ReportSection:
    solved = [problem for problem in judgement.problems if problem.best is not None]
    drawn = solved[:CONVERGENCE_SHOWN]
    folds = tuple(Fold(problem.label, (convergence_picture(judgement, problem),)) for problem in drawn)
    more = len(solved) - len(drawn)
    note = (
        (f"Convergence is drawn for the first {len(drawn)} problems, not for {more} more.",) if more else ()
    )
    return ReportSection(
        "costs",
        "Cost of the answers",
        note,
        (
            tables.target_table(judgement, "evaluations"),
            tables.target_table(judgement, "seconds"),
            tables.budget_table(judgement),
        ),
        (runtime_picture(judgement), performance_picture(judgement), data_picture(judgement)),
        folds,
    )


def _audit(judgement: Judgement) -> ReportSection:
    failures = tables.failure_table(judgement)
    found = (tables.audit_table(judgement), *((failures,) if failures else ()))
    return ReportSection("audit", "Audit", tables=found)


def _plan_text(plans: Sequence[tuple[Any, Mapping[str, Any]]]) -> Iterator[str]:
    plan = plans[-1][0]
    limit = "no time limit" if plan.time_limit is None else f"at most {plan.time_limit:g} s"
    memory = "" if plan.memory_limit is None else f" and {plan.memory_limit / 2**30:g} GiB"
    budgets = ", ".join("each solver's own" if budget is None else str(budget) for budget in plan.budgets)
    yield f"Every run may take {limit}{memory}; evaluations: {budgets}. Root of the seeds: {plan.seed}."
    versions = {str(sorted(environment["versions"].items())) for _, environment in plans}
    commits = {str(environment.get("git")) for _, environment in plans}
    if len(versions) > 1 or len(commits) > 1:
        yield (
            f"The folder was filled in {len(plans)} sittings with different versions or source states: rows "
            "of different versions stand side by side."
        )


def _best_motions(store: Store, judgement: Judgement) -> tuple[list[ShownMotion], list[str]]:
    """Return the best motion of every solver on every problem, and why some are not shown."""
    from ocp_traj.trajectory_files import from_json

    motions: list[ShownMotion] = []
    untold: list[str] = []
    cases = store.cases()
    for problem in judgement.problems:
        found = [
            (solver, group.best)
            for solver in judgement.solvers
            if (group := judgement.group(problem, solver)) is not None and group.best is not None
        ]
        if not found:
            continue
        if len(motions) + len(found) > MOTIONS_SHOWN:
            untold.append(f"{problem.label}: not drawn, the page would become too large.")
            continue
        best = [row for _, row in found]
        task = _load(cases[problem.digest]["choice"], problem, untold, store, best)
        if task is None:
            continue
        for solver, row in sorted(found, key=lambda entry: objective_of(entry[1])):
            try:
                curve = store.trajectory(row)
                motion = None if curve is None else from_json(curve, str(row.trajectory_file))
                if motion is not None and motion.n != task.n:
                    raise InputError(f"{row.trajectory_file} has {motion.n} joints, expected {task.n}")
            except InputError as error:
                untold.append(f"{problem.label}, {solver}: not drawn, because its motion is lost ({error}).")
                continue
            if motion is not None:
                motions.append(ShownMotion(problem, solver, task, motion))
    return motions, untold


def _load(
    choice: Mapping[str, Any],
    problem: ComparedProblem,
    untold: list[str],
    store: Store,
    rows: Sequence[StoredRun],
) -> TrajectoryTask | None:
    """Return the task of a problem: from its case where that is unchanged, else as a stored run carries it."""
    from ocp_traj.case import load_case, task_digest

    try:
        task = load_case(choice["case"], choice["overrides"])
        reason = "the case has changed since"
        if task_digest(task) == problem.digest:
            return task
    except OcpTrajError as error:
        reason = f"the case cannot be read any more ({error})"
    for row in rows:
        carried = _carried(store, row, problem)
        if carried is not None:
            return carried
    untold.append(f"{problem.label}: not drawn, because {reason}.")
    return None


def _carried(store: Store, row: StoredRun, problem: ComparedProblem) -> TrajectoryTask | None:
    from ocp_traj.case import task_digest, task_from_json

    try:
        curve = store.trajectory(row) or {}
        task = None if curve.get("task") is None else task_from_json(curve["task"], str(row.trajectory_file))
    except OcpTrajError:  # its motion is told as lost when it is drawn
        return None
    return task if task is not None and task_digest(task) == problem.digest else None


def _motion_sections(motions: Sequence[ShownMotion], untold: Sequence[str]) -> list[ReportSection]:
    folds = []
    for place, motion in enumerate(motions):
        first = place == 0 or motions[place - 1].problem != motion.problem
        duration = f"{motion.trajectory.duration:.4f} s"
        makers: list[Callable[[TrajectoryTask, Trajectory], Picture]] = [_limits_picture]
        if first and motion.task.robot is not None:
            makers.append(path_picture)
        if first and motion.task.has_inertia:
            makers.append(power_picture)
        drawn = tuple(make(motion.task, motion.trajectory) for make in makers)
        title = f"{motion.problem.label}, {motion.solver}: {duration}{' (best)' if first else ''}"
        folds.append(Fold(title, drawn))
    sections = [ReportSection("motions", "Best motions", tuple(untold), folds=tuple(folds))]
    if any(motion.task.robot is not None for motion in motions):
        words = "The robot along the best motion of each problem. Drag to turn, scroll or pinch to zoom."
        sections.append(ReportSection("robot", "The robot moving", (words,)))
    return sections


def _limits_picture(task: TrajectoryTask, trajectory: Trajectory) -> Picture:
    return motion_picture(task, trajectory, relative=True)


def _scenes(motions: Sequence[ShownMotion]) -> list[Scene]:
    """Return the best motion of every problem that has a robot."""
    best: dict[tuple[str, str], ShownMotion] = {}
    for motion in motions:
        if motion.task.robot is not None:
            best.setdefault(motion.problem.key, motion)
    return [
        Scene(f"{motion.problem.label}, {motion.solver}", motion.task, motion.trajectory)
        for motion in best.values()
    ]


def render_html(document: Document, motions: Sequence[ShownMotion] = ()) -> str:
    """Return the report as one page that needs nothing else."""
    from jinja2 import Environment, FileSystemLoader
    from markupsafe import Markup

    environment = Environment(loader=FileSystemLoader(TEMPLATES), autoescape=True, trim_blocks=True)
    template = environment.get_template("report.html.j2")
    return template.render(
        document=document,
        style=Markup((TEMPLATES / "report.css").read_text(encoding="utf-8")),
        script=Markup((TEMPLATES / "report.js").read_text(encoding="utf-8")),
        draw=lambda picture: Markup(draw_picture(picture)),
        viewer=Markup(viewer_html(_scenes(motions), TEMPLATES)),
    )
