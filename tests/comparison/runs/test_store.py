"""The store keeps rows across versions and tells when it cannot read a file."""

from __future__ import annotations

import csv
import sqlite3
from pathlib import Path

import pytest

from helpers import comparison_fakes as fakes
from ocp_traj.comparison.runs.plan import CaseChoice, Plan
from ocp_traj.comparison.runs.record import RunRecord
from ocp_traj.comparison.runs.store import FILE_NAME, MIGRATIONS, Store, missing
from ocp_traj.comparison.runs.table_files import export_table
from ocp_traj.exceptions import InputError

PLAN = Plan((CaseChoice("one"),), ("a", "b"), seeds=2)
SPECS = PLAN.runs(fakes.identify)
RECORD = RunRecord(
    "converged",
    "fine",
    claimed=True,
    feasible=True,
    objective=1.5,
    duration=1.5,
    worst={"limit": "velocity", "joint": 1, "time": 0.1, "ratio": 1.0},
    findings=("a finding",),
    evaluations=10,
    history={"evaluations": [1, 10], "cost": [2.0, 1.5], "violation": [0.0, 0.0], "seconds": [0.1, 0.2]},
    trajectory={"schema": 1, "case": "one"},
    details={"segments": [0.5, 1.0], "parts": []},
)


def filled(folder: Path) -> Store:
    store = Store(folder, create=True)
    number = store.add_plan(PLAN, {"python": "3"}, SPECS)
    store.add_case(SPECS[0])
    store.add_run(SPECS[0], RECORD, number)
    return store


def test_a_run_comes_back_as_it_was_stored(tmp_path: Path) -> None:
    with filled(tmp_path) as store:
        (row,) = store.rows()
        assert row.key == SPECS[0].key
        assert row.record == RunRecord(**{**RECORD.__dict__, "trajectory": None})
        assert store.trajectory(row) == RECORD.trajectory


def test_a_stored_run_is_never_overwritten(tmp_path: Path) -> None:
    with filled(tmp_path) as store:
        store.add_run(SPECS[0], RunRecord("failed"), 1)
        assert [row.record.status for row in store.rows()] == ["converged"]


def test_what_is_missing_keeps_the_order_of_the_plan(tmp_path: Path) -> None:
    with filled(tmp_path) as store:
        assert missing(store, SPECS) == list(SPECS[1:])


def test_plans_cases_and_references_come_back(tmp_path: Path) -> None:
    with filled(tmp_path) as store:
        store.add_reference(SPECS[0].case_digest, "toppra", {"uniform": float("nan")})
        store.add_reference(SPECS[0].case_digest, "kinematic_bound", {"lower": 1.0})
        assert store.plans() == [(PLAN, {"python": "3"})]
        case = store.cases()[SPECS[0].case_digest]
        assert case["choice"] == {"case": "one", "overrides": []}
        assert case["reference"] == {"toppra": {"uniform": None}, "kinematic_bound": {"lower": 1.0}}
        assert store.problems() == {(SPECS[0].case_digest, SPECS[0].settings_digest)}


def test_numbers_that_are_none_become_null() -> None:
    record = RunRecord("failed", objective=float("nan"), worst={"ratio": float("inf")})
    assert record.to_json()["objective"] is None
    assert record.to_json()["worst"] == {"ratio": None}


def test_a_file_of_version_1_is_migrated_and_keeps_its_rows(tmp_path: Path) -> None:
    (tmp_path / "trajectories").mkdir()
    connection = sqlite3.connect(tmp_path / FILE_NAME)
    connection.executescript(MIGRATIONS[0])
    connection.execute("PRAGMA user_version = 1")
    connection.execute("INSERT INTO plans VALUES (1, 'then', '{}', '{}')")
    connection.execute(
        "INSERT INTO runs (case_digest, solver, settings_digest, seed, case_name, seed_index, status, reason, message,"
        " claimed, feasible, objective, findings, plan, finished)"
        " VALUES ('c', 's', 'd', 1, 'one', 0, 'converged', '', '', 1, 1, 2.5, '[]', 1, 'then')"
    )
    connection.commit()
    connection.close()
    with Store(tmp_path) as store:
        assert store.version == len(MIGRATIONS)
        (row,) = store.rows()
        assert (row.key, row.record.objective, row.record.history) == (("c", "s", "d", 1), 2.5, {})


def test_a_history_of_version_2_has_no_details(tmp_path: Path) -> None:
    (tmp_path / "trajectories").mkdir()
    connection = sqlite3.connect(tmp_path / FILE_NAME)
    connection.executescript("".join(MIGRATIONS[:2]))
    connection.execute("PRAGMA user_version = 2")
    connection.execute("INSERT INTO histories VALUES ('c', 's', 'd', 1, '[1]', '[2.5]', '[0]', '[0.1]')")
    connection.execute(
        "INSERT INTO runs (case_digest, solver, settings_digest, seed, case_name, seed_index, status, reason, message,"
        " claimed, feasible, objective, findings, plan, finished)"
        " VALUES ('c', 's', 'd', 1, 'one', 0, 'converged', '', '', 1, 1, 2.5, '[]', 1, 'then')"
    )
    connection.commit()
    connection.close()
    with Store(tmp_path) as store:
        (row,) = store.rows()
        assert (row.record.history["cost"], row.record.details) == ([2.5], {})


def test_a_file_that_another_process_has_just_made_is_not_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    filled(tmp_path).close()
    version, seen = Store.version.fget, iter([0])  # what was read before the other process was ready
    assert version is not None
    monkeypatch.setattr(Store, "version", property(lambda store: next(seen, version(store))))
    with Store(tmp_path) as store:
        assert len(store.rows()) == 1


def test_a_named_result_is_kept_by_case_and_the_newest_counts(tmp_path: Path) -> None:
    with filled(tmp_path) as store:
        store.add_result("case", "bound", {"lower": 1.0, "upper": float("inf")})
        store.add_result("case", "bound", {"lower": 2.0, "upper": float("nan")})
        store.add_result("other", "bound", {})
    with Store(tmp_path) as store:
        assert store.results("case") == {"bound": {"lower": 2.0, "upper": None}}
        assert store.results("neither") == {}


def test_details_that_are_no_table_are_refused(tmp_path: Path) -> None:
    with filled(tmp_path) as store:
        store._connection.execute("UPDATE histories SET details = '[1]'")
        with pytest.raises(InputError, match="a list stands where an object was written"):
            store.rows()


def test_a_file_of_a_newer_version_is_refused(tmp_path: Path) -> None:
    filled(tmp_path).close()
    connection = sqlite3.connect(tmp_path / FILE_NAME)
    connection.execute("PRAGMA user_version = 99")
    connection.close()
    with pytest.raises(InputError, match="has schema version 99"):
        Store(tmp_path)


def test_a_file_that_is_no_database_is_refused(tmp_path: Path) -> None:
    (tmp_path / FILE_NAME).write_text("this is no database, and it is long enough to be one" * 40)
    with pytest.raises(InputError, match="is not a readable comparison"):
        Store(tmp_path)


def test_a_folder_without_comparison_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"holds no comparison: results.sqlite is not there"):
        Store(tmp_path)


def test_a_failed_transaction_leaves_nothing_behind(tmp_path: Path) -> None:
    with filled(tmp_path) as store:
        with pytest.raises(sqlite3.IntegrityError):
            store.add_run(SPECS[1], RunRecord(None), 1)  # type: ignore[arg-type]
        assert len(store.finished()) == 1


def test_runs_are_exported_as_csv(tmp_path: Path) -> None:
    with filled(tmp_path) as store:
        export_table(store, tmp_path / "runs.csv", "csv")
    with (tmp_path / "runs.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert (row["solver"], float(row["objective"]), row["worst_limit"]) == ("a", 1.5, "velocity")


def test_runs_are_exported_as_parquet(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    import pandas

    with filled(tmp_path) as store:
        export_table(store, tmp_path / "runs.parquet", "parquet")
    frame = pandas.read_parquet(tmp_path / "runs.parquet")
    assert frame["objective"].tolist() == [1.5]
