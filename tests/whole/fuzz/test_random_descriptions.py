"""Robot descriptions at random through the command line: a result or one sentence, never a traceback."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from helpers.random_urdfs import random_urdf
from ocp_traj.cli.main import run
from ocp_traj.robot import Robot, robot_from_urdf

DEFAULT, ALL = 60, 300
PROCESSES = 3


def seeds() -> list[object]:
    return [
        *range(DEFAULT),
        *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(DEFAULT, ALL)),
    ]


def case_for(path: Path, joints: list[dict[str, dict[str, dict[str, float | None]]]]) -> Path:
    """Write a case that moves every joint within its range."""
    rows = []
    for share in (0.4, 0.6, 0.5):
        row = []
        for joint in joints:
            lower, upper = (joint["limits"]["position"][side] for side in ("lower", "upper"))
            low, high = -1.0 if lower is None else lower, 1.0 if upper is None else upper
            row.append(low + share * (high - low))
        rows.append(row)
    case = path.with_suffix(".toml")
    case.write_text(
        f'schema = 1\nname = "random"\nrobot.urdf = "{path.name}"\nwaypoints.joints = {rows}\n'
        "limits.acceleration = 3.0\nlimits.velocity = 2.0\nspline.virtual_knots = 3\n"
    )
    return case


def one_sentence(text: str) -> bool:
    lines = text.splitlines()
    return len(lines) == 1 and lines[0].startswith("ocp-traj: ") and "Traceback" not in text


def agrees_with_pinocchio(robot: Robot) -> bool:
    q, v, a = np.random.default_rng(0).uniform(-1.0, 1.0, (3, 3, robot.n))
    poses = [(np.array(robot.symbolic.pose()(row)), robot.pose(row)) for row in q]
    same = all(np.allclose(found, expected, atol=1e-9) for found, expected in poses)
    if robot.has_inertia:
        found = np.array(robot.symbolic.inverse_dynamics(q.T, v.T, a.T)).T
        expected = robot.torque(q, v, a)
        same = same and np.allclose(found, expected, rtol=1e-9, atol=1e-9 * max(1.0, np.abs(expected).max()))
    return same


@pytest.mark.parametrize("seed", seeds())
def test_any_description_is_a_robot_or_one_sentence(
    seed: int, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "arm.urdf"
    random_urdf(np.random.default_rng(seed), path)
    status = run(["list", "joints", str(path), "--json"])
    out, err = capfd.readouterr()
    if status == 2:
        assert one_sentence(err), err
        return
    assert status == 0 and err == ""
    joints = json.loads(out)["joints"]
    assert run(["check", str(case_for(path, joints))]) == 0
    out, err = capfd.readouterr()
    assert err == "" and all(joint["name"] in out for joint in joints)
    assert agrees_with_pinocchio(robot_from_urdf(path))


def test_the_random_descriptions_are_arms_and_no_arms(tmp_path: Path) -> None:
    """Neither all refused nor all accepted: otherwise the test above would show nothing."""
    accepted = followers = 0
    for seed in range(DEFAULT):
        random_urdf(np.random.default_rng(seed), tmp_path / "arm.urdf")
        try:
            robot = robot_from_urdf(tmp_path / "arm.urdf")
        except ValueError:
            continue
        accepted += 1
        followers += robot.coupling is not None
    assert 0.3 * DEFAULT < accepted < 0.95 * DEFAULT
    assert followers > 2


@pytest.mark.parametrize("seed", range(PROCESSES))
def test_a_process_of_its_own_ends_with_an_answer(seed: int, tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    random_urdf(np.random.default_rng(1000 + seed), path)
    command = [sys.executable, "-m", "ocp_traj"]
    listed = subprocess.run([*command, "list", "joints", str(path), "--json"], capture_output=True, text=True)
    assert listed.returncode == 0 or (listed.returncode == 2 and one_sentence(listed.stderr))
    if listed.returncode == 0:
        case = case_for(path, json.loads(listed.stdout)["joints"])
        solved = subprocess.run([*command, "solve", str(case)], capture_output=True, text=True, timeout=300)
        assert solved.returncode in (0, 1) or one_sentence(solved.stderr)
        assert "Traceback" not in solved.stderr
