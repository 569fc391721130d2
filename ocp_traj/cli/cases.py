"""``ocp-traj init`` and ``ocp-traj check``: start a case file, and find out what is wrong with one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ocp_traj.cli.completion import CaseName
from ocp_traj.cli.main import WRONG_INPUT
from ocp_traj.cli.output import console_for, overrides_option
from ocp_traj.exceptions import InputError

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask


@click.command(name="init")
@click.argument("file", default="case.toml")
@click.option("--force", is_flag=True, help="Overwrite an existing file.")
def init_case(file: str, force: bool) -> None:
    """Write a commented case to start from into FILE (default case.toml)."""
    from ocp_traj.case import case_template

    path = Path(file)
    try:
        with path.open("w" if force else "x", encoding="utf-8") as handle:
            handle.write(case_template())
    except FileExistsError:
        raise InputError(f"{file} exists already, expected a new name or --force") from None
    except OSError as error:
        raise InputError(f"cannot write {file}: {error.strerror}") from None
    click.echo(f"wrote {file}; next: ocp-traj check {file}, ocp-traj solve {file}")


@click.command(name="check")
@click.argument("cases", type=CaseName(), nargs=-1, required=True, metavar="CASE...")
@overrides_option
def check_cases(cases: tuple[str, ...], overrides: tuple[str, ...]) -> int:
    """Read cases and say what is wrong with them, or what they ask for."""
    from ocp_traj.case.loading import limits_named, load_case
    from ocp_traj.cli.joints import case_joints, hints, joint_lines

    console = console_for(None)
    wrong = 0
    for case in cases:
        try:
            task = load_case(case, overrides)
            text = describe(task)
        except InputError as error:
            click.echo("ocp-traj: " + " ".join(str(error).split()), err=True)
            wrong += 1
        else:
            console.print(text, markup=False)
            found = case_joints(task, limits_named(case, overrides))
            for line in (*joint_lines(found), *hints(task)):
                console.print(f"  {line}", markup=False)
    return WRONG_INPUT if wrong else 0


def describe(task: TrajectoryTask) -> str:
    """Return in a few lines what a task asks for.

    Raises
    ------
    TaskError
        With equal consecutive waypoints as one point there are too few for the spline.
    """
    limited = [name.replace("_", " ") for name in task.limits.names if task.limited(name)]
    robot = "no robot (kinematic)" if task.robot is None else f"robot {task.robot.name}"
    knots = f", {task.virtual_knots} virtual knots per gap" if task.virtual_knots else ""
    weights = ", ".join(
        f"{name.replace('_', ' ')} {weight:g}" for name, weight in task.objective.weights.items()
    )
    return (
        f"{task.name}: {task.title}\n"
        f"  {robot}, {task.n} joints, {len(task.waypoints)} waypoints\n"
        f"  {task.family}{knots}\n"
        f"  limits: {', '.join(limited) or 'none'}\n"
        f"  minimise: {weights or 'own objective'}"
        + _equal_waypoints(task)
        + _free_ends(task)
    )


def _free_ends(task: TrajectoryTask) -> str:
    if not task.limited("jerk") or task.boundary.acceleration is not None:
        return ""
    return "\n  end accelerations are free: the jerk at both ends is not limited"


def _equal_waypoints(task: TrajectoryTask) -> str:
    """Say which waypoints are one point, and which equal ones are two instants; nothing where there are none."""
    from ocp_traj.task.preparing import passed_once, prepare

    lasting = prepare(task).kept
    once = [gap for gap in range(task.gaps) if gap not in lasting]
    equal = (task.waypoints[1:] == task.waypoints[:-1]).all(axis=1)
    twice = [gap for gap in range(task.gaps) if equal[gap] and not passed_once(task)[gap]]
    lines = [
        f"\n  waypoints {', '.join(f'{gap + 1} and {gap + 2}' for gap in gaps)} are equal: {meaning}"
        for gaps, meaning in (
            (once, "one point, passed once (a bound of the gap's duration makes them two instants)"),
            (twice, "two instants, as their gap's duration has a bound"),
        )
        if gaps
    ]
    return "".join(lines)
