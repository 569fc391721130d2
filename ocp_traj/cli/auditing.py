"""``ocp-traj audit``: judge any motion against a case's limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from ocp_traj.cli.output import FEASIBLE, INFEASIBLE, console_for, json_option, overrides_option, write_json
from ocp_traj.exceptions import InputError

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory


@click.command(name="audit")
@click.argument("case")
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
    case: str,
    durations: str | None,
    trajectory: str | None,
    result: str | None,
    overrides: tuple[str, ...],
    json_file: str | None,
) -> int:
    """Judge a motion, ours or published, against the limits of CASE.

    Leaves with 0 when it is feasible, 1 when it is not.
    """
    if sum(given is not None for given in (durations, trajectory, result)) != 1:
        raise InputError("expected exactly one of --durations, --trajectory and --result")
    from ocp_traj.audit import audit
    from ocp_traj.case import load_case
    from ocp_traj.trajectory_files import read_csv, read_json

    task = load_case(case, overrides)
    if durations is not None:
        motion = _from_durations(task, durations)
    else:
        motion = read_csv(trajectory) if trajectory is not None else read_json(str(result))
    if motion.n != task.n:
        raise InputError(f"the motion has {motion.n} joints, expected {task.n} as in case {task.name}")
    verdict = audit(task, motion)
    console_for(json_file).print(str(verdict), markup=False)
    write_json({"schema": 1, "case": task.name, **verdict.to_json()}, json_file)
    return FEASIBLE if verdict.feasible else INFEASIBLE


def _from_durations(task: TrajectoryTask, text: str) -> Trajectory:
    from ocp_traj.transcription import trajectory_from_durations

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

    return trajectory_from_durations(task.changed(virtual_knots=0), np.array(values))
