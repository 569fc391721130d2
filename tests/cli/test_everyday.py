"""Everyday input at the command line: near names, bad outputs, odd files and machines; one sentence each, no hang."""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import sys
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import pytest
from click.shell_completion import ShellComplete

import ocp_traj as ot
from metaheuristics import ParticleSwarm
from ocp_traj.cli.main import cli, run
from ocp_traj.exceptions import CaseError, InputError
from ocp_traj.trajectory_files import MAX_ROWS, read_csv

CASE = """
schema = 1
name = "two-joints"
[waypoints]
joints = [[0.0, 0.0], [1.0, -0.5]]
[limits]
velocity = 1.0
acceleration = 2.0
"""


@pytest.fixture(name="case")
def make_case(tmp_path: Path) -> str:
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    return str(path)


@pytest.fixture(scope="module", name="compared")
def make_compared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("compared")
    (folder / "case.toml").write_text(CASE)
    arguments = ["--solvers", "random", "--budget", "60", "--seeds", "1", "--no-references"]
    assert run(["compare", str(folder / "case.toml"), *arguments, "--output", str(folder / "out")]) == 0
    return folder / "out"


@pytest.fixture(name="folder")
def copy_of_compared(compared: Path, tmp_path: Path) -> Path:
    import shutil

    return shutil.copytree(compared, tmp_path / "copy")


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run a wrong command; return its only line of complaint."""
    capsys.readouterr()
    assert run(list(arguments)) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    return lines[0]


# Help and names ----------------------------------------------------------------------------------------------


def test_the_bare_command_prints_its_help_as_it_is_set(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([]) == 0
    bare = capsys.readouterr().out
    assert run(["--help"]) == 0
    assert bare == capsys.readouterr().out
    assert len(bare.splitlines()) > 10 and "\n  solve " in bare


def test_the_package_is_a_command(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-m", "ocp_traj", "list", "families"], capture_output=True, text=True)
    assert done.returncode == 0 and "septic" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        (["slove"], "solve"),
        (["list", "robot"], "robots"),
        (["solve", "ur5-paletizing"], "ur5-palletizing"),
        (["solve", "CASE", "--solver", "ipoptt"], "ipopt"),
        (["compare", "CASE", "--solvers", "ipopt,sssa"], "ssa"),
        (["solve", "CASE", "--solver", "pso[inertai=linear]"], "inertia"),
        (["solve", "CASE", "--solver", "ipopt[tolerence=1e-6]"], "tolerance"),
        (["solve", "CASE", "--set", "spline.family=cubik"], "cubic"),
        (["solve", "CASE", "--set", "limits.velocty=1"], "velocity"),
        (["solve", "CASE", "--set", "robot.model=ur55"], "ur5"),
        (["export", "CASE", "--format", "ross2"], "ros2"),
        (["pareto", "CASE", "--objective", "jrek"], "jerk"),
        (["solve", "CASE", "--solvr", "ipopt"], "--solver"),
    ],
)
def test_a_near_name_is_suggested(
    arguments: list[str], meant: str, case: str, capsys: pytest.CaptureFixture[str]
) -> None:
    said = complaint(capsys, *[case if word == "CASE" else word for word in arguments]).lower()
    assert "did you mean" in said and repr(meant) in said.split("did you mean")[1]


def test_names_of_the_library_are_suggested_too() -> None:
    for call, meant in (
        (lambda: ot.load_robot("ur55"), "ur5"),
        (lambda: ot.load_case("ur5-helx"), "ur5-helix"),
        (lambda: ot.TrajectoryTask([[0.0], [1.0]], family="cubik"), "cubic"),
        (lambda: ot.TrajectoryTask([[0.0], [1.0]]).changed(familly="cubic"), "family"),
    ):
        with pytest.raises(InputError, match=f"did you mean '{meant}'"):
            call()


@pytest.mark.parametrize(
    ("words", "incomplete", "expected"),
    [
        (["solve"], "ur5-p", {"ur5-palletizing"}),
        (["check"], "yu", {"yu-2025-four-points"}),
        (["plot", "x.json", "--case"], "fang", {"fang-2020-task-1"}),
        (["solve", "x", "--solver"], "ipop", {"ipopt", "ipopt-multistart"}),
        (["compare", "x", "--solvers"], "pso,t-s", {"pso,t-ssa"}),
        (["solve", "x", "--set"], "robot.model=ur1", {"robot.model=ur10"}),
        (["solve", "x", "--set"], "spline.family=c", {"spline.family=cubic"}),
        (["solve", "x", "--set"], "spline.v", {"spline.virtual_knots="}),
        ([], "exp", {"export"}),
    ],
)
def test_a_shell_completes_names(words: list[str], incomplete: str, expected: set[str]) -> None:
    shell = ShellComplete(cli, {}, "ocp-traj", "_OCP_TRAJ_COMPLETE")
    assert {item.value for item in shell.get_completions(words, incomplete)} == expected


def test_a_case_that_is_a_file_is_completed_by_the_shell() -> None:
    shell = ShellComplete(cli, {}, "ocp-traj", "_OCP_TRAJ_COMPLETE")
    assert [item.type for item in shell.get_completions(["solve"], "my-ca")] == ["file"]


def test_everything_there_is_is_listed_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["list", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found) == {"schema", "robots", "solvers", "cases", "families"}
    assert "ur5" in found["robots"]
    assert {"name": "ipopt", "kind": "gradient", "available": True, "reason": None} in found["solvers"]
    assert found["families"][0]["default_virtual_knots"] == 3
    assert run(["list", "cases", "--json"]) == 0
    assert set(json.loads(capsys.readouterr().out)) == {"schema", "cases"}


# Outputs -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        ["solve", "CASE", "--output", "FILE.csv"],
        ["solve", "CASE", "--json", "FILE"],
        ["pareto", "CASE", "--output", "FILE"],
        ["pareto", "CASE", "--plot", "FILE.png"],
        ["pareto", "CASE", "--json", "FILE"],
        ["reference", "CASE", "--json", "FILE"],
        ["reference", "CASE", "--plot", "FILE.png"],
        ["audit", "CASE", "--durations", "2", "--json", "FILE"],
    ],
)
def test_an_output_that_cannot_be_written_is_refused_before_the_work(
    arguments: Sequence[str],
    case: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("the work began")

    monkeypatch.setattr("ocp_traj.case.load_case", never)
    for place, reason in (("nowhere/x", "there is no folder"), (".", "it is a folder")):
        words = [
            case if word == "CASE" else word.replace("FILE", str(tmp_path / place)) if place != "." else
            str(tmp_path) if word.startswith("FILE") else word
            for word in arguments
        ]  # fmt: skip
        if reason == "it is a folder" and any(word.endswith(".png") for word in arguments):
            continue  # its ending is refused first
        assert reason in complaint(capsys, *words)


def test_a_full_standard_output_is_one_sentence(tmp_path: Path) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("there is no /dev/full here")
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "ocp_traj", "list", "families"], stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        "ocp-traj: standard output or a file cannot be used: No space left on device"
    ]


def test_ascii_output_replaces_what_it_cannot_write() -> None:
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0", "LC_ALL": "C"}
    done = subprocess.run(
        [sys.executable, "-m", "ocp_traj", "list", "families"], capture_output=True, text=True, env=environment
    )
    assert done.returncode == 0 and "septic" in done.stdout and done.stdout.isascii() and not done.stderr


# Files -------------------------------------------------------------------------------------------------------


def test_a_dotted_key_of_forty_kilobytes_is_refused_before_it_is_read(tmp_path: Path) -> None:
    key = "a." * 20000 + "a"
    for text in (f"{key} = 1", f"x = {{ {key} = 1 }}", f"[{key.replace('.', ' . ')}]", '"a".' * 9000 + "a = 1"):
        path = tmp_path / "deep.toml"
        path.write_text(f"schema = 1\n{text}\n")
        with pytest.raises(CaseError, match="line 2 has a key of more than 50 parts"):
            ot.load_case(path)


def test_numbers_and_texts_with_points_are_no_deep_keys(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    numbers = ", ".join(f"{k}.5" for k in range(200))
    path.write_text(CASE.replace("[waypoints]", f'title = "{"a." * 60}"\n[waypoints]'))
    assert ot.load_case(path).title == "a." * 60
    path.write_text(CASE.replace("velocity = 1.0", f"velocity = [{numbers}]"))
    with pytest.raises(CaseError, match=r"limits\.velocity: 200 numbers given"):
        ot.load_case(path)


def test_a_trajectory_of_millions_of_rows_is_refused_before_it_is_parsed(tmp_path: Path) -> None:
    path = tmp_path / "big.csv"
    path.write_text("t,q1,v1,a1\n" + "0,0,0,0\n" * (MAX_ROWS + 2))
    with pytest.raises(InputError, match="has more than 1000000 rows of 4 numbers"):
        read_csv(path)


@pytest.mark.parametrize("command", [["report"], ["plot"], ["export", "--format", "csv"]])
def test_an_empty_file_of_results_is_no_comparison(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "results.sqlite").touch()
    said = complaint(capsys, command[0], str(tmp_path), *command[1:])
    assert said.endswith("holds no comparison: results.sqlite is empty")
    assert (tmp_path / "results.sqlite").stat().st_size == 0


def test_locked_results_are_named_as_such(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ocp_traj.comparison.runs.store.READER_SECONDS", 0.1)
    with closing(sqlite3.connect(folder / "results.sqlite", isolation_level=None)) as other:
        other.execute("BEGIN EXCLUSIVE")
        said = complaint(capsys, "report", str(folder))
    assert "is locked by another process" in said and "restore" not in said


def test_a_view_that_never_ends_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with closing(sqlite3.connect(folder / "results.sqlite")) as connection, connection:
        connection.execute("ALTER TABLE runs RENAME TO kept")
        endless = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT kept.* FROM kept, n"
        connection.execute(f"CREATE VIEW runs AS {endless}")
    for command in (["report"], ["plot"], ["export", "--format", "csv"]):
        assert "has the view 'runs', expected tables only" in complaint(capsys, command[0], str(folder), *command[1:])


@pytest.mark.parametrize("kind", ["pipe", "zero", "folder"])
def test_what_is_no_file_among_the_trajectories_is_told(folder: Path, kind: str) -> None:
    (place,) = (folder / "trajectories").iterdir()
    place.unlink()
    if kind == "pipe":
        os.mkfifo(place)
    elif kind == "zero":
        place.symlink_to("/dev/zero")
    else:
        place.mkdir()
    assert run(["report", str(folder)]) == 0
    report = (folder / "report.md").read_text()
    assert "its motion is lost" in report
    assert ("Is a directory" if kind == "folder" else "it is not a regular file") in report


def test_names_and_messages_are_no_html_in_the_report(folder: Path) -> None:
    with closing(sqlite3.connect(folder / "results.sqlite")) as connection, connection:
        connection.execute("UPDATE runs SET case_name = '<script>alert(1)</script>', message = '<img src=x>|'")
        connection.execute("UPDATE runs SET feasible = 0, reason = 'error', status = 'failed'")
    assert run(["report", str(folder)]) == 0
    for name in ("report.md", "report.html"):
        report = (folder / name).read_text()
        assert "<script>alert" not in report and "<img src=x" not in report
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in (folder / "report.md").read_text()


# Solvers of one's own ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("solver", [ParticleSwarm(), ParticleSwarm, 7, print])
def test_what_is_no_solver_is_refused_with_one_sentence(solver: object, case: str) -> None:
    with pytest.raises(InputError, match=r"given, expected a name of `ocp-traj list solvers` or an instance"):
        ot.solve(ot.load_case(case), solver)  # type: ignore[arg-type]
