"""Files the command line draws and exports: motions with and without their case, and folders of comparisons."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from ocp_traj.cli import main as command_line
from ocp_traj.cli.main import run
from ocp_traj.trajectory import Trajectory
from ocp_traj.trajectory_files import read_csv, write_csv, write_json

CASE = """
schema = 1
name = "two-joints"
[waypoints]
joints = [[0.0, 0.0], [1.0, -0.5]]
[limits]
velocity = 1.0
acceleration = 2.0
jerk = 20.0
[spline]
virtual_knots = 1
"""


def sweep(n: int, duration: float = 2.0) -> Trajectory:
    """From rest to rest with 6 t^5 - 15 t^4 + 10 t^3, one rad a joint."""
    shape = np.tile(np.array([0.0, 0.0, 0.0, 10.0, -15.0, 6.0]) / duration ** np.arange(6), (1, n, 1))
    return Trajectory(np.array([0.0, duration]), shape, np.array([0.0, duration]), "quintic")


@pytest.fixture
def motion(tmp_path: Path) -> Path:
    """A motion of two joints that belongs to no case."""
    path = tmp_path / "motion.csv"
    write_csv(path, sweep(2), 100.0)
    return path


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A comparison of two small problems."""
    folder = tmp_path_factory.mktemp("compared")
    for name in ("alpha", "omega"):
        (folder / f"{name}.toml").write_text(CASE.replace("two-joints", name))
    arguments = ["--solvers", "random,de", "--budget", "200", "--seeds", "1", "--no-references"]
    files = [str(folder / "alpha.toml"), str(folder / "omega.toml")]
    assert run(["compare", *files, *arguments, "--output", str(folder / "out")]) == 0
    return folder / "out"


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run a wrong command; return its only line of complaint."""
    capsys.readouterr()
    assert run(list(arguments)) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    return lines[0]


def test_a_motion_of_no_case_is_drawn_without_limits(motion: Path) -> None:
    target = motion.with_name("plain.svg")
    assert run(["plot", str(motion), "--output", str(target)]) == 0
    bare = target.read_text()
    case = motion.with_name("case.toml")
    case.write_text(CASE)
    assert run(["plot", str(motion), "--case", str(case), "--output", str(target)]) == 0
    assert bare.startswith("<?xml") and target.read_text().count("<path") > bare.count("<path")


def test_a_result_is_drawn_with_the_packaged_case_it_names(tmp_path: Path) -> None:
    from ocp_traj.cli.motions import read_motion, task_of

    path = tmp_path / "result.json"
    assert run(["solve", "fang-2020-task-1", "--json", str(path)]) in (0, 1)
    task = task_of(read_motion(path), path, None, ())
    assert task.name == "fang-2020-task-1" and np.isfinite(task.limits.velocity).all()
    other = task_of(read_motion(path), path, None, ("limits.velocity=9.0",))
    assert other.limits.get("velocity")[:, 1] == pytest.approx(np.deg2rad(9.0))


@pytest.mark.parametrize(
    ("name", "known"), [("fang-2020-task-1", True), ("mine", False), (7, False), ("", False)]
)
def test_a_curve_belongs_to_the_case_in_its_file_where_that_is_packaged(
    tmp_path: Path, name: object, known: bool
) -> None:
    from ocp_traj.cli.motions import read_motion, task_of

    path = tmp_path / "curve.json"
    write_json(path, sweep(6))
    content = json.loads(path.read_text())
    content.pop("case", None)
    path.write_text(json.dumps({**content, **({"case": name} if isinstance(name, str) else {})}))
    task = task_of(read_motion(path), path, None, ())
    assert (task is not None) == known
    if task is not None:
        assert task.name == "fang-2020-task-1" and np.isfinite(task.limits.get("velocity")).any()


def test_a_case_with_other_joints_is_refused(motion: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "the motion has 2 joints, but case fang-2020-task-1 has 6" in complaint(
        capsys, "plot", str(motion), "--case", "fang-2020-task-1"
    )


def test_the_phase_plane_of_a_motion_is_drawn(motion: Path) -> None:
    case = motion.with_name("case.toml")
    case.write_text(CASE.replace("[1.0, -0.5]", "[1.0, 1.0]"))
    assert run(["plot", str(motion), "--picture", "phase-plane", "--case", str(case)]) == 0
    assert motion.with_name("motion-phase-plane.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("picture", ["bounds", "convergence"])
def test_one_problem_of_a_comparison_is_chosen(
    compared: Path, picture: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    texts = []
    for case in ("alpha", "omega"):
        target = tmp_path / f"{case}.svg"
        arguments = ["--picture", picture, "--case", case, "--output", str(target)]
        assert run(["plot", str(compared), *arguments]) == 0
        texts.append(target.read_text())
    assert "alpha" in texts[0] and "omega" not in texts[0]
    assert "omega" in texts[1] and "alpha" not in texts[1]
    said = complaint(capsys, "plot", str(compared), "--picture", picture, "--case", "other")
    assert said.endswith("case 'other' is not in this comparison, expected one of alpha, omega")


def test_a_comparison_without_runs_cannot_be_drawn(
    tmp_path: Path, compared: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import shutil
    import sqlite3

    folder = tmp_path / "empty"
    shutil.copytree(compared, folder)
    with sqlite3.connect(folder / "results.sqlite") as connection:
        connection.execute("delete from runs")
    assert complaint(capsys, "plot", str(folder)).endswith("holds no runs yet")


def test_a_comparison_is_exported_as_parquet_where_pyarrow_is(compared: Path, tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    for kind in ("csv", "parquet"):
        assert (
            run(["export", str(compared), "--format", kind, "--output", str(tmp_path / f"runs.{kind}")]) == 0
        )
    frame = pandas.read_parquet(tmp_path / "runs.parquet")
    assert len(frame) == 4
    assert frame["objective"].to_numpy() == pytest.approx(
        pandas.read_csv(tmp_path / "runs.csv")["objective"].to_numpy()
    )


def test_a_table_that_cannot_be_written_is_named(compared: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = compared / "results.sqlite" / "runs.csv"  # below a file: not even root can write there
    said = complaint(capsys, "export", str(compared), "--format", "csv", "--output", str(target))
    assert said.startswith(f"ocp-traj: cannot write {target}: ")


def test_a_motion_is_no_table(motion: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = complaint(capsys, "export", str(motion), "--format", "parquet")
    assert said.endswith("is a motion, expected --format csv, ros2 or urscript")


def test_a_motion_of_no_case_is_sent_with_names_and_by_force_only(
    motion: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = motion.with_name("goal.yaml")
    plain = ["export", str(motion), "--format", "ros2", "--output", str(target)]
    assert "has no robot that names its joints, expected --case or --joint-names" in complaint(capsys, *plain)
    named = [*plain, "--joint-names", "shoulder,elbow"]
    assert "carries no task, so that its limits are not known; nothing is written" in complaint(capsys, *named)
    assert not target.exists()
    assert run([*named, "--force"]) == 0
    assert "forced: the motion carries no task" in capsys.readouterr().err
    assert yaml.safe_load(target.read_text())["trajectory"]["joint_names"] == ["shoulder", "elbow"]
    assert "expected 2 different names" in complaint(capsys, *plain, "--joint-names", "shoulder")


def test_urscript_tells_that_the_motion_ends_on_a_period(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, target = tmp_path / "curve.json", tmp_path / "program.script"
    write_json(path, sweep(6, duration=0.999))
    names = "a,b,c,d,e,f"
    arguments = ["--format", "urscript", "--rate", "125", "--output", str(target), "--joint-names", names, "--force"]
    assert run(["export", str(path), *arguments]) == 0
    assert f"slowed by a factor of {1.0 / 0.999:.9g} so that it ends on a control period" in capsys.readouterr().err
    assert target.read_text().startswith("# joints: a, b, c, d, e, f\n")
    assert target.read_text().count("servoj") == 125


def test_solve_adds_references_and_writes_torques(tmp_path: Path) -> None:
    found, curve = tmp_path / "found.json", tmp_path / "motion.csv"
    case = tmp_path / "case.toml"
    case.write_text(
        CASE.replace("[[0.0, 0.0], [1.0, -0.5]]", "[[0, 0, 0, 0, 0, 0], [1, 1, 1, 1, 1, 1]]")
        + '[robot]\nmodel = "ur5"\n'
    )
    assert run(["solve", str(case), "--references", "--json", str(found), "--output", str(curve)]) == 0
    answer = json.loads(found.read_text())
    references = answer["references"]
    assert references["kinematic_bound"]["lower"] <= answer["duration"]
    assert set(references["toppra"]) == {"uniform", "chord"}
    header = curve.read_text().split("\n", 1)[0].split(",")
    assert sum(name.startswith("tau") for name in header) == 6
    assert read_csv(curve).n == 6


def test_energy_of_an_arm_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["solve", "ur5-helix", "--solver", "random[encoding=scaled]", "--budget", "20"]) in (0, 1)
    assert " J" in next(line for line in capsys.readouterr().out.splitlines() if line.startswith("  energy"))


def test_a_reader_that_goes_away_is_no_error(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", "from ocp_traj.cli.main import main; main()", "list", "robots"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    assert process.stdout is not None and process.stderr is not None
    process.stdout.close()
    errors = process.stderr.read().decode()
    assert process.wait(60) == 1
    assert "Traceback" not in errors


def test_ctrl_c_is_one_word(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupt(**_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(command_line.cli, "main", interrupt)
    assert run(["list", "robots"]) == command_line.INTERRUPTED == 130
    assert capsys.readouterr().err == "interrupted\n"
