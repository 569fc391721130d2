"""What several commands share: tables for people, JSON for programs, common options."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from ocp_traj.cli.completion import Override
from ocp_traj.exceptions import InputError

if TYPE_CHECKING:
    from rich.console import Console

Command = TypeVar("Command", bound=Callable[..., Any])

FEASIBLE, INFEASIBLE = 0, 1
_FILE_WIDTH = 120


def overrides_option(command: Command) -> Command:
    """Add ``--set KEY=VALUE``."""
    return click.option(
        "--set",
        "overrides",
        type=Override(),
        multiple=True,
        metavar="KEY=VALUE",
        help="Override a key of the case; read as TOML.",
    )(command)


def json_option(command: Command) -> Command:
    """Add ``--json FILE|-``."""
    return click.option(
        "--json", "json_file", metavar="FILE|-", help="Write the result as JSON; - is standard output."
    )(command)


def console_for(json_file: str | None) -> Console:
    """Return where words for people go: standard error when JSON goes to standard output."""
    from rich.console import Console

    console = Console(stderr=json_file == "-", highlight=False, soft_wrap=True)
    if not console.is_terminal:
        console.width = _FILE_WIDTH
    return console


def write_json(value: Any, json_file: str | None) -> None:
    """Write JSON to a file or to standard output; nothing without a file.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    if json_file is None:
        return
    content = json.dumps(value, indent=2, allow_nan=False)
    if json_file == "-":
        click.echo(content)
    else:
        write_text(Path(json_file), content + "\n")


def check_writable(*paths: str | Path | None) -> None:
    """Refuse files that could not be written, before any work is done; None and ``-`` are no files.

    Raises
    ------
    InputError
        There is no such folder, the file is a folder, or it may not be written.
    """
    for given in paths:
        if given is None or str(given) == "-":
            continue
        path = Path(given)
        try:
            if path.is_dir():
                raise InputError(f"cannot write {path}: it is a folder")
            if not path.parent.is_dir():
                raise InputError(f"cannot write {path}: there is no folder {path.parent}")
            if not os.access(path if path.exists() else path.parent, os.W_OK):
                raise InputError(f"cannot write {path}: permission denied")
        except (OSError, ValueError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"cannot write {str(path)[:80]!r}: {error}") from None


def write_text(path: Path, content: str) -> None:
    """Write a text file.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    try:
        path.write_text(content, encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}") from None


def print_table(
    console: Console, title: str, columns: Sequence[str], rows: Sequence[Sequence[str]], words: int = 1
) -> None:
    """Print a table; the first `words` columns are aligned left, the others right."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(title=title or None, box=box.SIMPLE, title_justify="left", pad_edge=False)
    for place, column in enumerate(columns):
        table.add_column(column, justify="left" if place < words else "right", overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    console.print(table)


def seconds(value: float | None) -> str:
    """Return a duration for people."""
    return "–" if value is None else f"{value:.4f} s"
