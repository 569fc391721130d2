"""``ocp-traj list``: what is there."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import click

from ocp_traj.cli.output import console_for, print_table

if TYPE_CHECKING:
    from rich.console import Console


@click.command(name="list")
@click.argument("what", type=click.Choice(["robots", "solvers", "cases", "families"]), required=False)
def list_names(what: str | None) -> None:
    """List robots, solvers, cases and spline families; with WHAT only those."""
    console = console_for(None)
    for name, show in _LISTS.items():
        if what in (None, name):
            show(console)


def _robots(console: Console) -> None:
    from ocp_traj.robot import robot_names

    print_table(console, "robots", ["name"], [[name] for name in robot_names()])


def _solvers(console: Console) -> None:
    from ocp_traj.solvers import solver_table

    rows = [
        [entry.name, entry.kind, "yes" if entry.available else f"no: {entry.reason}"]
        for entry in solver_table()
    ]
    print_table(console, "solvers", ["name", "kind", "can be used"], rows, words=3)


def _cases(console: Console) -> None:
    from ocp_traj.case import case_names, case_title

    print_table(
        console, "cases", ["name", "title"], [[name, case_title(name)] for name in case_names()], words=2
    )


def _families(console: Console) -> None:
    from ocp_traj.spline import FAMILIES

    rows = [
        [
            family.name,
            family.smoothness,
            "any number of virtual knots" if family.takes_virtual_knots else "takes no virtual knots",
        ]
        for family in FAMILIES.values()
    ]
    print_table(console, "families", ["name", "smoothness", "virtual knots"], rows, words=3)


_LISTS: dict[str, Callable[[Console], None]] = {
    "robots": _robots,
    "solvers": _solvers,
    "cases": _cases,
    "families": _families,
}
