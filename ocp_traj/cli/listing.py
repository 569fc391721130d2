"""``ocp-traj list``: what is there."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import click

from ocp_traj.cli.output import console_for, print_table, write_json
from ocp_traj.exceptions import InputError

if TYPE_CHECKING:
    from rich.console import Console


@click.command(name="list")
@click.argument("what", type=click.Choice(["robots", "solvers", "cases", "families", "joints"]), required=False)
@click.argument("subject", required=False, metavar="[CASE|URDF]")
@click.option("--json", "as_json", is_flag=True, help="Print the joints as JSON.")
def list_names(what: str | None, subject: str | None, as_json: bool) -> None:
    """List robots, solvers, cases and spline families; with WHAT only those.

    `list joints CASE|URDF` lists the joints by name with the numbers of their limits, and where each comes from.
    """
    if what == "joints":
        return _joints(subject, as_json)
    if subject is not None or as_json:
        raise InputError(f"{subject or '--json'} given, which belongs to `list joints CASE|URDF`")
    console = console_for(None)
    for name, show in _LISTS.items():
        if what in (None, name):
            show(console)
    return None


def _joints(subject: str | None, as_json: bool) -> None:
    from ocp_traj.case.loading import case_names, limits_named, load_case
    from ocp_traj.cli.joints import case_joints, is_description, joint_lines, robot_joints
    from ocp_traj.robot import load_robot, robot_from_urdf, robot_names

    if subject is None:
        raise InputError("list joints: expected a case or a robot description")
    if is_description(subject):
        found = robot_joints(robot_from_urdf(subject))
    elif subject in robot_names() and subject not in case_names():
        found = robot_joints(load_robot(subject))
    else:
        found = case_joints(load_case(subject), limits_named(subject))
    if as_json:
        return write_json(found, "-")
    for line in joint_lines(found):
        click.echo(line)
    return None


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
