"""``ocp-traj pareto``: time against energy, or against another objective."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ocp_traj.cli.completion import CaseName, SolverName
from ocp_traj.cli.output import (
    FEASIBLE,
    INFEASIBLE,
    check_writable,
    console_for,
    json_option,
    overrides_option,
    print_table,
    write_json,
    write_text,
)
from ocp_traj.exceptions import InputError
from ocp_traj.quantities import COSTS

if TYPE_CHECKING:
    from ocp_traj.pareto import FrontPoint, ParetoFront
    from ocp_traj.task import TrajectoryTask

INTERRUPTED = 130


@click.command(name="pareto")
@click.argument("case", type=CaseName())
@click.option(
    "--points", default=10, show_default=True, type=click.IntRange(min=2), help="Points of the front."
)
@click.option(
    "--objective",
    metavar="NAME",
    help=f"Second objective: {', '.join(name for name in COSTS if name != 'time')}; default: "
    "what the case weighs beside time, else energy.",
)
@click.option(
    "--slowest",
    default=2.0,
    show_default=True,
    type=click.FloatRange(min=1, min_open=True),
    help="Last bound on the duration, in units of the shortest one.",
)
@click.option("--solver", type=SolverName(), default="ipopt", show_default=True, help="Name, with parameters.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(min=0))
@click.option(
    "--time-limit", type=click.FloatRange(min=0, min_open=True), metavar="S", help="Seconds a point may take."
)
@overrides_option
@click.option("--output", metavar="FILE.csv", help="Write the points as a table.")
@click.option("--plot", "picture", metavar="FILE.png", help="Draw the front; PNG, PDF or SVG.")
@json_option
def pareto_case(
    case: str,
    points: int,
    objective: str | None,
    slowest: float,
    solver: str,
    seed: int,
    time_limit: float | None,
    overrides: tuple[str, ...],
    output: str | None,
    picture: str | None,
    json_file: str | None,
) -> int:
    """Follow the front of duration against a second objective of CASE, from its shortest motion to slower ones.

    Every point is audited. Leaves with 0 when there is a feasible one, 1 when there is none, 130 after Ctrl-C; what was
    found is written in any case.
    """
    from ocp_traj.case import load_case
    from ocp_traj.pareto import collect_front

    _check_ending(picture)
    check_writable(output, picture, json_file)
    console = console_for(json_file)
    task = load_case(case, overrides)
    options: dict[str, Any] = {
        "objective": objective,
        "slowest": slowest,
        "solver": solver,
        "seed": seed,
        "time_limit": time_limit,
    }
    found, interrupted = _follow(task, points, options)
    front = collect_front(task, objective, found)
    title = f"{task.name}: duration against {front.quantity}"
    print_table(console, title, front.columns, front.rows(), words=0)
    for index, result in enumerate(front.results):
        if not result.feasible:
            console.print(f"point {index + 1}: {result.message}", markup=False)
    _write(front, output, picture)
    write_json(front.to_json(), json_file)
    if interrupted:
        click.echo("interrupted", err=True)
        return INTERRUPTED
    return FEASIBLE if front.feasible.any() else INFEASIBLE


def _follow(task: TrajectoryTask, points: int, options: dict[str, Any]) -> tuple[list[FrontPoint], bool]:
    """Return the points found and whether Ctrl-C stopped the search; each is told on standard error."""
    from ocp_traj.pareto import follow_front

    found: list[FrontPoint] = []
    try:
        for point in follow_front(task, points, **options):
            found.append(point)
            result = point.result
            verdict = "feasible" if result.feasible else result.status.replace("_", " ")
            duration = "no motion" if result.duration is None else f"{result.duration:.4f} s"
            place = f"[{point.index + 1}/{points}] within {point.bound:.4f} s"
            click.echo(f"{place}: {duration}, {verdict}", err=True)
    except KeyboardInterrupt:
        return found, True
    return found, False


def _check_ending(picture: str | None) -> None:
    """Refuse a picture that could not be written before the work is done."""
    from ocp_traj.pictures.matplotlib_ import FORMATS

    if picture is not None and Path(picture).suffix.lower() not in FORMATS:
        raise InputError(f"{picture} ends in {Path(picture).suffix!r}, expected one of {', '.join(FORMATS)}")


def _write(front: ParetoFront, output: str | None, picture: str | None) -> None:
    if output is not None:
        write_text(Path(output), front_table(front))
    if picture is not None:
        from ocp_traj.pictures.pareto import save_front

        save_front(front, Path(picture))


def front_table(front: ParetoFront) -> str:
    """Return the points as CSV with 17 digits; empty cells where there is no motion."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["point", "bound", "duration", front.quantity, "feasible", "dominated", "status"])
    for index, result in enumerate(front.results):
        numbers = (front.bounds[index], front.durations[index], front.values[index])
        cells = [format(value, ".17g") if math.isfinite(value) else "" for value in numbers]
        flags = [str(bool(front.feasible[index])).lower(), str(bool(front.dominated[index])).lower()]
        writer.writerow([index + 1, *cells, *flags, result.status])
    return text.getvalue()
