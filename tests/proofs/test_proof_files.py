"""Proof files: what is no proof, the exit statuses, writing, and whose task a proof is about."""

from __future__ import annotations

import ast
import copy
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from helpers.proofs.proof_motions import kinematic_motion, torque_motion
from ocp_traj.exceptions import InputError
from ocp_traj.proofs import NotAProof, Refused, check, check_file, checker, is_about, prove, write_proof
from ocp_traj.proofs.proof_file import LARGEST_BYTES

CHECKER = Path(checker.__file__)
PYTHON = shutil.which("python3.10")


@pytest.fixture(scope="module")
def proof() -> dict[str, Any]:
    return prove(*kinematic_motion(4))


@pytest.fixture(scope="module")
def dynamic_proof() -> dict[str, Any]:
    return prove(*torque_motion(11, friction=1.0, weights={"energy": 1.0}))


def oldest_python() -> str:
    """Return Python 3.10 if there is one that runs, else this one."""
    if PYTHON and subprocess.run([PYTHON, "-I", "-S", "-c", ""], capture_output=True).returncode == 0:
        return PYTHON
    return sys.executable


def test_the_proof_in_the_documentation_is_one() -> None:
    page = (Path(__file__).parents[2] / "docs" / "proofs.md").read_text(encoding="utf-8")
    document = json.loads(page.split("```json\n")[1].split("```")[0])
    assert check(document).statement.startswith("every limit is kept at every instant of 2 s (task by-hand")
    document["motion"]["coefficients"][1][0][2] = "-0x1.00002p-1"
    with pytest.raises(Refused, match="waypoint 2 is missed"):
        check(document)


def run(file: Path) -> subprocess.CompletedProcess[str]:
    command = [oldest_python(), "-I", "-S", str(CHECKER), str(file)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_checker_needs_the_standard_library_only() -> None:
    tree = ast.parse(CHECKER.read_text(encoding="utf-8"))
    imported = {
        name.split(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, (ast.Import, ast.ImportFrom))
        for name in ([alias.name for alias in node.names] if isinstance(node, ast.Import) else [node.module or ""])
    }
    assert imported <= set(sys.stdlib_module_names)


def test_the_checker_runs_alone_with_three_exit_statuses(
    proof: dict[str, Any], dynamic_proof: dict[str, Any], tmp_path: Path
) -> None:
    for index, document in enumerate((proof, dynamic_proof)):
        write_proof(document, tmp_path / f"{index}.proof.json")
        done = run(tmp_path / f"{index}.proof.json")
        assert done.returncode == 0 and done.stdout.startswith("proved: every limit is kept at every instant")
        assert check(document).digest in done.stdout and not done.stderr
    false = copy.deepcopy(proof)
    false["task"]["waypoints"][0][0] = (1e3).hex()
    (tmp_path / "false.json").write_text(json.dumps(false))
    done = run(tmp_path / "false.json")
    assert done.returncode == 1 and done.stdout == "refused: waypoint 1 is missed by joint 1\n" and not done.stderr
    for name, text in (("empty", ""), ("list", "[]"), ("deep", "[" * 100_000), ("latin", "\xff")):
        (tmp_path / name).write_bytes(text.encode("latin-1"))
        done = run(tmp_path / name)
        assert done.returncode == 2 and done.stdout.startswith("no proof: ") and not done.stderr
    assert run(tmp_path / "missing").returncode == 2


def test_the_command_line_takes_one_file(
    proof: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.proof.json"
    write_proof(proof, path)
    assert checker.main([str(path)]) == 0 and checker.main([]) == 2 and checker.main([str(path)] * 2) == 2
    assert "usage: python checker.py FILE" in capsys.readouterr().out
    path.write_text("{")
    assert checker.main([str(path)]) == 2
    false = copy.deepcopy(proof)
    false["claim"]["duration"] = (1.0).hex()
    path.write_text(json.dumps(false))
    assert checker.main([str(path)]) == 1


def changed(path: str, value: Any) -> Callable[[dict[str, Any]], None]:
    """Return a change of the entry at a dotted path; None deletes it."""

    def change(document: dict[str, Any]) -> None:
        *parents, last = (int(key) if key.isdigit() else key for key in path.split("."))
        for key in parents:
            document = document[key]
        if value is None:
            del document[last]
        else:
            document[last] = value

    return change


NO_PROOFS: dict[str, Callable[[dict[str, Any]], None]] = {
    "schema": changed("schema", 2),
    "schema true": changed("schema", True),
    "kind": changed("kind", "cover"),
    "unknown key": changed("comment", "x"),
    "missing evidence": changed("evidence", None),
    "evidence of a motion": changed("evidence", {"tree": []}),
    "missing claim": changed("claim", None),
    "unknown key of the task": changed("task.extra", 1),
    "missing limits": changed("task.limits", None),
    "unknown limit": changed("task.limits.snap", []),
    "limits of another shape": changed("task.limits.velocity", []),
    "unknown weight": changed("task.weights.style", "0x1p+0"),
    "weight zero": changed("task.weights.time", "0x0.0p+0"),
    "number": changed("task.waypoints.0.0", 1.0),
    "whole number": changed("task.waypoints.0.0", 1),
    "decimal text": changed("task.waypoints.0.0", "1.5"),
    "nan": changed("task.waypoints.0.0", "nan"),
    "infinite waypoint": changed("task.waypoints.0.0", "inf"),
    "too large": changed("task.waypoints.0.0", "0x1.0p+1024"),
    "blanks": changed("task.waypoints.0.0", " 0x1p+0"),
    "null": changed("task.waypoints.0", [None]),
    "ragged waypoints": changed("task.waypoints.1", []),
    "one waypoint": changed("task.waypoints", [["0x1p+0"]]),
    "negative tolerance": changed("task.tolerance.0.0", "-0x1p+0"),
    "lower above upper": changed("task.limits.velocity.0.0.0", "0x1p+900"),
    "zero excluded": changed("task.limits.velocity.0.0.0", "0x0.8p-900"),
    "boundary": changed("task.boundary.velocity", ["0x0.0p+0"]),
    "boundary without jerk": changed("task.boundary.jerk", None),
    "name": changed("task.name", 3),
    "long name": changed("task.name", "x" * 2000),
    "no breakpoints": changed("motion.breakpoints", []),
    "one breakpoint": changed("motion.breakpoints", ["0x0.0p+0"]),
    "pieces missing": changed("motion.coefficients.0", None),
    "joint missing": changed("motion.coefficients.0.0", None),
    "degrees differ": changed("motion.coefficients.0.0", ["0x0.0p+0"]),
    "degree too high": changed("motion.coefficients", "replaced below"),
    "motion schema": changed("motion.schema", 2),
    "unknown cost": changed("claim.costs", {"time": "0x1p+0", "style": "0x1p+0"}),
    "claim without costs": changed("claim", {"duration": "0x1p+0"}),
}
NO_DYNAMIC_PROOFS: dict[str, Callable[[dict[str, Any]], None]] = {
    "no robot": lambda document: document["task"].update(robot=None),
    "link missing": changed("task.robot.links.0", None),
    "unknown key of a link": changed("task.robot.links.0.colour", "red"),
    "parent below the root": changed("task.robot.links.0.parent", -1),
    "own parent": changed("task.robot.links.0.parent", 1),
    "parent true": changed("task.robot.links.1.parent", True),
    "prismatic 1": changed("task.robot.links.0.prismatic", 1),
    "rotation": changed("task.robot.links.0.rotation.0", ["0x1p+0"]),
    "infinite mass": changed("task.robot.links.0.mass", "inf"),
    "negative friction": changed("task.robot.coulomb.0", "-0x1p+0"),
    "motor losses without factors": changed("task.weights.motor_loss", "0x1p+0"),
}


@pytest.mark.parametrize("name", NO_PROOFS)
def test_what_has_not_the_form_of_a_proof_is_none(proof: dict[str, Any], name: str) -> None:
    document = copy.deepcopy(proof)
    if name == "degree too high":
        document["motion"]["coefficients"] = [[c * 40 for c in piece] for piece in document["motion"]["coefficients"]]
    else:
        NO_PROOFS[name](document)
    with pytest.raises(NotAProof):
        check(document)


@pytest.mark.parametrize("name", NO_DYNAMIC_PROOFS)
def test_what_has_not_the_form_of_a_robot_is_no_proof(dynamic_proof: dict[str, Any], name: str) -> None:
    document = copy.deepcopy(dynamic_proof)
    NO_DYNAMIC_PROOFS[name](document)
    with pytest.raises(NotAProof):
        check(document)


def test_claims_and_evidence_of_bounds_have_their_form(bounds: dict[tuple[str, str], dict[str, Any]]) -> None:
    good = bounds["machines-2024-490", "every motion"]
    changes = {
        "claim.of": "all",
        "claim.duration": "-0x1p+0",
        "motion": {},
        "evidence.tree": {},
        "evidence.lemmas": {},
        "evidence.more": [],
        "evidence.tree.0": [],
        "evidence.tree.1": ["split"],
        "evidence.tree.2": ["split", 0, "0x1p-1"],
        "evidence.tree.3": ["split", True, "0x1p-1"],
        "evidence.tree.4": "empty",
        "evidence.tree.5": ["trust", 1],
    }
    for path, value in changes.items():
        document = copy.deepcopy(good)
        changed(path, value)(document)
        with pytest.raises(NotAProof):
            check(document)
    for lemma in ({}, {"first": 0, "last": 1, "total": "0x1p-9", "tree": []},
                  {"first": 1, "last": 9, "total": "0x1p-9", "tree": []}):  # fmt: skip
        document = copy.deepcopy(good)
        document["evidence"]["lemmas"] = [lemma]
        with pytest.raises(NotAProof):
            check(document)


def test_json_that_a_reader_could_take_two_ways_is_no_proof(proof: dict[str, Any], tmp_path: Path) -> None:
    path, text = tmp_path / "x.json", json.dumps(proof)
    for wrong, message in (
        ('{"schema": 1, ' + text[1:], "twice"),
        (text.replace('"schema": 1', '"schema": 1.0', 1), "whole numbers"),
        (text.replace('"schema": 1', '"schema": NaN', 1), "whole numbers"),
        (text[:-1], "no JSON"),
        (text + text, "no JSON"),
        ("1" * 10_000, "no JSON"),
    ):
        path.write_text(wrong)
        with pytest.raises(NotAProof, match=message):
            check_file(str(path))


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checker, "LARGEST_FILE", 10)
    (tmp_path / "x").write_text("[" + " " * 10)
    with pytest.raises(NotAProof, match="more than 10 bytes"):
        check_file(str(tmp_path / "x"))


def test_numbers_that_overflow_are_refused(dynamic_proof: dict[str, Any]) -> None:
    for key in ("mass", "armature"):
        document = copy.deepcopy(dynamic_proof)
        for link in document["task"]["robot"]["links"]:
            link[key] = "0x1p+1023"
        with pytest.raises(Refused):
            check(document)


def test_a_proof_is_written_whole_or_not_at_all(proof: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "a.proof.json"
    write_proof(proof, path)
    first = path.read_bytes()
    assert check_file(str(path)).kind == "motion" and path.stat().st_mode & 0o777 == 0o666 & ~current_umask()
    large = copy.deepcopy(proof)
    large["task"]["name"] = "x" * LARGEST_BYTES
    with pytest.raises(InputError, match="expected at most"):
        write_proof(large, path)
    assert path.read_bytes() == first and os.listdir(tmp_path) == ["a.proof.json"]
    with pytest.raises(InputError, match="cannot be written"):
        write_proof(proof, tmp_path / "no" / "such.json")


def current_umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def test_a_proof_knows_its_task(proof: dict[str, Any]) -> None:
    task, _ = kinematic_motion(4)
    assert is_about(proof, task)
    assert not is_about(proof, kinematic_motion(5)[0])
    assert not is_about(proof, task.changed(name="other"))
    nudged = task.changed(waypoints=task.waypoints * (1 + 1e-15))
    assert is_about(proof, nudged) and not is_about(proof, task.changed(waypoints=task.waypoints * (1 + 1e-9)))
    forged = copy.deepcopy(proof)
    forged["task"]["limits"]["velocity"][0][1][0] = "inf"
    assert not is_about(forged, task)
    assert not is_about({}, task)


def test_the_digest_is_of_the_task_and_of_nothing_else(proof: dict[str, Any]) -> None:
    other = copy.deepcopy(proof)
    other["motion"]["case"] = "renamed"
    other["task"] = dict(reversed(other["task"].items()))
    assert check(other).digest == check(proof).digest
    other["task"]["name"] = "renamed"
    assert check(other).digest != check(proof).digest
