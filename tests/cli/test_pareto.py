"""``ocp-traj pareto`` writes what it shows, keeps what it found, and refuses what makes no sense."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from ocp_traj.cli.main import run

CASE = """schema = 1
name = "small"
[waypoints]
joints = [[0.0, 0.0], [1.0, 0.5], [0.5, 1.0]]
[limits]
velocity = 2.0
acceleration = 4.0
[spline]
family = "cubic"
virtual_knots = 1
"""


@pytest.fixture
def case(tmp_path: Path) -> str:
    path = tmp_path / "small.toml"
    path.write_text(CASE)
    return str(path)


def test_table_csv_json_and_picture_hold_the_same_points(case: str, tmp_path: Path, capsys) -> None:
    table, values, picture = (tmp_path / name for name in ("front.csv", "front.json", "front.png"))
    arguments = ["--points", "3", "--objective", "jerk", "--output", str(table), "--json", str(values)]
    assert run(["pareto", case, *arguments, "--plot", str(picture)]) == 0
    shown = capsys.readouterr()
    rows = list(csv.DictReader(table.open()))
    points = json.loads(values.read_text())["points"]
    assert len(rows) == len(points) == 3
    for row, point in zip(rows, points):
        assert float(row["duration"]) == point["duration"]
        assert float(row["jerk"]) == point["value"]
        assert (row["feasible"], row["dominated"], row["status"]) == ("true", "false", "converged")
        assert point["result"]["case"] == "small"
        assert f"{point['duration']:.4f}" in shown.out
    assert shown.err.count(", feasible") == 3
    assert "[3/3] within" in shown.err
    image = matplotlib.image.imread(picture)
    blue = (np.abs(image[..., :3] - np.array([0x00, 0x72, 0xB2]) / 255) < 0.02).all(axis=-1)
    assert blue.sum() > 100  # the points are drawn


def test_json_on_standard_output_is_nothing_but_json(case: str, capsys) -> None:
    assert run(["pareto", case, "--points", "2", "--objective", "acceleration", "--json", "-"]) == 0
    shown = capsys.readouterr()
    assert json.loads(shown.out)["quantity"] == "acceleration"
    assert "efficient" in shown.err


@pytest.mark.parametrize("ending", [".svg", ".pdf"])
def test_pictures_come_in_other_formats(case: str, ending: str, tmp_path: Path) -> None:
    picture = tmp_path / f"front{ending}"
    assert run(["pareto", case, "--points", "2", "--objective", "jerk", "--plot", str(picture)]) == 0
    assert picture.stat().st_size > 1000


def test_a_case_without_any_motion_leaves_with_1_and_its_reason(case: str, tmp_path: Path, capsys) -> None:
    table = tmp_path / "front.csv"
    wrong = ["--set", "limits.velocity=0.0", "--objective", "jerk", "--output", str(table)]
    assert run(["pareto", case, *wrong, "--plot", str(tmp_path / "front.svg")]) == 1
    assert "velocity: joint 1, gap 1: the limit is 0" in capsys.readouterr().out
    assert list(csv.reader(table.open()))[1] == ["1", "", "", "", "false", "false", "infeasible"]


def test_ctrl_c_keeps_the_points_found(case: str, tmp_path: Path, monkeypatch, capsys) -> None:
    from ocp_traj import pareto

    whole = pareto.follow_front

    def stopped(*arguments, **options):
        points = whole(*arguments, **options)
        yield next(points)
        raise KeyboardInterrupt

    monkeypatch.setattr(pareto, "follow_front", stopped)
    table = tmp_path / "front.csv"
    assert run(["pareto", case, "--points", "5", "--objective", "jerk", "--output", str(table)]) == 130
    assert len(list(csv.reader(table.open()))) == 2
    assert "interrupted" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "small weighs time only and has no robot with inertia: choose the second objective"),
        (["--objective", "energy"], "energy needs a robot with inertia"),
        (["--objective", "jerk", "--plot", "front.doc"], "ends in '.doc', expected one of .pdf, .png, .svg"),
        (["--points", "1"], "--points"),
        (["--slowest", "1"], "--slowest"),
        (["--objective", "jerk", "--solver", "magic"], "solver 'magic' is unknown"),
        (["--objective", "jerk", "--points", "2", "--output", "no/such/folder/front.csv"], "cannot write"),
    ],
)
def test_wrong_input_is_one_sentence(case: str, arguments: list[str], sentence: str, capsys) -> None:
    assert run(["pareto", case, *arguments]) == 2
    last = capsys.readouterr().err.strip().splitlines()[-1]
    assert last.startswith("ocp-traj: ")
    assert sentence in last


def test_solve_shows_why_a_task_has_no_answer_once(case: str, capsys) -> None:
    assert run(["solve", case, "--set", "limits.velocity=0.0"]) == 1
    shown = capsys.readouterr().out
    assert shown.count("velocity: joint 1, gap 1: the limit is 0, but the joint must move by 1.") == 1
