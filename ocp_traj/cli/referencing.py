"""``ocp-traj reference``: time-optimal references of a case."""

from __future__ import annotations

from typing import Any

import click

from ocp_traj.cli.output import console_for, json_option, overrides_option, print_table, write_json


@click.command(name="reference")
@click.argument("case")
@click.option(
    "--result", metavar="FILE.json", help="Also drive the path of this result as fast as it allows."
)
@overrides_option
@json_option
def reference_case(case: str, result: str | None, overrides: tuple[str, ...], json_file: str | None) -> None:
    """Compute TOPP-RA, convex path tracking and the kinematic lower bound for CASE."""
    from ocp_traj.case import load_case
    from ocp_traj.references import references
    from ocp_traj.trajectory_files import read_json

    console = console_for(json_file)
    task = load_case(case, overrides)
    motion = None if result is None else read_json(result)
    with console.status(f"references of {task.name} …"):
        found = references(task, motion)
    print_table(console, f"references of {task.name}", ["reference", "", "duration"], _rows(found))
    write_json(found, json_file)


def _rows(found: dict[str, Any]) -> list[list[str]]:
    return [
        [name.replace("_", " "), part, "none" if value is None else f"{value:.6f} s"]
        for name, entry in found.items()
        if isinstance(entry, dict)
        for part, value in entry.items()
        if value is None or isinstance(value, (int, float))
    ]
