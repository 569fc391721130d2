"""`prove` and `verify`, and proofs that `solve`, `reference` and `compare` write on request."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

import ocp_traj as ot
from ocp_traj.cli.main import run
from ocp_traj.proofs import NotProved, check, check_file

CASE = "machines-2024-490"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a result, its curve and its proof."""
    folder = tmp_path_factory.mktemp("proofs")
    files = ["--json", str(folder / "r.json"), "--output", str(folder / "m.csv"), "--proof", str(folder / "p.json")]
    assert run(["solve", CASE, *files]) == 0
    return folder


def test_solve_writes_a_proof_that_verify_accepts(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert CASE in check_file(str(folder / "p.json")).statement
    assert run(["verify", str(folder / "p.json"), "--case", CASE]) == 0
    assert capsys.readouterr().out.startswith("proved: every limit is kept at every instant of 4.31")


@pytest.mark.parametrize("name", ["r.json", "m.csv", "m.spline.json"])
def test_a_motion_in_a_file_is_proved_for_the_task_it_carries(folder: Path, tmp_path: Path, name: str) -> None:
    proof = tmp_path / "x.proof.json"
    option = "--result" if name == "r.json" else "--trajectory"
    assert run(["prove", option, str(folder / name), "--output", str(proof)]) == 0
    assert run(["verify", str(proof), "--case", CASE]) == 0


def test_what_cannot_be_proved_is_said_and_leaves_no_file(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    proof = tmp_path / "x.proof.json"
    command = ["prove", CASE, "--result", str(folder / "r.json"), "--output", str(proof)]
    assert run([*command, "--set", "limits.velocity=0.1"]) == 1
    assert "not proved: velocity of joint" in capsys.readouterr().out
    assert not proof.exists()


def test_a_proof_of_another_task_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["verify", str(folder / "p.json"), "--case", "fanuc-m10id8l"]) == 1
    assert run(["verify", str(folder / "p.json"), "--case", CASE, "--set", "limits.velocity=99.0"]) == 1
    assert capsys.readouterr().out.count("refused: the proof is about another task") == 2


def test_a_falsified_proof_is_refused_with_the_statement_and_a_broken_one_is_none(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = json.loads((folder / "p.json").read_text())
    document["claim"]["duration"] = (4.0).hex()
    (tmp_path / "false.json").write_text(json.dumps(document))
    assert run(["verify", str(tmp_path / "false.json")]) == 1
    assert capsys.readouterr().out.startswith("refused: the duration is 4.31")
    assert run(["verify", str(folder / "r.json")]) == 2
    assert "is no proof" in capsys.readouterr().err
    assert run(["verify", str(tmp_path / "missing.json")]) == 2


def test_bounds_are_proved(tmp_path: Path) -> None:
    task = tmp_path / "straight.toml"
    task.write_text(
        'schema = 1\nname = "straight"\n[waypoints]\njoints = [[0.0], [2.0]]\n'
        "[limits]\nvelocity = 1.0\nacceleration = 2.0\n"
    )
    for command in (["prove", str(task), "--bound", "--output"], ["reference", str(task), "--proof"]):
        proof = tmp_path / f"{command[0]}.proof.json"
        assert run([*command, str(proof)]) == 0
        document = json.loads(proof.read_text())
        assert 2.49 < float.fromhex(document["claim"]["duration"]) < 2.5
        assert run(["verify", str(proof), "--case", str(task)]) == 0


@pytest.mark.parametrize(
    "arguments",
    [
        ["prove", CASE, "--output", "x.json"],
        ["prove", "--bound", "--output", "x.json"],
        ["prove", CASE, "--bound", "--result", "r.json", "--output", "x.json"],
        ["verify", "p.json", "--set", "limits.velocity=1.0"],
    ],
)
def test_arguments_that_do_not_fit_are_wrong_input(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(arguments) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_result_proves_its_motion() -> None:
    result = ot.solve(ot.load_case(CASE), "ipopt", seed=0)
    assert check(result.prove()).kind == "motion"
    with pytest.raises(NotProved, match="no motion"):
        replace(result, trajectory=None).prove()


def test_a_comparison_proves_its_best_motions_and_the_report_marks_them(tmp_path: Path) -> None:
    folder = tmp_path / "study"
    command = ["compare", CASE, "--solvers", "ipopt", "--seeds", "1", "--no-references", "--jobs", "1"]
    assert run([*command, "--output", str(folder)]) == 0
    assert "feasible, proved" not in (folder / "report.md").read_text()
    assert run([*command, "--proofs", "--output", str(folder)]) == 0
    (proof,) = (folder / "proofs").iterdir()
    assert proof.name.endswith(".proof.json") and run(["verify", str(proof), "--case", CASE]) == 0
    assert "feasible, proved" in (folder / "report.md").read_text()
    document = json.loads(proof.read_text())
    document["motion"]["case"] = "renamed"  # holds still, but of a curve that was not stored
    start = document["motion"]["coefficients"][0][0]
    start[0] = (float.fromhex(start[0]) + 1e-12).hex()
    proof.write_text(json.dumps(document))
    assert run(["verify", str(proof)]) == 0
    assert run(["report", str(folder)]) == 0
    assert "feasible, proved" not in (folder / "report.md").read_text()
