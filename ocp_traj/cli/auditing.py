"""``ocp-traj audit``: judge any motion against a case's limits."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ocp_traj.cli.completion import CaseName
from ocp_traj.cli.motions import task_of
from ocp_traj.cli.output import (
    FEASIBLE,
    INFEASIBLE,
    check_writable,
    console_for,
    json_option,
    overrides_option,
    write_json,
)
from ocp_traj.exceptions import InputError

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory


@click.command(name="audit")
@click.argument("case", type=CaseName(), required=False)
@click.option(
    "--durations",
    metavar="H1,H2,...",
    help="Durations of the K-1 gaps; the case's family without virtual knots.",
)
@click.option("--trajectory", metavar="FILE.csv", help="A trajectory file; the exact curve beside it counts.")
@click.option("--result", metavar="FILE.json", help="A result of solve --json.")
@overrides_option
@json_option
def audit_motion(
    case: str | None,
    durations: str | None,
    trajectory: str | None,
    result: str | None,
    overrides: tuple[str, ...],
    json_file: str | None,
) -> int:
    """Judge a motion, ours or published, against the limits of CASE; default: the task the file carries.

    Leaves with 0 when it is feasible, 1 when it is not.
    """
    if sum(given is not None for given in (durations, trajectory, result)) != 1:
        raise InputError("expected exactly one of --durations, --trajectory and --result")
    from ocp_traj.audit import audit
    from ocp_traj.case import load_case

    check_writable(json_file)
    console = console_for(json_file)
    if durations is not None:
        if case is None:
            raise InputError("--durations needs a CASE")
        motion, task = _from_durations(load_case(case, overrides), durations)
        if task.boundary.acceleration is None:
            console.print("end accelerations are free: a cubic without virtual knots has none to choose")
    else:
        motion, task = _from_file(trajectory, result, case, overrides)
    verdict = audit(task, motion)
    console.print(str(verdict), markup=False)
    write_json({"schema": 1, "case": task.name, **verdict.to_json()}, json_file)
    return FEASIBLE if verdict.feasible else INFEASIBLE


def _from_file(
    trajectory: str | None, result: str | None, case: str | None, overrides: tuple[str, ...]
) -> tuple[Trajectory, TrajectoryTask]:
    from ocp_traj.trajectory_files import read_csv, read_json

    motion = read_csv(trajectory) if trajectory is not None else read_json(str(result))
    path = Path(trajectory if trajectory is not None else str(result))
    task = task_of(motion, path, case, overrides)
    if task is None:
        raise InputError(f"{path} carries no task, expected a CASE to judge it by")
    return motion, task


def _from_durations(task: TrajectoryTask, text: str) -> tuple[Trajectory, TrajectoryTask]:
    """Return the motion, and the task without the end conditions that only virtual knots could meet."""
    from ocp_traj.transcription import trajectory_from_durations
    from ocp_traj.transcription.curve import without_virtual_knots

    try:
        values = [float(entry) for entry in text.split(",")]
    except ValueError:
        raise InputError(f"--durations {text!r} given, expected numbers with commas between") from None
    if len(values) != task.gaps:
        raise InputError(
            f"--durations has {len(values)} numbers, expected {task.gaps}, one a gap between waypoints"
        )
    from ocp_traj.task.preparing import passed_once

    zero_allowed = passed_once(task)
    if not all(0 < value < float("inf") or (value == 0 and zero) for value, zero in zip(values, zero_allowed)):
        raise InputError(f"--durations {text!r} given, expected positive numbers of seconds")
    import numpy as np

    bare = without_virtual_knots(task)
    return trajectory_from_durations(bare, np.array(values)), bare
