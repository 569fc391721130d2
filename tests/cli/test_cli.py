"""The command line: light help, the contract's exit statuses, one sentence for wrong input, JSON to the letter."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import click
import numpy as np
import pytest
import yaml

from helpers.processes import interrupt, start_process
from ocp_traj.cli.main import cli, run
from ocp_traj.comparison.runs.store import Store

HEAVY = (
    "casadi",
    "pinocchio",
    "matplotlib",
    "numpy",
    "scipy",
    "pandas",
    "toppra",
    "cvxpy",
    "jinja2",
    "joblib",
)
CASE = """
schema = 1
name = "two-joints"
title = "Two joints, three points"
[waypoints]
joints = [[0.0, 0.0], [1.0, -0.5], [2.0, 0.3]]
[limits]
velocity = 1.0
acceleration = 2.0
[spline]
virtual_knots = 1
[search]
duration = [0.1, 8.0]
"""


@pytest.fixture
def case(tmp_path: Path) -> str:
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    return str(path)


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a case, its solution as CSV and JSON."""
    folder = tmp_path_factory.mktemp("solved")
    (folder / "case.toml").write_text(CASE)
    arguments = [
        "--output",
        str(folder / "motion.csv"),
        "--json",
        str(folder / "result.json"),
        "--rate",
        "200",
    ]
    assert run(["solve", str(folder / "case.toml"), *arguments]) == 0
    return folder


@pytest.mark.parametrize("command", ["", *cli.list_commands(click.Context(cli))])
def test_help_imports_nothing_heavy(command: str) -> None:
    code = (
        "import sys\nfrom ocp_traj.cli.main import run\n"
        f"status = run({[*command.split(), '--help']!r})\n"
        f"print(status, sorted(set({HEAVY!r}) & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "0 []"
    assert "Usage: ocp-traj" in done.stdout


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    import ocp_traj

    assert run(["--version"]) == 0
    assert ocp_traj.__version__ in capsys.readouterr().out


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run a wrong command; return its only line of complaint."""
    assert run(list(arguments)) == 2
    captured = capsys.readouterr()
    lines = captured.err.strip().splitlines()
    assert len(lines) == 1 and "Traceback" not in captured.err
    return lines[0]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["solve", "nowhere.toml"], "nowhere.toml"),
        (["solve", "CASE", "--solver", "magic"], "solver 'magic' is unknown, expected one of ipopt"),
        (["solve", "CASE", "--solver", "ipopt[speed=1]"], "has no setting 'speed'"),
        (["solve", "CASE", "--set", "limits.velocity=-1"], "limits.velocity"),
        (["solve", "CASE", "--set", "waypoints.joints=[[0,0]]"], "waypoints"),
        (["solve", "CASE", "--set", "waypoints.joints=[[0,0],[1]]"], "waypoints"),
        (["solve", "CASE", "--set", "waypoints.joints=[[0,0],[nan,1]]"], "nan"),
        (["solve", "CASE", "--set", "limits.speed=1"], "speed"),
        (["solve", "CASE", "--set", "limits.velocity=[1,2,3]"], "limits.velocity"),
        (["solve", "CASE", "--set", "robot.model=r2d2"], "r2d2"),
        (["solve", "CASE", "--set", "nonsense"], "nonsense"),
        (["solve", "CASE", "--budget", "0"], "--budget"),
        (["solve", "CASE", "--time-limit", "-1"], "--time-limit"),
        (["solve", "CASE", "--frobnicate"], "--frobnicate"),
        (["solve"], "CASE"),
        (["frobnicate"], "frobnicate"),
        (["audit", "CASE"], "exactly one of --durations, --trajectory and --result"),
        (["audit", "CASE", "--durations", "1,x"], "expected numbers with commas between"),
        (["audit", "CASE", "--durations", "1"], "has 1 numbers, expected 2"),
        (["audit", "CASE", "--durations", "1,-2"], "expected positive numbers"),
        (["audit", "CASE", "--durations", "1,inf"], "expected positive numbers"),
        (["audit", "CASE", "--trajectory", "nowhere.csv"], "nowhere.csv"),
        (["audit", "CASE", "--result", "nowhere.json"], "nowhere.json"),
        (["compare", "CASE", "--solvers", "ipopt,ipopt"], "one of its solvers twice"),
        (["compare", "CASE", "CASE"], "twice"),
        (["compare", "CASE", "--solvers", "magic"], "solver 'magic' is unknown"),
        (["compare", "--plan", "nowhere.toml"], "nowhere.toml"),
        (["compare", "CASE", "--jobs", "0"], "--jobs"),
        (["report", "nowhere"], "holds no comparison"),
        (["plot", "nowhere.json"], "nowhere.json"),
        (["export", "nowhere.json", "--format", "csv"], "nowhere.json"),
        (["export", "nowhere.json", "--format", "rosbag"], "rosbag"),
        (["init", "/nowhere/at/all.toml"], "cannot write /nowhere/at/all.toml"),
    ],
)
def test_wrong_input_gives_status_2_and_one_sentence(
    capsys: pytest.CaptureFixture[str], case: str, arguments: list[str], sentence: str
) -> None:
    assert sentence in complaint(capsys, *(case if word == "CASE" else word for word in arguments))


def test_a_motion_of_other_joints_is_refused(capsys: pytest.CaptureFixture[str], solved: Path) -> None:
    message = complaint(capsys, "audit", "fang-2020-task-1", "--result", str(solved / "result.json"))
    assert "the motion has 2 joints, but case fang-2020-task-1 has 6" in message


def test_solve_writes_the_contracts_json(capsys: pytest.CaptureFixture[str], case: str) -> None:
    assert run(["solve", case, "--json", "-"]) == 0
    result = json.loads(capsys.readouterr().out)
    wanted = (
        "schema case solver seed status message feasible objective duration energy segment_durations worst "
    )
    wanted += "evaluations build_time solve_time references trajectory versions"
    assert set(wanted.split()) <= set(result)
    assert (result["case"], result["solver"], result["feasible"], result["energy"]) == (
        "two-joints",
        "ipopt",
        True,
        None,
    )
    assert sum(result["segment_durations"]) == pytest.approx(result["duration"])
    assert result["references"] is None


def test_an_answer_that_breaks_limits_gives_status_1_and_is_written(tmp_path: Path, case: str) -> None:
    target = tmp_path / "result.json"
    assert run(["audit", case, "--durations", "0.1,0.1", "--json", str(target)]) == 1
    verdict = json.loads(target.read_text())
    assert verdict["feasible"] is False and verdict["worst"]["ratio"] > 1
    assert verdict["smallest_feasible_scale"] > 1


def test_solve_without_a_feasible_answer_gives_status_1_and_writes_it(tmp_path: Path, case: str) -> None:
    target = tmp_path / "result.json"
    bounds = "objective.bounds.duration=[0.1, 0.2]"
    assert (
        run(["solve", case, "--set", bounds, "--json", str(target), "--output", str(tmp_path / "m.csv")]) == 1
    )
    assert json.loads(target.read_text())["feasible"] is False


@pytest.mark.parametrize(
    ("solver", "calls"), [("ipopt", r"nlp_f \d+.* nlp_hess_l \d+"), ("random", "evaluate 9")]
)
def test_solve_shows_every_kind_of_call_and_the_encoding(
    capsys: pytest.CaptureFixture[str], case: str, solver: str, calls: str
) -> None:
    run(["solve", case, "--solver", solver, "--budget", "9"])
    assert re.search(rf"calls +{calls}.*; encoding [a-z-]+", capsys.readouterr().out)


def test_the_audit_accepts_what_solve_wrote(solved: Path) -> None:
    case = str(solved / "case.toml")
    assert run(["audit", case, "--result", str(solved / "result.json")]) == 0
    assert run(["audit", case, "--trajectory", str(solved / "motion.csv")]) == 0


def test_audit_json_has_the_contracts_keys(capsys: pytest.CaptureFixture[str], solved: Path) -> None:
    run(["audit", str(solved / "case.toml"), "--result", str(solved / "result.json"), "--json", "-"])
    verdict = json.loads(capsys.readouterr().out)
    wanted = {
        "schema",
        "case",
        "feasible",
        "duration",
        "worst",
        "limits",
        "waypoint_error",
        "smallest_feasible_scale",
    }
    assert wanted <= set(verdict) and verdict["case"] == "two-joints"
    assert set(verdict["limits"]["velocity"]) >= {"joint", "time", "ratio"}


def test_the_csv_has_the_contracts_header(solved: Path) -> None:
    header, *rows = (solved / "motion.csv").read_text().splitlines()
    assert header == "t,q1,q2,v1,v2,a1,a2,j1,j2"
    times = np.array([float(row.split(",")[0]) for row in rows])
    assert np.diff(times)[0] == pytest.approx(1 / 200)
    assert (solved / "motion.spline.json").exists()


def test_init_writes_a_case_that_check_accepts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = str(tmp_path / "mine.toml")
    assert run(["init", target]) == 0
    assert run(["check", target]) == 0
    assert "minimise" in capsys.readouterr().out
    assert "exists already" in complaint(capsys, "init", target)
    assert run(["init", target, "--force"]) == 0


def test_check_reports_every_case_and_fails_for_one(case: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", "nowhere.toml", case]) == 2
    captured = capsys.readouterr()
    assert "two-joints" in captured.out and captured.err.count("\n") == 1


@pytest.mark.parametrize(
    ("what", "name"),
    [("robots", "ur5"), ("solvers", "ipopt"), ("cases", "ur5-palletizing"), ("families", "3-5-3")],
)
def test_list_names_what_is_there(what: str, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["list", what]) == 0
    assert name in capsys.readouterr().out


def test_plot_draws_a_result_and_a_csv(solved: Path) -> None:
    assert run(["plot", str(solved / "result.json"), "--output", str(solved / "m.png")]) == 0
    assert (
        run(["plot", str(solved / "motion.csv"), "--picture", "limits", "--case", str(solved / "case.toml")])
        == 0
    )
    assert (solved / "m.png").exists() and (solved / "motion-limits.png").exists()


def test_a_picture_the_motion_cannot_give_is_refused(
    solved: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "is a motion, expected" in complaint(
        capsys, "plot", str(solved / "result.json"), "--picture", "runtime"
    )
    assert "no tool path" in complaint(capsys, "plot", str(solved / "result.json"), "--picture", "path")


def test_export_for_ros2_keeps_the_limits(solved: Path) -> None:
    target = solved / "goal.yaml"
    arguments = [
        "--format",
        "ros2",
        "--output",
        str(target),
        "--rate",
        "50",
        "--joint-names",
        "one,two",
    ]
    assert run(["export", str(solved / "result.json"), *arguments]) == 0
    points = yaml.safe_load(target.read_text())["trajectory"]["points"]
    times = [point["time_from_start"]["sec"] + 1e-9 * point["time_from_start"]["nanosec"] for point in points]
    assert (np.diff(times) > 0).all()
    assert np.abs([point["velocities"] for point in points]).max() <= 1.0 + 1e-6
    assert np.abs([point["accelerations"] for point in points]).max() <= 2.0 * (1.0 + 1e-6)


def test_export_csv_at_a_rate_can_be_audited(solved: Path) -> None:
    target = solved / "coarse.csv"
    assert (
        run(
            [
                "export",
                str(solved / "result.json"),
                "--format",
                "csv",
                "--rate",
                "25",
                "--output",
                str(target),
            ]
        )
        == 0
    )
    assert run(["audit", str(solved / "case.toml"), "--trajectory", str(target)]) == 0


def test_urscript_is_refused_for_two_joints(solved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--format", "urscript", "--joint-names", "one,two"]
    assert "expected 6" in complaint(capsys, "export", str(solved / "result.json"), *arguments)


def test_reference_writes_the_contracts_json(capsys: pytest.CaptureFixture[str], solved: Path) -> None:
    picture = solved / "references.png"
    arguments = ["--result", str(solved / "result.json"), "--json", "-", "--plot", str(picture)]
    assert run(["reference", str(solved / "case.toml"), *arguments]) == 0
    assert picture.read_bytes()[:4] == b"\x89PNG"
    found = json.loads(capsys.readouterr().out)
    assert {"schema", "case", "kinematic_bound", "toppra", "convex"} <= set(found)
    assert set(found["toppra"]) == {"uniform", "chord", "spline"}


def test_compare_report_plot_and_export_work_together(
    tmp_path: Path, case: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "out"
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'schema = 1\ncases = ["case.toml"]\nsolvers = ["ipopt", "pso[population=20]"]\nseeds = 2\nbudget = 400\n'
    )
    arguments = ["compare", "--plan", str(plan), "--output", str(folder), "--jobs", "2", "--no-references"]
    assert run(arguments) == 0
    first = capsys.readouterr().out
    assert "[4/4]" in first and "feasible" in first
    for name in ("results.sqlite", "report.md", "report.html", "trajectories"):
        assert (folder / name).exists()
    assert run(arguments) == 0
    assert "4 of 4 runs are there already" in capsys.readouterr().out
    assert run(["report", str(folder)]) == 0
    assert run(["plot", str(folder), "--picture", "convergence"]) == 0
    assert run(["export", str(folder), "--format", "csv"]) == 0
    assert (folder / "convergence.png").exists()
    assert len((folder / "results.csv").read_text().splitlines()) == 5
    assert "is a comparison" in complaint(capsys, "plot", str(folder), "--picture", "path")
    assert "is a comparison" in complaint(capsys, "export", str(folder), "--format", "ros2")


def test_ctrl_c_stops_a_comparison_and_keeps_what_is_finished(tmp_path: Path, case: str) -> None:
    folder, plan = tmp_path / "out", tmp_path / "endless.toml"
    plan.write_text(f"schema = 1\ncases = [{case!r}]\nsolvers = ['pso']\nseeds = 50\nbudget = [400, 1000000000]\n")
    arguments = ["--plan", str(plan), "--no-references", "--jobs", "2", "--output", str(folder)]
    process = start_process(
        [sys.executable, "-m", "ocp_traj", "compare", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    first = process.stdout.readline()
    rest, errors = interrupt(process)
    assert process.returncode == 130
    assert "[1/100]" in first and "what is finished is kept" in rest
    assert "Traceback" not in errors
    with Store(folder) as store:
        assert 1 <= len(store.finished()) < 100


def test_check_tells_which_waypoints_are_one_point(capsys):
    folder = Path(__file__).parents[1] / "data" / "faults"
    assert run(["check", str(folder / "dup-middle.toml"), str(folder / "dup-middle-dwell-still.toml")]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "waypoints 2 and 3 are equal: one point, passed once" in said
    assert "waypoints 2 and 3 are equal: two instants" in said


def test_check_refuses_a_spline_with_too_few_points(capsys, tmp_path):
    case = tmp_path / "few.toml"
    case.write_text(
        'schema = 1\nname = "few"\n[waypoints]\njoints = [[0.0], [1.0], [1.0], [2.0]]\n[limits]\nvelocity = 1.0\n'
        '[spline]\nfamily = "3-5-3"\n'
    )
    assert run(["check", str(case)]) == 2
    assert "equal consecutive waypoints are one point" in " ".join(capsys.readouterr().err.split())


def test_published_durations_are_0_between_equal_waypoints(capsys):
    case = str(Path(__file__).parents[1] / "data" / "faults" / "dup-middle.toml")
    assert run(["audit", case, "--durations", "1.5,0,1.5"]) == 0
    assert run(["audit", case, "--durations", "0,1.5,1.5"]) == 2
