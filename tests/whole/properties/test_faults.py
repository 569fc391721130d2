"""A full disk, a folder that cannot be written, a database cut off, a clock that goes backwards: nothing is lost."""

from __future__ import annotations

import os
import resource
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ocp_traj.exceptions import OcpTrajError
from ocp_traj.robot import robot_from_urdf

CASE = """
schema = 1
name = "tiny"
[waypoints]
joints = [[0.0], [1.0], [0.5]]
[limits]
velocity = 1.0
acceleration = 2.0
[search]
duration = [0.5, 5.0]
"""
ARGUMENTS = [
    "compare",
    "tiny.toml",
    "--solvers",
    "random,ipopt",
    "--seeds",
    "2",
    "--budget",
    "60",
    "--no-references",
    "--output",
    "out",
]


def limit_files() -> None:
    """In the child: no file may grow beyond what an empty database needs; writing more fails as on a full disk."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (9_000, 9_000))


def run(folder: Path, prepare=None, output: str = "out") -> subprocess.CompletedProcess[str]:
    (folder / "tiny.toml").write_text(CASE)
    arguments = [*ARGUMENTS[:-1], output]
    command = [sys.executable, "-c", "from ocp_traj.cli.main import main; main()", *arguments]
    # coverage of subprocesses would fill the disk too, and complain
    env = {name: value for name, value in os.environ.items() if name != "COVERAGE_PROCESS_CONFIG"}
    return subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        text=True,
        preexec_fn=prepare,
        timeout=300,
        env=env if prepare else None,
    )


def rows(folder: Path) -> int:
    with sqlite3.connect(folder / "out" / "results.sqlite") as connection:
        (tables,) = connection.execute("select count(*) from runs").fetchone()
    return int(tables)


def test_a_full_disk_is_one_sentence_and_the_next_start_finishes(tmp_path):
    full = run(tmp_path, limit_files)
    assert full.returncode != 0
    assert "Traceback" not in full.stderr
    assert full.stderr.strip()
    again = run(tmp_path)
    assert again.returncode == 0, again.stderr
    assert rows(tmp_path) == 4


def test_a_database_cut_off_in_the_middle_is_named_and_not_overwritten(tmp_path):
    assert run(tmp_path).returncode == 0
    database = tmp_path / "out" / "results.sqlite"
    content = database.read_bytes()
    database.write_bytes(content[: len(content) // 2])
    refused = run(tmp_path)
    if refused.returncode == 0:  # SQLite could still read what is left: then the missing runs were done again
        assert rows(tmp_path) == 4
    else:
        assert "results.sqlite" in refused.stderr
        assert "Traceback" not in refused.stderr
        assert database.read_bytes() == content[: len(content) // 2]


@pytest.mark.skipif(os.geteuid() == 0, reason="root writes anywhere")
def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "tiny.toml").write_text(CASE)
    tmp_path.chmod(0o500)
    try:
        refused = run(tmp_path)
    finally:
        tmp_path.chmod(0o700)
    assert refused.returncode == 2
    assert "out" in refused.stderr


@pytest.mark.parametrize("output", ["out", "out/below", "/proc/below"])
def test_a_folder_not_even_root_can_write_is_named(tmp_path, output):
    """A file is in the way, or the file system takes no folders."""
    (tmp_path / "out").write_text("in the way")
    refused = run(tmp_path, output=output)
    assert refused.returncode == 2
    sentence = refused.stderr.removeprefix("ocp-traj: ").splitlines()
    assert len(sentence) == 1 and output in sentence[0]
    assert (tmp_path / "out").read_text() == "in the way"


@pytest.mark.parametrize("error", [PermissionError(13, "Permission denied"), OSError(28, "No space left")])
def test_a_folder_that_stops_taking_files_is_named(tmp_path, monkeypatch, capsys, error):
    """The same refusals as from a folder without rights, or a full disk: for root too."""
    from ocp_traj.cli.main import run as run_here

    def refuse(path, *arguments, **settings):
        if os.fspath(path).endswith(".lock"):
            raise error
        return opened(path, *arguments, **settings)

    opened = os.open
    monkeypatch.setattr(os, "open", refuse)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.toml").write_text(CASE)
    assert run_here(ARGUMENTS) == 2
    assert capsys.readouterr().err == f"ocp-traj: cannot write into out: {error.strerror}\n"


def test_a_clock_that_goes_backwards_does_not_stop_a_time_limit(monkeypatch):
    from ocp_traj.solving import solve
    from ocp_traj.task import Limits, TrajectoryTask

    now = time.time()
    monkeypatch.setattr(time, "time", lambda: now - 3600.0)
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=1.0, acceleration=2.0))
    result = solve(task, "random", budget=10**9, time_limit=0.5)
    assert result.status == "time_exhausted"
    assert 0 < result.solution.solve_time < 30


URDF = '<robot name="r"><link name="a"/><link name="b"/>{}</robot>'
JOINT = '<joint name="j" type="{}"><parent link="a"/><child link="b"/><axis xyz="{}"/>{}</joint>'


@given(
    st.one_of(
        st.text(max_size=200),
        st.builds(
            lambda kind, axis, rest: URDF.format(JOINT.format(kind, axis, rest)),
            st.sampled_from(
                ["revolute", "prismatic", "continuous", "fixed", "floating", "planar", "nonsense"]
            ),
            st.sampled_from(["0 0 1", "0 0 0", "nan 0 0", "1e400 0 0", "a b c", ""]),
            st.sampled_from(
                ["", '<limit lower="1" upper="-1" effort="-3" velocity="nan"/>', '<mimic joint="j"/>']
            ),
        ),
    )
)
@settings(max_examples=60, deadline=None, derandomize=True)
def test_whatever_a_urdf_holds_a_robot_or_a_named_error_comes_out(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("urdf") / "arm.urdf"
    path.write_text(text, encoding="utf-8")
    try:
        robot = robot_from_urdf(path)
    except OcpTrajError as error:
        assert "arm.urdf" in str(error)
    else:
        assert robot.n >= 1
