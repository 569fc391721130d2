"""The comparison's memory: one SQLite file, one row a run, written by one process."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from ocp_traj.comparison.runs.curve_files import read_curve, write_curve
from ocp_traj.comparison.runs.plan import Plan, RunSpec
from ocp_traj.comparison.runs.record import RunRecord
from ocp_traj.comparison.runs.stored_values import (
    COLUMNS,
    check_columns,
    load_choice,
    load_history,
    load_object,
    load_reference,
    load_texts,
)
from ocp_traj.exceptions import InputError
from ocp_traj.files import finite

FILE_NAME = "results.sqlite"

READER_SECONDS, WRITER_SECONDS = 5.0, 30.0
"""How long a reader and a writer wait for another process."""

_VERSION_1 = f"""
CREATE TABLE plans (
    id INTEGER PRIMARY KEY, created TEXT NOT NULL, plan TEXT NOT NULL, environment TEXT NOT NULL
);
CREATE TABLE cases (digest TEXT PRIMARY KEY, name TEXT NOT NULL, choice TEXT NOT NULL, reference TEXT);
CREATE TABLE runs (
    {", ".join(f"{name} {kind}" for name, kind in COLUMNS.items())},
    PRIMARY KEY (case_digest, solver, settings_digest, seed)
) WITHOUT ROWID;
"""

_VERSION_2 = """
CREATE TABLE histories (
    case_digest TEXT NOT NULL, solver TEXT NOT NULL, settings_digest TEXT NOT NULL, seed INTEGER NOT NULL,
    evaluations TEXT NOT NULL, cost TEXT NOT NULL, violation TEXT NOT NULL, seconds TEXT NOT NULL,
    PRIMARY KEY (case_digest, solver, settings_digest, seed)
) WITHOUT ROWID;
CREATE TABLE problems (
    plan INTEGER NOT NULL REFERENCES plans (id), case_digest TEXT NOT NULL, settings_digest TEXT NOT NULL,
    PRIMARY KEY (plan, case_digest, settings_digest)
) WITHOUT ROWID;
"""

_VERSION_3 = """
ALTER TABLE histories ADD COLUMN details TEXT NOT NULL DEFAULT '{}';
CREATE TABLE results (
    case_digest TEXT NOT NULL, name TEXT NOT NULL, value TEXT NOT NULL, PRIMARY KEY (case_digest, name)
) WITHOUT ROWID;
"""

MIGRATIONS = (_VERSION_1, _VERSION_2, _VERSION_3)
"""Step k brings a file from schema version k to k + 1; a new version is a new step, old ones never change."""

_KEY = ("case_digest", "solver", "settings_digest", "seed")
_KEEP_FIRST = f"ON CONFLICT ({', '.join(_KEY)}) DO NOTHING"
_HISTORY = ("evaluations", "cost", "violation", "seconds")
_WORST = ("limit", "joint", "time", "ratio")


@dataclass(frozen=True)
class StoredRun:
    """One stored run: where it came from, what came out, and the file of its trajectory."""

    case_digest: str
    case_name: str
    solver: str
    settings_digest: str
    seed: int
    seed_index: int
    budget: int | None
    time_limit: float | None
    record: RunRecord
    trajectory_file: str | None
    plan: int

    @property
    def key(self) -> tuple[str, str, str, int]:
        """As `RunSpec.key`."""
        return (self.case_digest, self.solver, self.settings_digest, self.seed)


class Store:
    """The folder of a comparison.

    Parameters
    ----------
    folder
        Created when `create` is set; else it must hold a comparison.

    Raises
    ------
    InputError
        There is no comparison, it is damaged, or it was written by a newer version of the library. Every
        method raises it, too, where the file turns out to be damaged or cannot be written.
    """

    def __init__(self, folder: Path, create: bool = False) -> None:
        self.folder = folder
        path = folder / FILE_NAME
        if create:
            try:
                (folder / "trajectories").mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise InputError(f"cannot write into {folder}: {error.strerror}") from None
        elif not path.is_file():
            raise InputError(f"{folder} holds no comparison: {FILE_NAME} is not there")
        elif path.stat().st_size == 0:
            raise InputError(f"{folder} holds no comparison: {FILE_NAME} is empty")
        try:
            seconds = WRITER_SECONDS if create else READER_SECONDS
            self._connection = sqlite3.connect(path, timeout=seconds, isolation_level=None)
        except sqlite3.DatabaseError as error:
            raise InputError(f"{path} cannot be opened: {error}") from None
        self._connection.row_factory = sqlite3.Row
        try:
            with self._reading():
                self._check_tables()
                self._migrate()
                (found,) = self._connection.execute("PRAGMA quick_check(1)").fetchone()
                if found != "ok":
                    raise sqlite3.DatabaseError(found)
        except InputError:
            self._connection.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def version(self) -> int:
        """Schema version of the file."""
        return int(self._connection.execute("PRAGMA user_version").fetchone()[0])

    def _check_tables(self) -> None:
        """Refuse views and triggers: nothing here writes them, and a query of one may never end."""
        query = "SELECT type, name FROM sqlite_master WHERE type NOT IN ('table', 'index') LIMIT 1"
        for kind, name in self._connection.execute(query):
            raise sqlite3.DatabaseError(f"it has the {kind} {name!r}, expected tables only")

    def _migrate(self) -> None:
        found = self.version
        if not 0 <= found <= len(MIGRATIONS):
            raise InputError(
                f"{self.folder / FILE_NAME} has schema version {found}, this version of ocp-traj reads up to "
                f"{len(MIGRATIONS)}"
            )
        if found == len(MIGRATIONS):
            return
        with self._transaction():
            # Read again: another process may have made or migrated the file since.
            for version in range(self.version, len(MIGRATIONS)):
                for statement in MIGRATIONS[version].split(";"):
                    self._connection.execute(statement)
                self._connection.execute(f"PRAGMA user_version = {version + 1}")

    @contextmanager
    def _reading(self) -> Iterator[None]:
        """Say in one sentence that the file is damaged, instead of what its content made Python raise."""
        try:
            yield
        except (sqlite3.DatabaseError, ValueError, TypeError, LookupError, RecursionError) as error:
            if isinstance(error, InputError) and FILE_NAME in str(error):
                raise
            if isinstance(error, sqlite3.OperationalError) and "locked" in str(error):
                raise InputError(
                    f"{self.folder / FILE_NAME} is locked by another process, expected to read it once that has ended"
                ) from error
            raise InputError(
                f"{self.folder / FILE_NAME} is not a readable comparison: {error}; "
                "restore it, or start again in another folder"
            ) from error

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        try:
            self._connection.execute("BEGIN IMMEDIATE")
            try:
                yield
                self._connection.execute("COMMIT")
            except BaseException:
                if self._connection.in_transaction:  # SQLite itself undoes it on a full disk
                    self._connection.execute("ROLLBACK")
                raise
        except (sqlite3.IntegrityError, sqlite3.ProgrammingError):
            raise
        except sqlite3.DatabaseError as error:
            raise InputError(f"cannot write into {self.folder / FILE_NAME}: {error}") from error

    def add_plan(self, plan: Plan, environment: dict[str, Any], specs: Sequence[RunSpec]) -> int:
        """Store a plan, its problems (case and settings) and on what it runs; return its number."""
        with self._transaction():
            cursor = self._connection.execute(
                "INSERT INTO plans (created, plan, environment) VALUES (?, ?, ?)",
                (_now(), json.dumps(plan.to_json()), json.dumps(environment)),
            )
            number = cursor.lastrowid
            problems = {(number, spec.case_digest, spec.settings_digest) for spec in specs}
            self._connection.executemany("INSERT INTO problems VALUES (?, ?, ?)", sorted(problems))
        assert number is not None
        return number

    def problems(self) -> set[tuple[str, str]]:
        """Return (case digest, settings digest) of the newest plan's problems: what a report is about."""
        newest = "SELECT max(id) FROM plans"
        query = f"SELECT case_digest, settings_digest FROM problems WHERE plan = ({newest})"
        with self._reading():
            return {tuple(row) for row in self._connection.execute(query)}

    def plans(self) -> list[tuple[Plan, dict[str, Any]]]:
        """Return all plans with their environments, oldest first."""
        with self._reading():
            rows = self._connection.execute("SELECT plan, environment FROM plans ORDER BY id")
            return [
                (Plan.from_json(load_object(plan)), load_object(environment)) for plan, environment in rows
            ]

    def add_case(self, spec: RunSpec) -> None:
        """Note a case of the plan; a case that is there already keeps its reference."""
        choice = json.dumps({"case": spec.case, "overrides": spec.overrides})
        with self._transaction():
            self._connection.execute(
                "INSERT INTO cases (digest, name, choice) VALUES (?, ?, ?) ON CONFLICT (digest) DO NOTHING",
                (spec.case_digest, spec.case_name, choice),
            )

    def add_reference(self, digest: str, part: str, found: dict[str, Any]) -> None:
        """Store a part of a case's references (``toppra``, ``kinematic_bound``), or why there is none."""
        with self._transaction():
            (known,) = self._connection.execute(
                "SELECT reference FROM cases WHERE digest = ?", (digest,)
            ).fetchone()
            with self._reading():
                reference = {**(load_reference(known) or {}), part: finite(found)}
            self._connection.execute(
                "UPDATE cases SET reference = ? WHERE digest = ?", (json.dumps(reference), digest)
            )

    def add_result(self, digest: str, name: str, value: dict[str, Any]) -> None:
        """Store a named result on a case that is neither a run nor a reference; the newest of a name counts."""
        with self._transaction():
            self._connection.execute(
                "INSERT OR REPLACE INTO results VALUES (?, ?, ?)", (digest, name, json.dumps(finite(value)))
            )

    def results(self, digest: str) -> dict[str, dict[str, Any]]:
        """Return the named results on a case."""
        with self._reading():
            rows = self._connection.execute("SELECT name, value FROM results WHERE case_digest = ?", (digest,))
            return {name: load_object(value) for name, value in rows}

    def cases(self) -> dict[str, dict[str, Any]]:
        """Return name, choice and reference (or None) of every case, by digest."""
        with self._reading():
            rows = self._connection.execute("SELECT digest, name, choice, reference FROM cases")
            return {
                digest: {
                    "name": name,
                    "choice": load_choice(choice),
                    "reference": load_reference(reference),
                }
                for digest, name, choice, reference in rows
            }

    def finished(self) -> set[tuple[str, str, str, int]]:
        """Return the keys of all stored runs."""
        with self._reading():
            return {tuple(row) for row in self._connection.execute(f"SELECT {', '.join(_KEY)} FROM runs")}

    def add_run(self, spec: RunSpec, record: RunRecord, plan: int) -> None:
        """Store a finished run in one transaction: its trajectory file first, then row and history."""
        name = None
        if record.trajectory is not None:
            name = write_curve(self.folder / "trajectories", spec, record.trajectory)
        values = _columns(spec, record, name, plan)
        holes = ", ".join("?" * len(values))
        history = [json.dumps(record.history.get(part, [])) for part in _HISTORY]
        with self._transaction():
            self._connection.execute(
                f"INSERT INTO runs ({', '.join(values)}) VALUES ({holes}) {_KEEP_FIRST}",
                tuple(values.values()),
            )
            self._connection.execute(
                f"INSERT INTO histories VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?) {_KEEP_FIRST}",
                (*spec.key, *history, json.dumps(finite(record.details))),
            )

    def rows(self, histories: bool = True) -> list[StoredRun]:
        """Return every run, ordered by case, solver, settings and seed."""
        parts = "".join(f", h.{part} AS h_{part}" for part in _HISTORY)
        query = (
            f"SELECT r.*{parts}, h.details FROM runs r LEFT JOIN histories h USING ({', '.join(_KEY)})"
            if histories
            else "SELECT * FROM runs r"
        )
        with self._reading():
            found = self._connection.execute(
                f"{query} ORDER BY case_name, case_digest, solver, settings_digest, seed_index"
            )
            return [_row(entry, histories) for entry in found]

    def trajectory(self, row: StoredRun) -> dict[str, Any] | None:
        """Return the exact curve of a run, or None when it has none.

        Raises
        ------
        InputError
            The file is not there, is damaged, or does not lie in the folder of trajectories.
        """
        if row.trajectory_file is None:
            return None
        return read_curve(self.folder / "trajectories", row.trajectory_file)

    def table(self) -> tuple[list[str], list[tuple[Any, ...]]]:
        """Return the columns and values of all runs, for export."""
        with self._reading():
            cursor = self._connection.execute(
                "SELECT * FROM runs ORDER BY case_name, solver, settings_digest, seed_index"
            )
            return [entry[0] for entry in cursor.description], [tuple(row) for row in cursor]


def _columns(spec: RunSpec, record: RunRecord, trajectory: str | None, plan: int) -> dict[str, Any]:
    worst = record.worst or {}
    values = {
        **vars(spec),
        **vars(record),
        **{f"worst_{part}": worst.get(part) for part in _WORST},
        "settings_digest": spec.settings_digest,
        "findings": json.dumps(record.findings),
        "trajectory": trajectory,
        "plan": plan,
        "finished": _now(),
    }
    return {name: values[name] for name in COLUMNS}


def _row(entry: sqlite3.Row, histories: bool) -> StoredRun:
    check_columns(entry)
    values = {
        **_columns_of(RunRecord, entry),
        "claimed": bool(entry["claimed"]),
        "feasible": bool(entry["feasible"]),
        "findings": load_texts(entry["findings"]),
        "trajectory": None,  # in a file of its own
    }
    if entry["worst_limit"] is not None:
        values["worst"] = {part: entry[f"worst_{part}"] for part in _WORST}
    if histories and entry["h_cost"] is not None:
        values["history"] = load_history({part: entry[f"h_{part}"] for part in _HISTORY})
        values["details"] = load_object(entry["details"])
    record = RunRecord(**values)
    return StoredRun(**_columns_of(StoredRun, entry), record=record, trajectory_file=entry["trajectory"])


def _columns_of(kind: type[RunRecord | StoredRun], entry: sqlite3.Row) -> dict[str, Any]:
    """Return the fields of a class that are columns of a run."""
    return {field.name: entry[field.name] for field in fields(kind) if field.name in COLUMNS}


def _now() -> str:
    return datetime.now(timezone.utc).isoformat(timespec="seconds")


def missing(store: Store, specs: Iterable[RunSpec]) -> list[RunSpec]:
    """Return the runs that are not stored yet, in the plan's order."""
    done = store.finished()
    return [spec for spec in specs if spec.key not in done]
