"""A motion in a file, and the task that belongs to it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from ocp_traj.exceptions import InputError

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory


def read_motion(path: Path) -> Trajectory:
    """Return the motion in a CSV, an exact curve or a result."""
    from ocp_traj.trajectory_files import read_csv, read_json

    return read_csv(path) if path.suffix == ".csv" else read_json(path)


def task_of(
    motion: Trajectory, path: Path, case: str | None, overrides: tuple[str, ...]
) -> TrajectoryTask | None:
    """Return the case a motion belongs to: the one given, the one its file carries, or the packaged one it names.

    What is overridden is in the units of the case; a carried task is in rad and m, unless it is a packaged case.

    Raises
    ------
    InputError
        The case does not fit the motion, or something is to be overridden where there is none.
    """
    from ocp_traj.case import case_names, load_case, task_digest

    if case is not None:
        task: TrajectoryTask | None = load_case(case, overrides)
    else:
        name = _case_named_in(path, motion)
        task = _carried(path, ())
        if name in case_names() and (task is None or task_digest(task) == task_digest(load_case(name))):
            task = load_case(name, overrides)
        elif task is not None and overrides:
            task = _carried(path, overrides)
    if task is None and overrides:
        raise InputError(f"{path} carries no task whose keys could be set, expected --case")
    if task is not None and task.n != motion.n:
        raise InputError(f"the motion has {motion.n} joints, but case {task.name} has {task.n}")
    return task


def _carried(path: Path, overrides: tuple[str, ...]) -> TrajectoryTask | None:
    from ocp_traj.case import carried_task
    from ocp_traj.trajectory_files import spline_path

    source = spline_path(path) if path.suffix == ".csv" else path
    return carried_task(source, overrides=overrides) if source.exists() else None


def _case_named_in(path: Path, motion: Trajectory) -> str:
    if motion.case or path.suffix != ".json":
        return motion.case
    name = json.loads(path.read_text(encoding="utf-8")).get("case")
    return name if isinstance(name, str) else ""
