"""``ocp-traj export``: motions for controllers, and comparisons as tables."""

from __future__ import annotations

from pathlib import Path

import click

from ocp_traj.cli.output import overrides_option, write_text
from ocp_traj.cli.plotting import read_motion, task_of
from ocp_traj.exceptions import InputError

_RATES = {"csv": 1000.0, "ros2": 100.0, "urscript": 125.0}
_ENDINGS = {"csv": ".csv", "ros2": ".yaml", "urscript": ".script", "parquet": ".parquet"}


@click.command(name="export")
@click.argument("file")
@click.option("--format", "kind", type=click.Choice(list(_ENDINGS)), required=True)
@click.option(
    "--rate",
    type=click.FloatRange(min=0, min_open=True),
    metavar="HZ",
    help="Samples a second; default 1000 (csv), 100 (ros2), 125 (urscript).",
)
@click.option("--joint-names", metavar="A,B,...", help="Names for ros2; default: the robot's.")
@click.option(
    "--case", help="Case whose limits and robot belong to the motion; default: the one named in FILE."
)
@overrides_option
@click.option("--output", metavar="FILE", help="Default: FILE with another ending.")
def export_file(
    file: str,
    kind: str,
    rate: float | None,
    joint_names: str | None,
    case: str | None,
    overrides: tuple[str, ...],
    output: str | None,
) -> None:
    """Export a trajectory (.csv, .spline.json) or a result (.json) for controllers.

    csv: samples; ros2: a FollowJointTrajectory goal (YAML); urscript: a servoj program for UR arms. A
    comparison's folder goes to csv or parquet: all its runs as one table.
    """
    path = Path(file)
    if path.is_dir():
        target = Path(output) if output else path / f"results{_ENDINGS[kind]}"
        _export_comparison(path, kind, target)
    else:
        target = (
            Path(output) if output else path.with_name(f"{path.name.split('.')[0]}-{kind}{_ENDINGS[kind]}")
        )
        _export_motion(path, kind, rate or _RATES.get(kind, 0.0), joint_names, case, overrides, target)
    click.echo(str(target))


def _export_comparison(folder: Path, kind: str, target: Path) -> None:
    from ocp_traj.comparison.runs.store import Store
    from ocp_traj.comparison.runs.table_files import export_table

    if kind not in ("csv", "parquet"):
        raise InputError(f"{folder} is a comparison, expected --format csv or parquet")
    with Store(folder) as store:
        export_table(store, target, kind)


def _export_motion(
    path: Path,
    kind: str,
    rate: float,
    joint_names: str | None,
    case: str | None,
    overrides: tuple[str, ...],
    target: Path,
) -> None:
    from ocp_traj.controller_files import sample_for_controller, to_ros2, to_urscript
    from ocp_traj.trajectory_files import write_csv

    if kind == "parquet":
        raise InputError(f"{path} is a motion, expected --format csv, ros2 or urscript")
    motion = read_motion(path)
    task = task_of(motion, path, case, overrides)
    if kind == "csv":
        torques = task.robot.torque if task.has_inertia and task.robot is not None else None
        write_csv(target, motion, rate, torques)
    elif kind == "ros2":
        names = joint_names.split(",") if joint_names else _joint_names(task.robot, motion.n)
        samples = sample_for_controller(motion, rate, task)
        _tell_scale(samples.scale)
        write_text(target, to_ros2(samples, names))
    else:
        program, scale = to_urscript(motion, rate)
        _tell_scale(scale)
        write_text(target, program)


def _joint_names(robot: object | None, n: int) -> list[str]:
    names = getattr(robot, "joint_names", None)
    return list(names) if names else [f"joint_{joint + 1}" for joint in range(n)]


def _tell_scale(scale: float) -> None:
    if scale > 1.0:
        click.echo(f"slowed by a factor of {scale:.9g} so that limits are kept after sampling", err=True)
