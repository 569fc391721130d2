"""``ocp-traj plot``: pictures of a motion or a comparison, for publications."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ocp_traj.cli.completion import CaseName
from ocp_traj.cli.motions import read_motion, task_of
from ocp_traj.cli.output import check_writable, overrides_option
from ocp_traj.exceptions import InputError

if TYPE_CHECKING:
    from ocp_traj.pictures.picture import Picture
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

MOTION_NAMES = ("motion", "limits", "path", "power", "phase-plane")
COMPARISON_NAMES = ("convergence", "bounds", "runtime", "performance", "data")


@click.command(name="plot")
@click.argument("file")
@click.option(
    "--picture",
    type=click.Choice([*MOTION_NAMES, *COMPARISON_NAMES]),
    help="What to draw; default motion, or runtime for a comparison.",
)
@click.option(
    "--case",
    type=CaseName(),
    help="Case whose limits and robot belong to the motion; default: the one FILE carries or names."
)
@overrides_option
@click.option("--output", metavar="FILE.png", help="PNG, PDF or SVG; default: beside FILE.")
def plot_file(
    file: str, picture: str | None, case: str | None, overrides: tuple[str, ...], output: str | None
) -> None:
    """Draw a trajectory (.csv, .spline.json), a result (.json) or a comparison (its folder).

    motion: q, v, a, jerk and torque against their limits; limits: the same as shares; path: the tool; power;
    phase-plane: how fast its path can be driven. convergence, bounds, runtime, performance, data: of a comparison;
    the first two show one problem, choose it with --case.
    """
    from ocp_traj.pictures.matplotlib_ import save_picture

    check_writable(output)
    path = Path(file)
    if path.is_dir():
        name = picture or "runtime"
        drawn = _comparison_picture(path, name, case)
        target = path / f"{name}.png"
    else:
        name = picture or "motion"
        drawn = _motion_picture(path, name, case, overrides)
        target = path.with_name(f"{path.name.split('.')[0]}-{name}.png")
    save_picture(drawn, Path(output) if output else target)
    click.echo(str(output or target))


def _comparison_picture(folder: Path, name: str, case: str | None) -> Picture:
    from ocp_traj.comparison.report.comparison_pictures import (
        COMPARISON_PICTURES,
        convergence_picture,
        problem_entries,
    )
    from ocp_traj.comparison.report.judging import judge
    from ocp_traj.comparison.runs.store import Store
    from ocp_traj.pictures.bounds import bounds_picture

    if name in MOTION_NAMES:
        raise InputError(
            f"{folder} is a comparison, expected one of the pictures {', '.join(COMPARISON_NAMES)}"
        )
    with Store(folder) as store:
        wanted = store.problems()
        rows = [row for row in store.rows() if (row.case_digest, row.settings_digest) in wanted]
        judgement = judge(rows, store.cases())
    if not judgement.problems:
        raise InputError(f"{folder} holds no runs yet")
    if name not in ("convergence", "bounds"):
        return COMPARISON_PICTURES[name](judgement)
    named = [problem for problem in judgement.problems if case in (None, problem.name, problem.label)]
    if not named:
        names = ", ".join(problem.label for problem in judgement.problems)
        raise InputError(f"case {case!r} is not in this comparison, expected one of {names}")
    if name == "bounds":
        return bounds_picture(problem_entries(judgement, named[0]), named[0].label)
    return convergence_picture(judgement, named[0])


def _motion_picture(path: Path, name: str, case: str | None, overrides: tuple[str, ...]) -> Picture:
    from ocp_traj.pictures.motion import MOTION_PICTURES

    if name not in MOTION_NAMES:
        raise InputError(f"{path} is a motion, expected one of the pictures {', '.join(MOTION_NAMES)}")
    motion = read_motion(path)
    task = task_of(motion, path, case, overrides) or _unlimited(motion)
    if name == "phase-plane":
        from ocp_traj.pictures.phase_plane import phase_plane_picture

        return phase_plane_picture(task, [motion])
    return MOTION_PICTURES[name](task, motion)


def _unlimited(motion: Trajectory) -> TrajectoryTask:
    from ocp_traj.task import TrajectoryTask

    return TrajectoryTask(motion(motion.waypoint_times), virtual_knots=3, name=motion.case or "motion")
