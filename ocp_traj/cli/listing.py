"""``ocp-traj list``: what is there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import click

from ocp_traj.cli.output import console_for, print_table, write_json
from ocp_traj.exceptions import InputError


@dataclass(frozen=True)
class Listing:
    """A list as JSON entries and as the rows of a table.

    Attributes
    ----------
    columns : tuple of str
    rows : list of list of str
    entries : list
        What ``--json`` prints: a text or an object each.
    words : int
        Columns that hold words.
    """

    columns: tuple[str, ...]
    rows: list[list[str]]
    entries: list[Any]
    words: int = 1


@click.command(name="list")
@click.argument("what", type=click.Choice(["robots", "solvers", "cases", "families", "joints"]), required=False)
@click.argument("subject", required=False, metavar="[CASE|URDF]")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def list_names(what: str | None, subject: str | None, as_json: bool) -> None:
    """List robots, solvers, cases and spline families; with WHAT only those.

    `list joints CASE|URDF` lists the joints by name with the numbers of their limits, and where each comes from.
    """
    if what == "joints":
        return _joints(subject, as_json)
    if subject is not None:
        raise InputError(f"{subject} given, which belongs to `list joints CASE|URDF`")
    found = {name: make() for name, make in _LISTS.items() if what in (None, name)}
    if as_json:
        return write_json({"schema": 1, **{name: listing.entries for name, listing in found.items()}}, "-")
    console = console_for(None)
    for name, listing in found.items():
        print_table(console, name, listing.columns, listing.rows, words=listing.words)
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


def _robots() -> Listing:
    from ocp_traj.robot import robot_names

    names = robot_names()
    return Listing(("name",), [[name] for name in names], names)


def _solvers() -> Listing:
    from ocp_traj.solvers import solver_table

    table = solver_table()
    rows = [
        [entry.name, entry.kind, "yes" if entry.available else f"no: {entry.reason}"] for entry in table
    ]
    entries = [
        {"name": entry.name, "kind": entry.kind, "available": entry.available, "reason": entry.reason or None}
        for entry in table
    ]
    return Listing(("name", "kind", "can be used"), rows, entries, words=3)


def _cases() -> Listing:
    from ocp_traj.case import case_names, case_title

    titles = {name: case_title(name) for name in case_names()}
    entries = [{"name": name, "title": title} for name, title in titles.items()]
    return Listing(("name", "title"), [list(pair) for pair in titles.items()], entries, words=2)


def _families() -> Listing:
    from ocp_traj.spline import FAMILIES

    families = list(FAMILIES.values())
    rows = [
        [
            family.name,
            family.smoothness,
            f"any number, default {family.default_virtual_knots}" if family.takes_virtual_knots else "none",
        ]
        for family in families
    ]
    entries = [
        {
            "name": family.name,
            "degree": family.degree,
            "smoothness": family.smoothness,
            "takes_virtual_knots": family.takes_virtual_knots,
            "default_virtual_knots": family.default_virtual_knots,
        }
        for family in families
    ]
    return Listing(("name", "smoothness", "virtual knots"), rows, entries, words=3)


_LISTS: dict[str, Callable[[], Listing]] = {
    "robots": _robots,
    "solvers": _solvers,
    "cases": _cases,
    "families": _families,
}
