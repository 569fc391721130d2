"""Robot descriptions at random through the command line: a result or one sentence, never a traceback."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ocp_traj.cli.main import run
from ocp_traj.robot import Robot, robot_from_urdf

DEFAULT, ALL = 60, 300
PROCESSES = 3

TYPES = ("revolute", "continuous", "prismatic", "fixed", "planar", "floating", "ball")
SHARES = (0.5, 0.14, 0.14, 0.17, 0.02, 0.02, 0.01)
AXES = ("0 0 1", "0 0 -1", "0 -1 0", "-1 0 0", "1 1 0", "0.3 -0.5 0.8", "0 0 2", "1e-3 0 1", "0 0 0", "0 1", "x y z")
AXIS_SHARES = (0.25, 0.15, 0.1, 0.1, 0.1, 0.15, 0.05, 0.07, 0.01, 0.01, 0.01)
NAMES = ("arm", "gelenk-ä", "ée", "関節", "a b", "q&amp;a", "universe", "joint.1")


def random_urdf(rng: np.random.Generator, path: Path) -> None:
    """Write one description; about half of them are arms, the others wrong in one way or several."""
    wrong = 0.04 if rng.random() < 0.5 else 0.0
    count = int(rng.integers(1, 9))
    prefix = str(rng.choice(NAMES)) if rng.random() < 0.3 else "l"
    parts = [_link(rng, f"{prefix}0", wrong)]
    for index in range(1, count + 1):
        parent = index - 1 if rng.random() < 0.8 else int(rng.integers(0, index))
        parts += [_link(rng, f"{prefix}{index}", wrong), _joint(rng, index, f"{prefix}{parent}", prefix, wrong)]
    if rng.random() < 0.15:
        parts += _fixed_chain(int(rng.choice([5, 60, 5000])), f"{prefix}{count}")
    if rng.random() < 0.2:
        parts += _fingers(f"{prefix}{count}")
    rng.shuffle(parts)
    encoding = "latin-1" if rng.random() < 0.25 else "utf-8"
    declared = rng.random() < 0.5
    head = f'<?xml version="1.0" encoding="{encoding if declared else "utf-8"}"?>' if rng.random() < 0.7 else ""
    text = f'{head}<robot name="random">{"".join(parts)}</robot>'
    content = text.encode(encoding, errors="xmlcharrefreplace")
    if rng.random() < wrong:
        content = content[: int(rng.integers(0, len(content)))]
    path.write_bytes(content)


def _kept(rng: np.random.Generator, text: str, missing: float) -> str:
    return "" if rng.random() < missing else text


def _number(rng: np.random.Generator, value: float, wrong: float) -> str:
    if rng.random() < wrong:
        return str(rng.choice(["nan", "inf", "", "1,5", "-1", "1e400", "0"]))
    return f"{value:.6g}"


def _link(rng: np.random.Generator, name: str, wrong: float) -> str:
    if rng.random() < 0.15:
        return f'<link name="{name}"/>'
    moments = "".join(
        _kept(rng, f'{axis}="{_number(rng, value, wrong)}" ', wrong)
        for axis, value in zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), (0.02, 0.03, 0.04, 0.001, 0.0, 0.0))
    )
    inside = (
        _kept(rng, '<origin xyz="0.01 0 0.1" rpy="0.1 0 0"/>', 0.3)
        + _kept(rng, f'<mass value="{_number(rng, rng.uniform(0.1, 3.0), wrong)}"/>', wrong)
        + _kept(rng, f"<inertia {moments}/>", wrong)
    )
    return f'<link name="{name}"><inertial>{inside}</inertial><visual/><collision><geometry/></collision></link>'


def _joint(rng: np.random.Generator, index: int, parent: str, prefix: str, wrong: float) -> str:
    kind = str(rng.choice(TYPES[:6] if not wrong else TYPES, p=_normed(SHARES[:6] if not wrong else SHARES)))
    axis = str(rng.choice(AXES if wrong else AXES[:8], p=_normed(AXIS_SHARES if wrong else AXIS_SHARES[:8])))
    low, high = sorted(rng.uniform(-3.0, 3.0, 2))
    if rng.random() < 0.15:
        low = high = 0.0
    if rng.random() < wrong:
        low, high = high + 1.0, low
    numbers = {
        "lower": low,
        "upper": high,
        "effort": 0.0 if rng.random() < 0.2 else 50.0,
        "velocity": 0.0 if rng.random() < 0.2 else 2.0,
    }
    if rng.random() < 0.2:
        numbers.update(acceleration=5.0, jerk=60.0)
    attributes = "".join(
        _kept(rng, f' {name}="{_number(rng, value, wrong)}"', 0.05) for name, value in numbers.items()
    )
    mimic = ""
    if index > 1 and rng.random() < 0.12:
        leader = int(rng.integers(1, index + (rng.random() < wrong)))
        mimic = f'<mimic joint="j{leader}" multiplier="{rng.uniform(-2, 2):.3g}" offset="0.1"/>'
    return (
        f'<joint name="j{index}" type="{kind}">'
        + _kept(rng, f'<parent link="{parent}"/>', 0.5 * wrong)
        + _kept(rng, f'<child link="{prefix}{index}"/>', 0.5 * wrong)
        + _kept(rng, f'<origin xyz="0 {rng.uniform(-0.2, 0.2):.4g} 0.3" rpy="0 {rng.uniform(-2, 2):.4g} 1"/>', 0.1)
        + _kept(rng, f'<axis xyz="{axis}"/>', 0.1)
        + _kept(rng, f"<limit{attributes}/>", 0.1)
        + f"{mimic}</joint>"
    )


def _normed(shares: tuple[float, ...]) -> list[float]:
    return [share / sum(shares) for share in shares]


def _fixed_chain(length: int, start: str) -> list[str]:
    names = [start, *(f"c{number}" for number in range(length))]
    return [
        f'<link name="{below}"/><joint name="to_{below}" type="fixed">'
        f'<parent link="{above}"/><child link="{below}"/></joint>'
        for above, below in zip(names, names[1:])
    ]


def _fingers(hand: str) -> list[str]:
    return [
        f'<link name="{name}"/><joint name="{name}_joint" type="prismatic">'
        f'<parent link="{hand}"/><child link="{name}"/>'
        f'<axis xyz="0 {sign} 0"/><limit lower="0" upper="0.04" effort="20" velocity="0.2"/>{mimic}</joint>'
        for name, sign, mimic in (("finger_1", 1, ""), ("finger_2", -1, '<mimic joint="finger_1_joint"/>'))
    ]


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
