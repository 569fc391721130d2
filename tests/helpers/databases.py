"""Databases of comparisons, reached past the store."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest

from ocp_traj.comparison.runs.store import FILE_NAME


def change(folder: Path, statement: str, *values: Any) -> None:
    """Execute one statement on the database of a folder."""
    with closing(sqlite3.connect(folder / FILE_NAME)) as connection, connection:
        connection.execute(statement, values)


def page_count(folder: Path) -> int:
    """Return the number of pages of the database of a folder."""
    with closing(sqlite3.connect(folder / FILE_NAME)) as connection:
        (pages,) = connection.execute("PRAGMA page_count").fetchone()
    return int(pages)


@contextmanager
def connections_with(pragma: str) -> Iterator[None]:
    """Let every connection that is opened inside begin with a statement."""
    connect = sqlite3.connect

    def prepared(*arguments: Any, **settings: Any) -> sqlite3.Connection:
        connection = connect(*arguments, **settings)
        connection.execute(pragma)
        return connection

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sqlite3, "connect", prepared)
        yield
