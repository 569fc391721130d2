"""``ocp-traj reference``: time-optimal references of a case."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ocp_traj.cli.completion import CaseName
from ocp_traj.cli.output import (
    check_writable,
    console_for,
    json_option,
    overrides_option,
    print_table,
    write_json,
)
from ocp_traj.exceptions import InputError


@click.command(name="reference")
@click.argument("case", type=CaseName(), required=False)
@click.option(
    "--result", metavar="FILE.json", help="Also drive the path of this result as fast as it allows."
)
@click.option(
    "--jerk", is_flag=True, help="Also estimate durations with bounded jerk (local optima, no bounds)."
)
@click.option(
    "--certificate", is_flag=True, help="Also prove the best durations of the case's spline family (minutes)."
)
@click.option(
    "--time-limit",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="S",
    help="Seconds for all of them together (20, with a certificate 140).",
)
@click.option(
    "--plot",
    "picture",
    metavar="FILE",
    help="Draw phase planes and all durations: PNG, PDF or SVG.",
)
@overrides_option
@json_option
def reference_case(
    case: str | None,
    result: str | None,
    jerk: bool,
    certificate: bool,
    time_limit: float | None,
    picture: str | None,
    overrides: tuple[str, ...],
    json_file: str | None,
) -> None:
    """Compute TOPP-RA, convex path tracking and the kinematic lower bound for CASE, or for the task of --result."""
    from ocp_traj.case import load_case
    from ocp_traj.references import collect_references
    from ocp_traj.trajectory_files import read_json

    check_writable(picture, json_file)
    console = console_for(json_file)
    if case is None and result is None:
        raise InputError("expected a CASE, or a --result that carries its task")
    task = load_case(case or str(result), overrides)
    motion = None if result is None else read_json(result)
    with console.status(f"references of {task.name} …"):
        found = collect_references(task, motion, jerk=jerk, certificate=certificate, time_limit=time_limit)
    table = found.to_json()
    print_table(console, f"references of {task.name}", ["reference", "", "duration"], _rows(table))
    for name, said in table["messages"].items():
        console.print(f"{name.replace('_', ' ')}: {said}", markup=False)
    if picture is not None:
        from ocp_traj.pictures.matplotlib_ import save_picture
        from ocp_traj.pictures.references import references_picture

        durations = {} if motion is None else {"the result given": motion.duration}
        save_picture(references_picture(found, motion, durations), Path(picture))
        console.print(picture, markup=False)
    write_json(table, json_file)


def _rows(found: dict[str, Any]) -> list[list[str]]:
    return [
        [name.replace("_", " "), part, "none" if value is None else f"{value:.6f} s"]
        for name, entry in found.items()
        if isinstance(entry, dict)
        for part, value in entry.items()
        if value is None or isinstance(value, (int, float))
    ]
