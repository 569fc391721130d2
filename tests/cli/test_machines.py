"""The command line on poor machines: little memory, few descriptors, a full disk, packages that are not there."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from ocp_traj.cli import main as command_line
from ocp_traj.cli.main import run
from ocp_traj.codegen import compiled

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


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run a wrong command; return its only line of complaint."""
    capsys.readouterr()
    assert run(list(arguments)) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    return lines[0]


def in_a_process(*arguments: str, before: str = "", **settings: object) -> subprocess.CompletedProcess[str]:
    """Run the command line in a process of its own, after some Python; none of these may hang."""
    code = f"{before}\nimport sys\nfrom ocp_traj.cli.main import run\nsys.exit(run({list(arguments)!r}))"
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False, **settings
    )  # type: ignore[call-overload, no-any-return]


@pytest.mark.parametrize("gigabytes", [0.4, 0.6, 0.8])
def test_little_memory_is_an_error_and_no_hang(gigabytes: float) -> None:
    limit = int(gigabytes * 2**30)
    before = f"import resource; resource.setrlimit(resource.RLIMIT_AS, ({limit}, {limit}))"
    done = in_a_process("solve", "ur5-torque-limited", before=before)
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        f"ocp-traj: the limit of memory is {gigabytes:.2f} GiB (ulimit -v), expected at least 1.00 GiB: the numerical "
        "libraries do not load with less"
    ]
    assert in_a_process("solve", "--help", before=before).returncode == 0


def test_few_file_descriptors_are_an_error_and_no_hang(case: str, tmp_path: Path) -> None:
    before = "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (12, 12))"
    arguments = ["--solvers", "random", "--budget", "60", "--no-references", "--jobs", "2", "--output"]
    done = in_a_process("compare", case, *arguments, str(tmp_path / "out"), before=before)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert "Too many open files" in done.stderr


def test_a_full_disk_under_the_compile_cache_leaves_the_interpreter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import casadi as ca

    if compiled.find_compiler() is None:
        pytest.skip("there is no compiler here")
    monkeypatch.setenv(compiled.CACHE_VARIABLE, str(tmp_path))
    x = ca.SX.sym("x")
    function = ca.Function("f", [x], [ca.sin(x)])

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    for owner, name in ((compiled.tempfile, "TemporaryDirectory"), (Path, "write_text"), (os, "replace")):
        with monkeypatch.context() as patch:
            patch.setattr(owner, name, full)
            assert compiled.compile_function(function) is function
    assert compiled.compile_function(function) is not function


WITHOUT = textwrap.dedent(
    """
    import sys

    class Blocked:
        def find_spec(self, name, path=None, target=None):
            if name.partition(".")[0] in ("toppra", "cvxpy", "clarabel"):
                raise ModuleNotFoundError(f"No module named {name!r}", name=name)

    sys.meta_path.insert(0, Blocked())
    """
)


def test_without_toppra_cvxpy_and_clarabel_all_but_references_work(case: str, tmp_path: Path) -> None:
    result = str(tmp_path / "r.json")
    assert in_a_process("solve", case, "--json", result, before=WITHOUT).returncode == 0
    assert in_a_process("audit", "--result", result, before=WITHOUT).returncode == 0
    many = tmp_path / "many.toml"
    points = ", ".join(f"[{0.3 * k % 1.0}, {0.2 * k % 0.7}]" for k in range(9))
    many.write_text(CASE.replace("[[0.0, 0.0], [1.0, -0.5]]", f"[{points}]"))
    assert in_a_process("solve", str(many), before=WITHOUT).returncode == 0
    arguments = ["--solvers", "ipopt", "--seeds", "1", "--jobs", "1", "--output", str(tmp_path / "out")]
    assert in_a_process("compare", case, *arguments, before=WITHOUT).returncode == 0


def test_a_reference_says_which_package_is_missing(case: str, tmp_path: Path) -> None:
    target = tmp_path / "reference.json"
    Path(case).write_text(CASE + "jerk = 20.0\n")
    done = in_a_process("reference", case, "--jerk", "--json", str(target), before=WITHOUT)
    assert done.returncode == 0 and "Traceback" not in done.stderr
    found = json.loads(target.read_text())
    assert found["kinematic_bound"]["estimate"] is not None and found["jerk_estimate"]["estimate"] is not None
    assert found["toppra"] == found["convex"] == {"uniform": None, "chord": None}
    assert found["messages"]["toppra"] == "TOPP-RA needs toppra, not installed here (pip install toppra)"
    assert "needs toppra, cvxpy, clarabel, not installed here" in found["messages"]["convex"]
    assert found["messages"]["toppra"] in done.stdout


def test_a_missing_package_is_named_by_every_command(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def gone(*_: object, **__: object) -> None:
        raise ModuleNotFoundError("No module named 'cvxpy'", name="cvxpy")

    monkeypatch.setattr(command_line.cli, "main", gone)
    assert complaint(capsys, "list") == "ocp-traj: this needs the package cvxpy, not installed here (pip install cvxpy)"
