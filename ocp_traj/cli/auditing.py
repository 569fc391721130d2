"""``ocp-traj audit``, ``prove``, ``verify``: judge any motion against a case's limits; proofs that anyone can check."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ocp_traj.cli.completion import CaseName
from ocp_traj.cli.motions import read_motion, task_of
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

PROVED, NOT_PROVED = 0, 1
SEARCH = 60.0
"""Seconds that the search for the evidence of a bound may take."""


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


@click.command(name="prove")
@click.argument("case", type=CaseName(), required=False)
@click.option("--result", metavar="FILE.json", help="The motion of a result of solve --json.")
@click.option("--trajectory", metavar="FILE", help="A trajectory file; the exact curve beside a CSV counts.")
@click.option("--bound", is_flag=True, help="Prove instead that no motion is shorter than the certified bound.")
@click.option(
    "--time-limit",
    type=click.FloatRange(min=0, min_open=True),
    default=SEARCH,
    show_default=True,
    metavar="S",
    help="Seconds for the evidence of a bound.",
)
@overrides_option
@click.option("--output", required=True, metavar="FILE.proof.json", help="Where the proof is written.")
def prove_motion(
    case: str | None,
    result: str | None,
    trajectory: str | None,
    bound: bool,
    time_limit: float,
    overrides: tuple[str, ...],
    output: str,
) -> int:
    """Prove that a motion keeps every limit at every instant, or, with --bound, that none is shorter.

    CASE is another task than the one that the motion's file carries. Leaves with 1 where there is no proof, and says
    which limit or statement could not be proved.
    """
    if sum((result is not None, trajectory is not None, bound)) != 1:
        raise InputError("expected exactly one of --result, --trajectory and --bound")
    check_writable(output)
    if bound:
        return _prove_bound(case, overrides, time_limit, output)
    path = Path(str(result or trajectory))
    motion = read_motion(path)
    task = task_of(motion, path, case, overrides)
    if task is None:
        raise InputError(f"{path} carries no task, expected CASE")
    return write_if_proved(output, lambda: _proof(task, motion), click.echo)


def _proof(task: TrajectoryTask, motion: Trajectory) -> dict[str, Any]:
    from ocp_traj.proofs import prove

    return prove(task, motion)


def _prove_bound(case: str | None, overrides: tuple[str, ...], time_limit: float, output: str) -> int:
    from ocp_traj.case import load_case
    from ocp_traj.proofs import prove_bound

    if case is None:
        raise InputError("--bound needs a CASE")
    task = load_case(case, overrides)
    return write_if_proved(output, lambda: prove_bound(task, time_limit), click.echo)


def write_if_proved(path: str, make: Callable[[], dict[str, Any]], tell: Callable[[str], None]) -> int:
    """Write a proof and say what it states, or say what could not be proved; return the exit status."""
    from ocp_traj.proofs import NotProved, check, write_proof

    try:
        document = make()
    except NotProved as reason:
        tell(f"not proved: {reason}")
        return NOT_PROVED
    write_proof(document, path)
    tell(f"proved: {check(document).statement}")
    return PROVED


@click.command(name="verify")
@click.argument("file", metavar="FILE.proof.json")
@click.option("--case", type=CaseName(), help="Refuse a proof of another task than this case's.")
@overrides_option
def verify_proof(file: str, case: str | None, overrides: tuple[str, ...]) -> int:
    """Check a proof with the small checker, which is also one file of standard-library Python to run alone.

    Leaves with 0 where everything holds, 1 with the first statement that does not, 2 where the file is no proof.
    """
    from ocp_traj.case import load_case
    from ocp_traj.proofs import NotAProof, Refused, check_file, is_about

    if overrides and case is None:
        raise InputError("--set needs --case")
    task = None if case is None else load_case(case, overrides)
    try:
        report = check_file(file)
    except Refused as reason:
        click.echo(f"refused: {reason}")
        return NOT_PROVED
    except NotAProof as reason:
        raise InputError(f"{file} is no proof: {reason}") from None
    if task is not None and not is_about(json.loads(Path(file).read_text(encoding="utf-8")), task):
        click.echo(f"refused: the proof is about another task than that of {task.name}")
        return NOT_PROVED
    click.echo(f"proved: {report.statement}")
    return PROVED
