"""``ocp-traj compare`` and ``ocp-traj report``: the main job and its report."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ocp_traj.cli.completion import CaseName, SolverName
from ocp_traj.cli.main import INTERRUPTED
from ocp_traj.cli.output import console_for, overrides_option, print_table

if TYPE_CHECKING:
    from rich.console import Console

    from ocp_traj.comparison.report.report import ReportFiles
    from ocp_traj.comparison.runs.compare import ComparisonProgress
    from ocp_traj.comparison.runs.plan import Plan


@click.command(name="compare")
@click.argument("cases", type=CaseName(), nargs=-1, metavar="[CASE]...")
@click.option(
    "--solvers",
    type=SolverName(),
    metavar="A,B,...",
    help="Solvers, with parameters: ipopt,pso[inertia=linear].",
)
@click.option("--seeds", type=click.IntRange(min=1), metavar="N", help="Runs of every solver on every case.")
@click.option("--seed", type=click.IntRange(min=0), metavar="N", help="Root of all seeds.")
@click.option(
    "--budget",
    "budgets",
    type=click.IntRange(min=1),
    multiple=True,
    metavar="EVALS",
    help="Evaluations a run may use; may be repeated.",
)
@click.option(
    "--time-limit", type=click.FloatRange(min=0, min_open=True), metavar="S", help="Seconds a run may take."
)
@click.option(
    "--memory-limit", type=click.FloatRange(min=0, min_open=True), metavar="GB", help="Memory a run may take."
)
@click.option(
    "--plan", "plan_file", metavar="FILE.toml", help="Read all this from a file; options override it."
)
@overrides_option
@click.option(
    "--references/--no-references", default=None, help="Compute TOPP-RA and the kinematic bound (default)."
)
@click.option(
    "--jobs", type=click.IntRange(min=1), metavar="N", help="Worker processes; default: the usable cores."
)
@click.option("--dask", metavar="ADDRESS", help="Use the workers of this Dask scheduler instead.")
@click.option(
    "--output", default="comparison", show_default=True, metavar="DIR", help="Folder of results and report."
)
def compare_solvers(jobs: int | None, dask: str | None, output: str, **given: Any) -> int:
    """Compare solvers on CASEs: every case x solver x seed, resumable, with a report.

    Without arguments: ur5-torque-limited and machines-2024-490 with ipopt, ssa and pso, 3 seeds. What is
    finished is kept; the same command again does only what is missing.
    """
    from ocp_traj.comparison.report.report import write_report
    from ocp_traj.comparison.runs.compare import compare

    console = console_for(None)
    folder = Path(output)
    plan = build_plan(**given)
    try:
        with show_progress(console) as progress:
            compare(plan, folder, jobs or usable_cores(), dask, progress)
    except KeyboardInterrupt:
        console.print(
            f"stopped; what is finished is kept in {folder}, the same command goes on from there",
            markup=False,
        )
        return INTERRUPTED
    with console.status("report …"):
        files = write_report(folder)
    show_report(console, files, folder)
    return 0


@click.command(name="report")
@click.argument("folder", metavar="DIR")
def write_report_again(folder: str) -> None:
    """Rebuild the report of a finished or unfinished comparison in DIR."""
    from ocp_traj.comparison.report.report import write_report

    console = console_for(None)
    with console.status("report …"):
        files = write_report(Path(folder))
    show_report(console, files, Path(folder))


def build_plan(
    cases: tuple[str, ...],
    solvers: str | None,
    seeds: int | None,
    seed: int | None,
    budgets: tuple[int, ...],
    time_limit: float | None,
    memory_limit: float | None,
    plan_file: str | None,
    overrides: tuple[str, ...],
    references: bool | None,
) -> Plan:
    """Return the plan of the file, or the default one, with the options given put over it.

    Solver names are checked and written in full.
    """
    from dataclasses import replace

    from ocp_traj.case import read_toml
    from ocp_traj.comparison.runs.plan import CaseChoice, Plan, canonical_name, plan_from_table
    from ocp_traj.solvers import parse_solver, split_solvers

    plan = Plan() if plan_file is None else plan_from_table(read_toml(Path(plan_file), plan_file), plan_file)
    changes: dict[str, Any] = {
        "seeds": seeds,
        "seed": seed,
        "budgets": budgets or None,
        "time_limit": time_limit,
        "memory_limit": None if memory_limit is None else int(memory_limit * 2**30),
        "references": references,
    }
    if cases:
        changes["cases"] = tuple(CaseChoice(case) for case in cases)
    if solvers is not None:
        changes["solvers"] = tuple(split_solvers(solvers))
    plan = replace(plan, **{name: value for name, value in changes.items() if value is not None})
    choices = tuple(
        CaseChoice(_findable(choice.case), (*choice.overrides, *overrides)) for choice in plan.cases
    )
    for name in plan.solvers:
        parse_solver(name)  # raises where a solver does not exist, has no such setting, or cannot be loaded
    return replace(plan, cases=choices, solvers=tuple(canonical_name(name) for name in plan.solvers))


def _findable(case: str) -> str:
    """Return a case file's absolute path, so that the report finds it from any folder; names stay names."""
    from ocp_traj.case import case_names

    return str(Path(case).absolute()) if case not in case_names() and Path(case).is_file() else case


def usable_cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def show_progress(console: Console) -> Iterator[Callable[[ComparisonProgress], None]]:
    """Show a bar with the remaining time; without a terminal, a line a run."""
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, disable=not console.is_terminal) as bar:
        task = bar.add_task("runs", total=None)

        def show(progress: ComparisonProgress) -> None:
            bar.update(task, total=progress.total, completed=progress.finished)
            if progress.spec is None or progress.record is None:
                if progress.finished:
                    bar.console.print(
                        f"{progress.finished} of {progress.total} runs are there already", markup=False
                    )
                return
            record = progress.record
            verdict = "feasible" if record.feasible else (record.reason or record.status.replace("_", " "))
            objective = "" if record.objective is None else f", objective {record.objective:.6g}"
            bar.console.print(
                f"[{progress.finished}/{progress.total}] {progress.spec.case_name}, {progress.spec.solver}, "
                f"seed {progress.spec.seed_index + 1}: {verdict}{objective}",
                markup=False,
            )

        yield show


def show_report(console: Console, files: ReportFiles, folder: Path) -> None:
    """Print the results and where everything is."""
    from ocp_traj.comparison.report.tables import terminal_table

    table = terminal_table(files.judgement)
    rows = [[cell.text for cell in row] for row in table.rows]
    print_table(console, table.caption, table.columns, rows, words=2)
    for sentence in files.story:
        console.print(f"• {sentence}", markup=False)
    console.print(f"\n{folder / 'results.sqlite'}\n{files.markdown}\n{files.html}", markup=False)
