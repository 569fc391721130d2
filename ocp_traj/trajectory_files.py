"""Trajectories as files: sampled CSV for people and controllers, the exact curve as JSON beside it."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.case import task_to_json
from ocp_traj.exceptions import InputError
from ocp_traj.files import read_regular, write_atomically
from ocp_traj.spline.hermite import hermite_pieces
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

SCHEMA = 1
MAX_ROWS = 1_000_000
"""Largest number of samples of a CSV file."""

MAX_NUMBERS = 10_000_000
"""Largest number of numbers of a CSV file that is read."""

MAX_DEGREE = 30
_MAX_BYTES = 2**29
_NEAR = 1e-9
COLUMN_AGREEMENT = 1e-6

Torques = Callable[[Array, Array, Array], Array]
"""(q, v, a), each (N, n), to torques (N, n), N m; for instance `Robot.torque`."""


def to_json(trajectory: Trajectory) -> dict[str, Any]:
    """Return the exact curve as plain numbers: ascending powers of (t - breakpoints[k]), rad (m) and s."""
    return {
        "schema": SCHEMA,
        "case": trajectory.case,
        "family": trajectory.family,
        "waypoint_times": trajectory.waypoint_times.tolist(),
        "breakpoints": trajectory.breakpoints.tolist(),
        "coefficients": trajectory.coefficients.tolist(),
    }


def from_json(data: Any, file: str = "trajectory") -> Trajectory:
    """Rebuild a trajectory from what `to_json` returned; keys that are not known are left alone.

    Parameters
    ----------
    data : dict
        As read from a file.
    file : str
        Name for the messages.

    Raises
    ------
    InputError
        A key is missing or holds something else than expected; names the file and the key.
    """
    if not isinstance(data, Mapping):
        raise InputError(
            f"{file}: holds a {type(data).__name__}, expected an object with the keys of a trajectory"
        )
    if data.get("schema") != SCHEMA:
        raise InputError(f"{file}: schema: {data.get('schema')!r} given, expected {SCHEMA}")
    arrays = {
        key: _array(data, key, dimensions, file)
        for key, dimensions in (("breakpoints", 1), ("coefficients", 3), ("waypoint_times", 1))
    }
    if arrays["coefficients"].shape[2] > MAX_DEGREE + 1:
        raise InputError(
            f"{file}: coefficients: degree {arrays['coefficients'].shape[2] - 1}, "
            f"expected at most {MAX_DEGREE}"
        )
    try:
        return Trajectory(**arrays, family=_text(data, "family", file), case=_text(data, "case", file))
    except InputError as error:
        raise InputError(f"{file}: {error}") from None


def _text(data: Mapping[str, Any], key: str, file: str) -> str:
    value = data.get(key, "")
    if not isinstance(value, str):
        raise InputError(f"{file}: {key}: {value!r} given, expected a text")
    return value


def _array(data: Mapping[str, Any], key: str, dimensions: int, file: str) -> Array:
    if key not in data:
        raise InputError(f"{file}: {key}: is missing")
    try:
        array = np.array(data[key])
    except (ValueError, OverflowError, RecursionError):
        raise InputError(
            f"{file}: {key}: rows differ in length, expected numbers in {dimensions} levels"
        ) from None
    if array.ndim != dimensions or array.dtype.kind not in "if" or array.size == 0:
        raise InputError(f"{file}: {key}: expected finite numbers in {dimensions} levels of lists")
    if not np.isfinite(array).all():
        raise InputError(f"{file}: {key}: holds a number that is not finite")
    return array.astype(np.float64)


def write_json(
    path: str | os.PathLike[str], trajectory: Trajectory, task: TrajectoryTask | None = None
) -> None:
    """Write the exact curve, and the task that travels with it."""
    data = to_json(trajectory)
    if task is not None:
        data["task"] = task_to_json(task)
    _write(Path(path), json.dumps(data, allow_nan=False) + "\n")


def read_json(path: str | os.PathLike[str]) -> Trajectory:
    """Read an exact curve, or the one inside a result (its key ``trajectory``).

    Raises
    ------
    InputError
        The file cannot be read or holds no trajectory; names the file and the key.
    """
    text = _read(Path(path))
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is no JSON: {error}") from None
    if isinstance(data, Mapping) and "trajectory" in data:
        if data["trajectory"] is None:
            raise InputError(f"{path}: trajectory: is null, this result holds no motion")
        data = data["trajectory"]
    return from_json(data, str(path))


def spline_path(path: str | os.PathLike[str]) -> Path:
    """Return where the exact curve beside a CSV file lies: same stem, ``.spline.json``."""
    return Path(path).with_suffix(".spline.json")


def sample_times(trajectory: Trajectory, rate: float) -> Array:
    """Return times from start to end every 1/rate seconds; first and last are exact.

    Raises
    ------
    InputError
        The rate is not positive or gives more than a million samples.
    """
    if not (math.isfinite(rate) and rate > 0):
        raise InputError(f"rate is {rate}, expected a positive number of samples a second")
    duration = trajectory.duration
    if duration * rate > MAX_ROWS:
        raise InputError(
            f"{duration:g} s at {rate:g} Hz need more than {MAX_ROWS} rows, expected a lower rate"
        )
    times = np.arange(math.ceil(duration * rate * (1 - _NEAR))) / rate
    return np.append(trajectory.breakpoints[0] + times, trajectory.breakpoints[-1])


def write_csv(
    path: str | os.PathLike[str],
    trajectory: Trajectory,
    rate: float = 1000.0,
    torques: Torques | None = None,
    task: TrajectoryTask | None = None,
) -> None:
    """Write samples ``t,q1..,v1..,a1..,j1..[,tau1..]`` in SI with 17 digits, and the exact curve beside them.

    Parameters
    ----------
    path : path
        The CSV file; the exact curve goes to the same stem with ``.spline.json``.
    trajectory : Trajectory
    rate : float
        Samples a second.
    torques : callable, optional
        (q, v, a), each (N, n), to torques (N, n), for instance `Robot.torque`.
    task : TrajectoryTask, optional
        The task that travels with the exact curve.

    Raises
    ------
    InputError
        The rate is wrong, or the file cannot be written.
    """
    times = sample_times(trajectory, rate)
    states = [trajectory(times, order) for order in range(4)]
    names = ["q", "v", "a", "j"]
    if torques is not None:
        states.append(torques(*states[:3]))
        names.append("tau")
    header = ",".join(["t"] + [f"{name}{joint + 1}" for name in names for joint in range(trajectory.n)])
    rows = np.column_stack([times, *states])
    lines = [header] + [",".join(format(value, ".17g") for value in row) for row in rows.tolist()]
    _write(Path(path), "\n".join(lines) + "\n")
    write_json(spline_path(path), trajectory, task)


def read_csv(path: str | os.PathLike[str]) -> Trajectory:
    """Read a motion: the exact curve beside the CSV if there is one, else the quintic through its q, v, a.

    The quintic's waypoint times are only its first and last; the audit finds the others.

    Parameters
    ----------
    path : path
        The CSV file, in rad (m) and s.

    Returns
    -------
    Trajectory

    Raises
    ------
    InputError
        The file cannot be read, a column is missing, a number is none, the times do not increase, or the
        exact curve beside it is another motion: its positions, velocities, accelerations or jerks differ.
    """
    columns = _read_columns(Path(path))
    times = columns["t"][:, 0]
    exact = spline_path(path)
    if not exact.exists():
        pieces = hermite_pieces(times, columns["q"], columns["v"], columns["a"])
        return Trajectory(times, pieces, times[[0, -1]], "samples")
    trajectory = read_json(exact)
    start, end = trajectory.breakpoints[[0, -1]]
    if trajectory.n != columns["q"].shape[1]:
        raise InputError(f"{exact}: has {trajectory.n} joints, but {path} has {columns['q'].shape[1]}")
    allowed = COLUMN_AGREEMENT * (end - start)
    span_differs = max(abs(times[0] - start), abs(times[-1] - end)) > allowed
    apart = np.abs(trajectory(times) - columns["q"]) > COLUMN_AGREEMENT * (1 + np.abs(columns["q"]))
    if span_differs or apart.any():
        raise InputError(f"{exact}: is another motion than {path}; remove the one that is out of date")
    _check_derivatives(trajectory, columns, Path(path), exact)
    return trajectory


def _check_derivatives(trajectory: Trajectory, columns: dict[str, Array], path: Path, exact: Path) -> None:
    """Hold the columns v, a and, where there is one, j against the exact curve.

    At a breakpoint the value of either piece will do.
    """
    times = columns["t"][:, 0]
    hair = _NEAR * trajectory.duration
    for order, key in enumerate("vaj", start=1):
        if key not in columns:
            continue
        given, expected = columns[key], trajectory(times, order)
        allowed = COLUMN_AGREEMENT * (1.0 + np.abs(expected).max(axis=0))
        apart = np.min([np.abs(given - trajectory(times + shift, order)) for shift in (-hair, 0.0, hair)], axis=0)
        wrong = np.argwhere(apart > allowed)
        if wrong.size:
            row, joint = wrong[0]
            raise InputError(
                f"{path}: row {row + 1}: {key}{joint + 1} is {given[row, joint]:.9g}, but {exact.name} has "
                f"{expected[row, joint]:.9g} there; remove the one that is out of date"
            )


def _read_columns(path: Path) -> dict[str, Array]:
    """Return the columns t, q, v, a, and j where there are all of them, of a CSV file, each (N, .)."""
    header, _, body = _read(path).partition("\n")
    names = [name.strip() for name in header.strip().lstrip("\ufeff").split(",")]
    n = sum(name[:1] == "q" and name[1:].isdigit() for name in names)
    if n == 0 or "t" not in names:
        raise InputError(f"{path}: header: {header.strip()[:80]!r} given, expected t,q1,...,v1,...,a1,...")
    wanted = {key: [f"{key}{joint + 1}" for joint in range(n)] for key in "qva"} | {"t": ["t"]}
    jerks = [f"j{joint + 1}" for joint in range(n)]
    if all(name in names for name in jerks):
        wanted["j"] = jerks
    missing = [name for group in wanted.values() for name in group if name not in names]
    if missing:
        raise InputError(f"{path}: header: column {missing[0]} is missing")
    if body.count("\n") > min(MAX_ROWS + 1, MAX_NUMBERS // len(names)):
        raise InputError(
            f"{path}: has more than {min(MAX_ROWS, MAX_NUMBERS // len(names))} rows of {len(names)} numbers, "
            "expected fewer: sample it more coarsely"
        )
    rows = [line.split(",") for line in body.splitlines() if line.strip()]
    if len(rows) < 2:
        raise InputError(f"{path}: {len(rows)} rows given, expected at least 2")
    for number, row in enumerate(rows):
        if len(row) != len(names):
            raise InputError(f"{path}: row {number + 1} has {len(row)} entries, expected {len(names)}")
    try:
        table = np.array(rows, dtype=np.float64)
    except ValueError as error:
        raise InputError(f"{path}: holds something else than numbers: {error}") from None
    if not np.isfinite(table).all():
        row, column = np.argwhere(~np.isfinite(table))[0]
        raise InputError(
            f"{path}: row {row + 1}: {names[column]} is {table[row, column]}, expected a finite number"
        )
    if not (np.diff(table[:, names.index("t")]) > 0).all():
        raise InputError(f"{path}: t: the times do not increase strictly")
    return {key: table[:, [names.index(name) for name in group]] for key, group in wanted.items()}


def _read(path: Path) -> str:
    if "\0" in str(path):
        raise InputError(f"{str(path)!r} is no path, it holds a null character")
    try:
        return read_regular(path, _MAX_BYTES).decode("utf-8")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: is no text") from None


def _write(path: Path, text: str) -> None:
    try:
        write_atomically(path, text)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
