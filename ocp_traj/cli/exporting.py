"""``ocp-traj export``: motions for controllers, and comparisons as tables and logs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ocp_traj.cli.completion import CaseName
from ocp_traj.cli.motions import read_motion, task_of
from ocp_traj.cli.output import check_writable, overrides_option, write_text
from ocp_traj.exceptions import InputError

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

_RATES = {"csv": 1000.0, "ros2": 100.0, "urscript": 125.0}
_ENDINGS = {"csv": ".csv", "ros2": ".yaml", "urscript": ".script", "parquet": ".parquet", "ioh": "", "coco": ""}
_OF_COMPARISONS = ("csv", "parquet", "ioh", "coco")


@click.command(name="export")
@click.argument("file")
@click.option("--format", "kind", type=click.Choice(list(_ENDINGS)), required=True)
@click.option(
    "--rate",
    type=click.FloatRange(min=0, min_open=True),
    metavar="HZ",
    help="Samples a second; default 1000 (csv), 100 (ros2), 125 (urscript).",
)
@click.option("--joint-names", metavar="A,B,...", help="Names for controllers; default: the robot's.")
@click.option(
    "--case",
    type=CaseName(),
    help="Case whose limits and robot belong to the motion; default: the one FILE carries or names."
)
@overrides_option
@click.option("--force", is_flag=True, help="For a controller in spite of what speaks against it.")
@click.option("--output", metavar="FILE", help="Default: FILE with another ending.")
def export_file(
    file: str,
    kind: str,
    rate: float | None,
    joint_names: str | None,
    case: str | None,
    overrides: tuple[str, ...],
    force: bool,
    output: str | None,
) -> None:
    """Export a trajectory (.csv, .spline.json) or a result (.json) for controllers.

    csv: samples; ros2: a FollowJointTrajectory goal (YAML); urscript: a servoj program for UR arms. A motion that is
    not feasible or ends moving is refused for a controller unless --force is given. A comparison's folder goes to csv
    or parquet, all its runs as one table, or to ioh or coco, logs for the analysers of IOHprofiler and COCO.
    """
    path = Path(file)
    name = f"results{_ENDINGS[kind]}" if _ENDINGS[kind] else f"{kind}-logs"
    beside = path.with_name(f"{path.name.split('.')[0]}-{kind}{_ENDINGS[kind]}")
    target = Path(output) if output else path / name if path.is_dir() else beside
    if path.is_dir():
        _export_comparison(path, kind, target)
    elif kind not in _RATES:
        raise InputError(f"{path} is a motion, expected --format csv, ros2 or urscript")
    else:
        check_writable(target)
        motion = read_motion(path)
        task = task_of(motion, path, case, overrides)
        if kind == "csv":
            _export_samples(motion, task, rate or _RATES[kind], target)
        else:
            names = _joint_names(joint_names, task, motion.n, path)
            write_text(target, _controller_text(motion, task, kind, rate or _RATES[kind], names, force))
    click.echo(str(target))


def _export_comparison(folder: Path, kind: str, target: Path) -> None:
    from ocp_traj.comparison.logs import logged_functions, write_coco, write_ioh
    from ocp_traj.comparison.runs.store import Store
    from ocp_traj.comparison.runs.table_files import export_table
    from ocp_traj.version import __version__

    if kind not in _OF_COMPARISONS:
        raise InputError(f"{folder} is a comparison, expected --format {', '.join(_OF_COMPARISONS)}")
    with Store(folder) as store:
        if kind in ("csv", "parquet"):
            export_table(store, target, kind)
            return
        write = write_ioh if kind == "ioh" else write_coco
        try:
            write(logged_functions(store.rows()), target, __version__)
        except OSError as error:
            raise InputError(f"cannot write {target}: {error.strerror or error}") from None


def _export_samples(motion: Trajectory, task: TrajectoryTask | None, rate: float, target: Path) -> None:
    from ocp_traj.trajectory_files import write_csv

    robot = task.robot if task is not None and task.has_inertia else None
    write_csv(target, motion, rate, None if robot is None else robot.torque, task)


def _controller_text(
    motion: Trajectory,
    task: TrajectoryTask | None,
    kind: str,
    rate: float,
    names: list[str],
    force: bool,
) -> str:
    """Return what a controller reads.

    Raises
    ------
    InputError
        Something speaks against sending the motion, and it is not forced.
    """
    from ocp_traj.controller_files import objections, sample_for_controller, to_ros2, to_urscript

    against = objections(motion, task, starts_at_rest=kind == "urscript")
    if against and not force:
        raise InputError(f"{'; '.join(against)}; nothing is written, expected --force to send it all the same")
    for objection in against:
        click.echo(f"forced: {objection}", err=True)
    if kind == "ros2":
        samples = sample_for_controller(motion, rate, None if against else task)
        if samples.scale > 1.0:
            click.echo(f"slowed by a factor of {samples.scale:.9g} so that limits are kept after sampling", err=True)
        if not against:
            click.echo("audited as written: every limit is kept between the samples", err=True)
        return to_ros2(samples, names)
    program, scale = to_urscript(motion, rate, joint_names=names)
    if scale > 1.0:
        click.echo(f"slowed by a factor of {scale:.9g} so that it ends on a control period", err=True)
    return program


def _joint_names(given: str | None, task: TrajectoryTask | None, n: int, path: Path) -> list[str]:
    """Return the names of the joints.

    Raises
    ------
    InputError
        There are none, or not as many different ones as joints.
    """
    if given is not None:
        names = [name.strip() for name in given.split(",")]
        if len(names) != n or len(set(names)) != n or not all(names):
            raise InputError(f"--joint-names {given!r} given, expected {n} different names")
        return names
    if task is None or task.robot is None:
        raise InputError(f"{path} has no robot that names its joints, expected --case or --joint-names")
    return list(task.robot.joint_names)
