"""Cases by packaged name or by path."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ocp_traj.case.reading import task_from_tables
from ocp_traj.case.toml_files import apply_override, parse_toml, read_text
from ocp_traj.case.travelling import carried_tables, carried_task
from ocp_traj.exceptions import CaseError, did_you_mean
from ocp_traj.task import TrajectoryTask

_PACKAGED = Path(__file__).parent.parent / "cases"


def case_names() -> list[str]:
    """Return the names of the packaged cases."""
    return sorted(path.stem for path in _PACKAGED.glob("*.toml"))


def case_title(name: str) -> str:
    """Return the title of a packaged case.

    Parameters
    ----------
    name : str
        One of `case_names`.

    Raises
    ------
    CaseError
        There is no such case.
    """
    return _tables(name).get("title", "")


def load_case(name_or_path: str | Path, overrides: Sequence[str] = ()) -> TrajectoryTask:
    """Return the task that a case file states, or that a result carries.

    Parameters
    ----------
    name_or_path : str or pathlib.Path
        Name of a packaged case, path of a case file, or path of a result or an exact curve (``.json``).
    overrides : sequence of str
        ``"key=value"`` with a dotted key of the case and a TOML value, for instance
        ``"spline.virtual_knots=3"``; a bare word is taken as text.

    Raises
    ------
    CaseError
        There is no such case, or something in it cannot be used; names the file, the key, what was given and
        what was expected.

    Examples
    --------
    >>> task = load_case("machines-2024-490", ["spline.family=cubic", "spline.virtual_knots=3"])
    >>> task.waypoints.shape, task.family.name, task.virtual_knots
    ((4, 6), 'cubic', 3)
    """
    file = str(name_or_path)
    if Path(name_or_path).suffix == ".json":
        task = carried_task(Path(name_or_path), file, overrides)
        if task is None:
            raise CaseError(file, "", "carries no task, expected a case file or a result that carries its task")
        return task
    tables = _tables(name_or_path)
    trusted = [apply_override(tables, override, file) for override in overrides]
    return task_from_tables(tables, file, _path_of(name_or_path).parent, trusted)


def limits_named(name_or_path: str | Path, overrides: Sequence[str] = ()) -> set[str]:
    """Return the names of the limits that a case file gives for all of its gaps.

    Parameters
    ----------
    name_or_path, overrides
        As `load_case`.

    Raises
    ------
    CaseError
        There is no such case, or it is no TOML.
    """
    file = str(name_or_path)
    if Path(name_or_path).suffix == ".json":  # a result carries the limits of its task, those of the robot included
        return set((carried_tables(Path(name_or_path), file) or {}).get("limits", {}))
    tables = _tables(name_or_path)
    for override in overrides:
        apply_override(tables, override, file)
    return set(tables.get("limits", {}))


def load_case_text(text: str, overrides: Sequence[str] = (), folder: Path | None = None) -> TrajectoryTask:
    """Return the task of a case given as text; paths in it are relative to `folder` (default: here).

    Parameters
    ----------
    text : str
        TOML, as in a case file.
    overrides : sequence of str
        ``KEY=VALUE``, as in `load_case`.
    folder : Path, optional

    Raises
    ------
    CaseError
        As `load_case`; the file is called ``<text>``.
    """
    tables = parse_toml(text, "<text>")
    trusted = [apply_override(tables, override, "<text>") for override in overrides]
    return task_from_tables(tables, "<text>", folder or Path.cwd(), trusted)


def _path_of(name_or_path: str | Path) -> Path:
    if isinstance(name_or_path, str) and name_or_path in case_names():
        return _PACKAGED / f"{name_or_path}.toml"
    return Path(name_or_path)


def _tables(name_or_path: str | Path) -> dict[str, Any]:
    file, path = str(name_or_path), _path_of(name_or_path)
    try:
        text = read_text(path, file)
    except CaseError as error:
        if error.problem != "does not exist":
            raise
        names = case_names()
        hint = did_you_mean(path.stem, names)
        raise CaseError(
            file, "", f"does not exist; expected a path or a packaged case, one of {', '.join(names)}{hint}"
        ) from None
    return parse_toml(text, file)
