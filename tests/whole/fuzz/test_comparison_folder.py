"""A folder of results that is damaged, hostile or full: one sentence or a report, and never a lost row."""

from __future__ import annotations

import json
import random
import sqlite3
from pathlib import Path
from typing import Any

import pytest

from helpers import comparison_fakes as fakes
from helpers.databases import change, connections_with, page_count
from ocp_traj.case import load_case, task_digest
from ocp_traj.cli.main import run
from ocp_traj.comparison.report.report import write_report
from ocp_traj.comparison.runs.plan import CaseChoice, Plan
from ocp_traj.comparison.runs.record import RunRecord
from ocp_traj.comparison.runs.store import FILE_NAME, Store
from ocp_traj.exceptions import InputError

CASE = "fang-2020-task-1"
HISTORY = {"evaluations": [1, 9], "cost": [9.0, 4.0], "violation": [0.0, 0.0], "seconds": [0.1, 0.2]}
STRAIGHT = {"schema": 1, "waypoint_times": [0.0, 1.0], "breakpoints": [0.0, 1.0]}


def curve(joints: int) -> dict[str, Any]:
    return {**STRAIGHT, "coefficients": [[[0.0, 1.0]] * joints]}


def record(seed: int, solver: str, trajectory: dict[str, Any] | None) -> RunRecord:
    cost = 4.0 + 0.1 * seed + len(solver)
    return RunRecord(
        "converged",
        claimed=True,
        feasible=True,
        objective=cost,
        duration=cost,
        findings=("a finding",),
        worst={"limit": "velocity", "joint": 1, "time": 0.5, "ratio": 1.0},
        evaluations=9,
        build_time=0.1,
        solve_time=0.2,
        wall_time=0.3,
        history=HISTORY,
        trajectory=trajectory,
    )


def fill(folder: Path, trajectory: dict[str, Any] | None = None) -> Path:
    """Store two seeds of two solvers on two cases, one of them packaged."""
    packaged = task_digest(load_case(CASE))
    plan = Plan((CaseChoice(CASE), CaseChoice("gone")), ("a", "bb"), seeds=2)
    specs = plan.runs(
        lambda choice: (choice.case, packaged) if choice.case == CASE else fakes.identify(choice)
    )
    with Store(folder, create=True) as store:
        environment = {
            "python": "3",
            "versions": {},
            "machine": {"system": "S", "processor": "P", "cores": 2, "memory_gb": 1.0},
            "git": None,
        }
        number = store.add_plan(plan, environment, specs)
        for spec in specs:
            store.add_case(spec)
            store.add_run(spec, record(spec.seed_index, spec.solver, trajectory), number)
        store.add_reference(packaged, "toppra", {"uniform": 4.5, "chord": 4.2})
    return folder


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return (fill(tmp_path_factory.mktemp("sound")) / FILE_NAME).read_bytes()


def damaged(content: bytes, rng: random.Random) -> bytes:
    """Flip, cut, blank or rewrite some of a file."""
    found = bytearray(content)
    kind = rng.choice(["flip", "flip", "cut", "blank", "text"])
    if kind == "cut":
        return bytes(found[: rng.randrange(len(found))])
    if kind == "blank":
        start = rng.randrange(len(found))
        found[start : start + 512] = bytes(len(found[start : start + 512]))
        return bytes(found)
    letters = [place for place in range(100, len(found)) if 48 <= found[place] < 123]
    for _ in range(rng.choice([1, 3, 30])):
        if kind == "flip":
            found[rng.randrange(len(found))] = rng.randrange(256)
        else:
            found[rng.choice(letters)] = rng.choice(b'{}[]",:0xN')
    return bytes(found)


@pytest.mark.parametrize("block", range(4))
def test_a_damaged_database_is_told_in_one_sentence_and_left_alone(
    tmp_path: Path, sound: bytes, block: int, capsys: pytest.CaptureFixture[str]
) -> None:
    told = 0
    for number in range(30):
        content = damaged(sound, random.Random(1000 * block + number))
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / FILE_NAME).write_bytes(content)
        command = ["export", str(folder), "--format", "csv"] if number % 3 == 0 else ["report", str(folder)]
        status = run(command)
        said = capsys.readouterr().err
        assert status in (0, 2)
        if status == 2:
            told += 1
            assert FILE_NAME in said
            assert len(said.splitlines()) == 1
            assert (folder / FILE_NAME).read_bytes() == content
    assert told > 5


STATEMENTS = {
    "objective holds 'much'": "UPDATE runs SET objective = 'much'",
    "message holds b'": "UPDATE runs SET message = x'00ff'",
    "worst_limit holds b'3'": "UPDATE runs SET worst_limit = CAST(x'33' AS BLOB)",
    "findings hold something else": """UPDATE runs SET findings = '[1, {}]'""",
    "history: cost holds something else": """UPDATE histories SET cost = '["9", 4.0]'""",
    "lists differ in length": "UPDATE histories SET seconds = '[0.1]'",
    "a case's choice": """UPDATE cases SET choice = '{"case": 3}'""",
    "reference toppra is no table": """UPDATE cases SET reference = '{"toppra": 4}'""",
    "expected a number or null": """UPDATE cases SET reference = '{"kinematic_bound": {"lower": "x"}}'""",
    "a list stands where": "UPDATE plans SET plan = '[]'",
    "seeds is 0": """UPDATE plans SET plan = replace(plan, '"seeds": 2', '"seeds": 0')""",
    "schema version -3": "PRAGMA user_version = -3",
    "no such table": "DROP TABLE histories",
    "whole number": "UPDATE runs SET seed_index = 'x' || seed_index",
    "Expecting value": "UPDATE plans SET environment = '{\"a\": }'",
}


@pytest.mark.parametrize("sentence", STATEMENTS)
def test_values_nobody_wrote_are_named(tmp_path: Path, sound: bytes, sentence: str) -> None:
    (tmp_path / FILE_NAME).write_bytes(sound)
    with sqlite3.connect(tmp_path / FILE_NAME) as connection:
        connection.execute(STATEMENTS[sentence])
    connection.close()
    with pytest.raises(InputError, match=sentence.replace("'", ".")) as raised:
        write_report(tmp_path)
    assert FILE_NAME in str(raised.value)
    assert not (tmp_path / "report.html").exists()


@pytest.mark.parametrize("name", ["../../secret.json", "/etc/hostname", "..", "a/b.json", "null\0byte"])
def test_a_row_cannot_have_files_outside_its_folder_read(tmp_path: Path, name: str) -> None:
    folder = fill(tmp_path / "deep" / "out", curve(6))
    (tmp_path / "secret.json").write_text(json.dumps(curve(6)))
    change(folder, "UPDATE runs SET trajectory = ?", name)
    with Store(folder) as store, pytest.raises(InputError, match="leads out of"):
        store.trajectory(store.rows()[0])


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (None, "cannot be read"),
        (b"{", "is damaged"),
        (b"\xff", "is damaged"),
        (b"[" * 100_000, "is damaged"),
        (b"[]", "is damaged"),
        (b"{}", "schema: None given"),
        (json.dumps({**STRAIGHT, "coefficients": "../.."}).encode(), "coefficients: expected"),
    ],
)
def test_a_lost_motion_costs_its_picture_only(tmp_path: Path, content: bytes | None, reason: str) -> None:
    folder = fill(tmp_path, curve(load_case(CASE).n))
    for path in (folder / "trajectories").iterdir():
        if content is None:
            path.unlink()
        else:
            path.write_bytes(content)
    text = write_report(folder).markdown.read_text()
    assert "its motion is lost" in text
    assert reason in text


def test_a_motion_that_is_there_is_drawn(tmp_path: Path) -> None:
    folder = fill(tmp_path, curve(load_case(CASE).n))
    assert "lost" not in write_report(folder).markdown.read_text()


def test_a_motion_of_other_joints_is_not_drawn(tmp_path: Path) -> None:
    folder = fill(tmp_path, curve(load_case(CASE).n + 1))
    assert "joints, expected" in write_report(folder).markdown.read_text()


def test_a_disk_that_fills_up_while_rows_are_written_loses_no_earlier_row(tmp_path: Path) -> None:
    plan = Plan((CaseChoice("one"),), ("a",), seeds=200)
    specs = plan.runs(fakes.identify)
    with Store(tmp_path, create=True) as store:
        number = store.add_plan(plan, {}, specs)
    kept = 0
    with connections_with(f"PRAGMA max_page_count = {page_count(tmp_path) + 3}"), Store(tmp_path) as store:
        with pytest.raises(InputError, match=r"cannot write into .*results.sqlite: .*full"):
            for spec in specs:
                store.add_run(spec, record(spec.seed_index, "a", None), number)
                kept += 1
        assert 0 < kept < 200
        assert len(store.finished()) == kept
    with Store(tmp_path) as store:  # there is room again
        store.add_run(specs[kept], record(0, "a", None), number)
        assert {row.seed_index for row in store.rows()} == set(range(kept + 1))


def test_what_cannot_be_written_is_named_and_leaves_no_part(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = fill(tmp_path)
    before = {path.name for path in folder.rglob("*")}

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("ocp_traj.files.os.replace", full)
    with pytest.raises(InputError, match=r"cannot write .*report.md: No space left"):
        write_report(folder)
    with (
        Store(folder) as store,
        pytest.raises(InputError, match=r"cannot write .*spline.json: No space left"),
    ):
        spec = Plan((CaseChoice("one"),), ("a",), seeds=1).runs(fakes.identify)[0]
        store.add_run(spec, record(0, "a", curve(1)), 1)
    assert {path.name for path in folder.rglob("*")} == before


def test_a_database_another_program_holds_is_named(tmp_path: Path) -> None:
    folder = fill(tmp_path)
    with connections_with("PRAGMA busy_timeout = 1"):
        store = Store(folder)
    with store, sqlite3.connect(folder / FILE_NAME, isolation_level=None) as other:
        other.execute("BEGIN EXCLUSIVE")
        with pytest.raises(InputError, match=r"cannot write into .*locked"):
            store.add_plan(Plan(), {}, ())
        other.execute("ROLLBACK")
    other.close()


def test_scripts_in_every_text_of_a_row_stay_texts_in_the_report(tmp_path: Path) -> None:
    evil = "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"'`{{7*7}}"
    folder = fill(tmp_path)
    for column in ("case_name", "solver", "message", "reason", "worst_limit"):
        change(folder, f"UPDATE runs SET {column} = {column} || ?", evil)
    change(folder, "UPDATE runs SET findings = ?", json.dumps([evil]))
    change(folder, "UPDATE cases SET reference = ?, name = ?", json.dumps({evil: {"failed": evil}}), evil)
    change(folder, "UPDATE plans SET environment = json_set(environment, '$.python', ?)", evil)
    page = write_report(folder).html.read_text()
    assert "alert(1)" in page
    assert "<script>alert" not in page
    assert "<img" not in page
    assert "49" not in page.split("alert(2)")[1][:20]
