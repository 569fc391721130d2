"""What leaves for a controller: audited, named as the robot names its joints, refused where it must not move."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import yaml

from helpers.small_tasks import ARM
from ocp_traj.audit import audit
from ocp_traj.case import carried_task, load_case
from ocp_traj.cli.main import run
from ocp_traj.spline.hermite import hermite_pieces
from ocp_traj.task import Boundary, Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.trajectory_files import read_json, write_json

CASE = """
schema = 1
name = "my-case"
[robot]
urdf = "arm.urdf"
[waypoints]
joints = [[0.0, 0.0, 0.0], [0.6, -0.5, 0.1], [1.0, 0.3, 0.2]]
[limits]
acceleration = 6.0
jerk = 90.0
"""


@pytest.fixture(scope="module", name="folder")
def make_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result and a motion of a case of one's own; case and robot are gone."""
    folder = tmp_path_factory.mktemp("own")
    (folder / "arm.urdf").write_text(ARM)
    (folder / "my-case.toml").write_text(CASE)
    files = ["--json", str(folder / "r.json"), "--output", str(folder / "motion.csv"), "--rate", "100"]
    assert run(["solve", str(folder / "my-case.toml"), *files]) == 0
    (folder / "arm.urdf").unlink()
    (folder / "my-case.toml").unlink()
    return folder


def complaint(capsys: pytest.CaptureFixture[str], arguments: Sequence[str]) -> str:
    capsys.readouterr()
    assert run(list(arguments)) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    return lines[0]


@pytest.mark.parametrize("file", ["r.json", "motion.csv", "motion.spline.json"])
def test_a_goal_for_ros2_names_the_joints_of_the_robot_and_keeps_its_limits(
    folder: Path, file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    target = folder / "goal.yaml"
    assert run(["export", str(folder / file), "--format", "ros2", "--output", str(target)]) == 0
    assert "audited as written: every limit is kept" in capsys.readouterr().err
    goal = yaml.safe_load(target.read_text())["trajectory"]
    assert goal["joint_names"] == ["swing", "turn", "push"]
    q, v, a = (
        np.array([point[name] for point in goal["points"]])
        for name in ("positions", "velocities", "accelerations")
    )
    stamps = [point["time_from_start"] for point in goal["points"]]
    t = np.array([stamp["sec"] + 1e-9 * stamp["nanosec"] for stamp in stamps])
    task = carried_task(folder / "r.json")
    assert task is not None
    verdict = audit(task, Trajectory(t, hermite_pieces(t, q, v, a), t[[0, -1]], "quintic"))
    assert not any(peak.broken for peak in verdict.limits.values()), verdict


def test_plot_audit_and_reference_need_no_case(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = str(folder / "r.json")
    assert run(["plot", result, "--picture", "limits", "--output", str(folder / "limits.svg")]) == 0
    for given in (["--result", result], ["--trajectory", str(folder / "motion.csv")]):
        report = folder / "audit.json"
        assert run(["audit", *given, "--json", str(report)]) == 0
        found = json.loads(report.read_text())
        assert found["case"] == "my-case" and found["worst"] == json.loads(Path(result).read_text())["worst"]
    assert run(["audit", "--result", result, "--set", "limits.velocity=0.1"]) == 1
    assert run(["check", result]) == 0
    assert "my-case" in capsys.readouterr().out
    assert load_case(result).robot is not None


def moving(folder: Path) -> tuple[list[str], str]:
    task = carried_task(folder / "r.json", overrides=["boundary.velocity=[[0, 0, 0], [0.5, 0, 0]]"])
    assert task is not None
    t = np.array([0.0, 2.0, 4.0])
    v = np.zeros((3, 3))
    v[2, 0] = 0.5
    motion = Trajectory(t, hermite_pieces(t, task.waypoints, v, np.zeros((3, 3))), t, "quintic", "my-case")
    write_json(folder / "moving.json", motion, task)
    return [str(folder / "moving.json")], "the motion ends moving, joint 1 at 0.5 rad/s (m/s)"


def infeasible(folder: Path) -> tuple[list[str], str]:
    return [str(folder / "r.json"), "--set", "limits.velocity=0.1"], "the motion is not feasible (velocity: joint 1"


@pytest.mark.parametrize("make", [moving, infeasible])
@pytest.mark.parametrize("kind", ["ros2", "urscript"])
def test_what_must_not_be_sent_is_refused_unless_forced(
    folder: Path, make: object, kind: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from ocp_traj import controller_files

    if kind == "urscript":  # an arm of six joints for the program: the same motion beside itself
        program = controller_files.to_urscript
        monkeypatch.setattr(controller_files, "to_urscript", lambda motion, *a, **b: program(doubled(motion), *a, **b))
    arguments, reason = make(folder)  # type: ignore[operator]
    target = folder / f"sent-{kind}"
    command = ["export", *arguments, "--format", kind, "--output", str(target)]
    said = complaint(capsys, command)
    assert reason in said and "expected --force" in said
    assert not target.exists()
    assert run([*command, "--force"]) == 0
    written = capsys.readouterr().err
    assert f"forced: {reason}" in written and "limits are kept" not in written and "audited" not in written
    assert target.read_text()
    target.unlink()


def doubled(motion: Trajectory) -> Trajectory:
    coefficients = np.concatenate([motion.coefficients, motion.coefficients], axis=1)
    return Trajectory(motion.breakpoints, coefficients, motion.waypoint_times, motion.family, motion.case)


def test_a_program_that_starts_at_rest_is_no_place_for_a_motion_that_starts_moving(folder: Path) -> None:
    from ocp_traj.controller_files import objections

    task = carried_task(folder / "r.json")
    assert task is not None
    motion = read_json(folder / "r.json")
    t = motion.waypoint_times[1:]
    assert objections(motion, task) == objections(motion, task, starts_at_rest=True) == []
    later = Trajectory(t, hermite_pieces(t, motion(t), motion(t, 1), motion(t, 2)), t, "quintic")
    rest = TrajectoryTask(motion(t), Limits(velocity=9.0), boundary=Boundary(motion(t, 1), None))
    assert not any("starts" in found for found in objections(later, rest))
    assert any("the motion starts moving, joint" in found for found in objections(later, rest, starts_at_rest=True))


def test_a_motion_whose_robot_has_no_names_is_refused(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    task = load_case("yu-2025-four-points")
    from ocp_traj.transcription import initial_guess

    write_json(tmp_path / "m.json", initial_guess(task), task)
    for kind in ("ros2", "urscript"):
        said = complaint(capsys, ["export", str(tmp_path / "m.json"), "--format", kind])
        assert "has no robot that names its joints, expected --case or --joint-names" in said


@pytest.mark.parametrize("kind", ["ioh", "coco"])
def test_a_comparison_leaves_as_logs_for_analysers(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = tmp_path / "small.toml"
    case.write_text(CASE.replace('[robot]\nurdf = "arm.urdf"\n', "").replace("jerk", "velocity"))
    out = tmp_path / "out"
    arguments = ["--solvers", "random", "--budget", "100", "--seeds", "1", "--no-references"]
    assert run(["compare", str(case), *arguments, "--output", str(out)]) == 0
    capsys.readouterr()
    assert run(["export", str(out), "--format", kind]) == 0
    folder = Path(capsys.readouterr().out.strip())
    assert folder == out / f"{kind}-logs"
    assert (folder / "functions.csv").is_file() and any(folder.glob("random/**/*"))
    stored = json.loads(next((out / "trajectories").glob("*.json")).read_text())
    assert stored["task"]["name"] == "my-case"
    case.unlink()
    assert run(["report", str(out)]) == 0
    assert "cannot be read any more" not in (out / "report.md").read_text()
