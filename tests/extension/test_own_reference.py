"""A reference of another package, one file and an entry point, is shown wherever references are."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ocp_traj.case import load_case
from ocp_traj.cli.main import run
from ocp_traj.comparison.report.comparison_pictures import problem_entries
from ocp_traj.comparison.report.report import write_report
from ocp_traj.comparison.runs.compare import compare
from ocp_traj.comparison.runs.plan import CaseChoice, Plan
from ocp_traj.exceptions import InputError, UnavailableError
from ocp_traj.pictures.bounds import reference_entries
from ocp_traj.references import collect_references
from ocp_traj.references.reference import PROVED

PACKAGE = '''
"""No motion is shorter than the one in which every joint always drives at its largest speed."""

import numpy as np

from ocp_traj.references import Reference, ReferenceFinding
from ocp_traj.references.reference import PROVED


def at_full_speed(request):
    task = request.task
    travel = np.abs(np.diff(task.waypoints, axis=0))
    speed = np.asarray(task.limits.get("velocity"))[:, 1]
    return ReferenceFinding({"lower": float((travel / speed).max(axis=1).sum())}, {"": "by hand"})


FULL_SPEED = Reference(
    "full_speed", "full speed", at_full_speed, {"lower": (PROVED, "always at full speed")}, option="full_speed"
)
'''

CASE = """
schema = 1
name = "two-joints"
[waypoints]
joints = [[0.0, 0.0], [1.0, -0.5], [2.0, 0.3]]
[limits]
velocity = 1.0
acceleration = 2.0
"""


@pytest.fixture
def case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Install the package beside a case file, and return the case."""
    (tmp_path / "own_reference.py").write_text(PACKAGE)
    install(tmp_path, "own_reference:FULL_SPEED")
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "case.toml").write_text(CASE)
    return tmp_path / "case.toml"


def install(folder: Path, place: str) -> None:
    """Write what an installer would write of a package with one entry point."""
    metadata = folder / "own_reference-1.0.dist-info"
    metadata.mkdir(exist_ok=True)
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: own-reference\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(f"[ocp_traj.references]\nfull_speed = {place}\n")


def test_it_stands_in_the_answer_and_on_the_axis_of_bounds(case: Path) -> None:
    found = collect_references(load_case(case), convex=False, time_limit=1.0)
    assert found.to_json()["full_speed"] == {"lower": 2.0}
    assert found.messages()["full_speed"] == "by hand"
    (entry,) = [entry for entry in reference_entries(found) if entry.name == "always at full speed"]
    assert (entry.seconds, entry.kind) == (2.0, PROVED)
    assert collect_references(load_case(case), full_speed=False, convex=False).messages().keys() == {"kinematic_bound"}


def test_the_command_writes_it(case: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["reference", str(case), "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["full_speed"] == {"lower": 2.0}


def test_a_comparison_computes_it_and_its_report_and_picture_show_it(case: Path, tmp_path: Path) -> None:
    compare(Plan((CaseChoice(str(case)),), ("ipopt",), seeds=1, time_limit=600.0), tmp_path / "out")
    files = write_report(tmp_path / "out")
    (problem,) = files.judgement.problems
    assert problem.references["full_speed"] == {"lower": 2.0}
    assert problem.missing_references == ()
    text = files.markdown.read_text(encoding="utf-8")
    assert "/ full speed" in text and "always at full speed, s" in text
    names = [entry.name for entry in problem_entries(files.judgement, problem)]
    assert {"always at full speed", "kinematic bound", "ipopt"} <= set(names)
    assert any(name.startswith("TOPP-RA, ") for name in names)


def test_a_keyword_nobody_has_and_a_package_that_fails_are_named(case: Path) -> None:
    with pytest.raises(InputError, match="'magic' asks for no reference, expected one of certificate, convex, "):
        collect_references(load_case(case), magic=True)
    install(case.parent, "own_reference:at_full_speed")
    with pytest.raises(UnavailableError, match="reference 'full_speed' is a function, expected a Reference"):
        collect_references(load_case(case))
    install(case.parent, "own_reference:NOTHING")
    with pytest.raises(UnavailableError, match="reference 'full_speed' cannot be loaded: "):
        collect_references(load_case(case))
