"""The task that travels with a result: JSON that gives the same task, the same digest and the same verdict."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ocp_traj as ot
from helpers.small_tasks import ARM
from ocp_traj.case import carried_task, case_names, load_case, task_digest, task_from_json, task_to_json
from ocp_traj.exceptions import CaseError
from ocp_traj.robot import Friction, Payload, robot_from_urdf
from ocp_traj.task import Boundary, CustomObjective, Limits, Motor, Objective, Search, TrajectoryTask
from ocp_traj.trajectory_files import write_json
from ocp_traj.transcription import initial_guess


def through_text(task: TrajectoryTask) -> TrajectoryTask:
    """Return the task that its JSON text, strict about infinities, gives."""
    return task_from_json(json.loads(json.dumps(task_to_json(task), allow_nan=False)), "task.json")


@pytest.fixture(name="arm")
def make_arm(tmp_path: Path) -> ot.Robot:
    path = tmp_path / "arm.urdf"
    path.write_text(ARM)
    return robot_from_urdf(path)


@pytest.mark.parametrize("name", case_names())
def test_every_packaged_case_comes_back(name: str) -> None:
    task = load_case(name)
    assert task_digest(through_text(task)) == task_digest(task)
    assert through_text(task).title == task.title


def test_a_robot_of_a_file_travels_as_its_chain_and_its_file_may_be_gone(arm: ot.Robot, tmp_path: Path) -> None:
    standing = arm.with_changes(
        tool="tip",
        base="base",
        gravity=[0.0, 9.81, 0.0],
        payload=Payload(1.0, np.array([0.0, 0.0, 0.1]), np.array([0.01, 0.01, 0.01, 0.0, 0.0, 0.0])),
        friction=Friction(np.array([0.1, 0.2, 0.3]), np.array([0.4, 0.5, 0.6])),
    )
    points = [[0.0, 0.0, 0.0], [1.0, 2.0, 0.2], [0.5, -1.0, 0.1]]
    task = TrajectoryTask(points, Limits(acceleration=5.0, jerk=60.0), standing, name="arm")
    data = task_to_json(task)
    (tmp_path / "arm.urdf").unlink()
    back = task_from_json(json.loads(json.dumps(data, allow_nan=False)), "task.json")
    assert back.robot is not None
    assert task_digest(back) == task_digest(task)
    assert back.robot.joint_names == ("swing", "turn", "push")
    assert back.robot.joint_types == ("revolute", "continuous", "prismatic")
    joint = data["robot"]["chain"]["joints"][1]
    assert (joint["type"], joint["parent"], joint["position"]) == ("continuous", 1, [None, None])
    motion = initial_guess(task)
    before, after = ot.audit(task, motion), ot.audit(back, motion)
    assert after.feasible == before.feasible
    assert {name: peak.ratio for name, peak in after.limits.items()} == pytest.approx(
        {name: peak.ratio for name, peak in before.limits.items()}, rel=1e-12
    )


def test_a_named_robot_that_was_changed_by_hand_travels_as_its_chain() -> None:
    named = ot.load_robot("ur5")
    slower = replace(named, velocity_limits=0.5 * named.velocity_limits)
    points = np.array([[0.0] * 6, [0.5] * 6])
    for robot, key in ((named, "model"), (named.with_changes(tool="base_link"), "model"), (slower, "chain")):
        task = TrajectoryTask(points, Limits(acceleration=3.0), robot)
        data = task_to_json(task)
        assert data is not None and key in data["robot"]
        assert task_digest(through_text(task)) == task_digest(task)


@pytest.mark.parametrize(
    "changes",
    [
        {"limits": Limits(velocity=[[-1.0, -np.inf], [np.inf, 2.0]], jerk=[np.inf, 4.0])},
        {"limits": Limits(position=np.array([[[-9.0, -9.0], [9.0, np.inf]], [[-5.0, -9.0], [9.0, 4.0]]]))},
        {"objective": Objective(jerk=0.5, duration=(1.0, np.inf), gap_durations=[[0.0, np.inf], [0.5, 2.0]])},
        {"boundary": Boundary(velocity=[[0.1, 0.0], [0.0, 0.2]], acceleration=None, jerk=0.0)},
        {"boundary": Boundary(acceleration=[[0.1, 0.0], [0.0, 0.2]]), "family": "quintic"},
        {"search": Search((0.1, 3.0), "per-joint"), "tolerance": [[0.0, 0.0], [0.1, 0.2], [0.0, 0.0]]},
        {"name": "a name: with <signs>", "title": "t", "source": "s", "virtual_knots": 5},
        {"objective": Objective(acceleration=2.0)},
    ],
)
def test_what_a_task_may_hold_comes_back(changes: dict[str, Any]) -> None:
    points = [[0.0, 0.0], [1.0, 0.5], [2.0, 0.0]]
    task = TrajectoryTask(points, **{"limits": Limits(velocity=2.0, acceleration=5.0), **changes})
    back = through_text(task)
    assert task_digest(back) == task_digest(task)
    assert (back.name, back.title, back.source) == (task.name, task.title, task.source)


def test_no_limit_is_null_and_a_limit_of_the_robot_is_written_out() -> None:
    task = load_case("ur5-torque-limited")
    data = task_to_json(task)
    assert data is not None
    assert data["limits"]["torque_rate"] is None
    assert np.shape(data["limits"]["torque"]) == (2, 6)


def test_motors_come_back(arm: ot.Robot) -> None:
    motor = Motor(np.full(3, 0.5), np.full(3, 2.0), np.full(3, 10.0))
    task = TrajectoryTask([[0.0] * 3, [0.2] * 3], robot=arm, objective=Objective(motor_loss=1.0, motor=motor))
    assert task_digest(through_text(task)) == task_digest(task)


def test_functions_of_ones_own_do_not_travel() -> None:
    import casadi as ca

    q, v, a, tau = (ca.SX.sym(name, 1) for name in ("q", "v", "a", "tau"))
    custom = CustomObjective("own", ca.Function("own", [q, v, a, tau], [q**2]), 1.0)
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=1.0), objective=Objective(custom=(custom,)))
    assert task_to_json(task) is None


def test_overrides_reach_into_the_task_that_travels(tmp_path: Path) -> None:
    task = load_case("yu-2025-four-points")
    motion = ot.trajectory_from_durations(task, np.ones(task.gaps))
    write_json(tmp_path / "m.spline.json", motion, task)
    changed = load_case(tmp_path / "m.spline.json", ["limits.velocity=1.5"])
    assert changed.limits.get("velocity").max() == 1.5
    assert task_digest(load_case(str(tmp_path / "m.spline.json"))) == task_digest(task)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ("[1, 2", "is no JSON"),
        ('{"schema": 1}', "carries no task"),
        ('{"task": null}', "carries no task"),
        ('{"task": [1]}', "holds a list, expected an object"),
        ('{"task": {"schema": 1}}', "name: missing"),
        ('{"task": {"schema": 1, "name": "x", "waypoints": {"joints": [[0], [1]]}, "bogus": 1}}', "bogus: unknown"),
        (
            '{"task": {"schema": 1, "name": "x", "waypoints": {"joints": [[0], [1]]}, "limits": {"velocity": "x"}}}',
            "limits.velocity: the text 'x' given",
        ),
    ],
)
def test_what_is_no_task_is_refused_with_one_sentence(tmp_path: Path, data: str, message: str) -> None:
    path = tmp_path / "r.json"
    path.write_text(data)
    with pytest.raises(CaseError, match=message):
        load_case(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda chain: chain["joints"][1].update(parent=2), "hangs on joint 2, expected one before it"),
        (lambda chain: chain["joints"][0].update(type="ball"), "type: the text 'ball' given"),
        (lambda chain: chain["joints"][0].update(mass=-1.0), "mass: -1 kg given"),
        (lambda chain: chain["joints"][0].update(rotation=[[1, 0, 0]] * 3), "rotation: is no rotation"),
        (lambda chain: chain["frames"][0].update(joint=9), "carried by joint 9, which does not exist"),
        (lambda chain: chain.update(joints=[]), "needs at least one joint"),
        (lambda chain: chain.update(tool="nothing"), "frame 'nothing' does not exist"),
    ],
)
def test_a_chain_that_cannot_be_is_refused_with_its_key(arm: ot.Robot, change: Any, message: str) -> None:
    task = TrajectoryTask([[0.0] * 3, [0.2] * 3], Limits(acceleration=1.0), arm)
    data = json.loads(json.dumps(task_to_json(task)))
    change(data["robot"]["chain"])
    with pytest.raises(CaseError, match=message):
        task_from_json(data, "r.json")


def test_a_file_without_a_task_carries_none(tmp_path: Path) -> None:
    task = load_case("yu-2025-four-points")
    write_json(tmp_path / "m.json", ot.trajectory_from_durations(task, np.ones(task.gaps)))
    assert carried_task(tmp_path / "m.json") is None
