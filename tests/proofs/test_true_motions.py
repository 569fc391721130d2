"""Motions that keep every limit are proved, those a little too fast are not, and the judge agrees."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

import ocp_traj as ot
from helpers.proofs.measure import falsehood, torques
from helpers.proofs.proof_motions import kinematic_motion, torque_motion
from helpers.random_tasks import random_robot
from ocp_traj.audit import audit
from ocp_traj.audit.costs import energy, energy_without_regeneration, jerk_cost, motor_loss, torque_cost
from ocp_traj.exceptions import InputError
from ocp_traj.proofs import NotProved, check, prove
from ocp_traj.proofs.resolve import resolve_task
from ocp_traj.task import Limits, Motor, Objective, TrajectoryTask
from ocp_traj.trajectory import Trajectory

TOO_FAST = 1 - 4e-6
LARGEST_BYTES = 5_000_000


def assert_agreement(task: TrajectoryTask, motion: Trajectory) -> None:
    assert audit(task, motion).feasible
    document = json.loads(json.dumps(prove(task, motion)))
    assert check(document).kind == "motion"
    fast = motion.scaled(TOO_FAST)
    assert not audit(task, fast).feasible
    with pytest.raises(NotProved):
        prove(task, fast)


@pytest.mark.parametrize("seed", range(20))
def test_a_kinematic_motion_is_proved_up_to_its_limit_and_not_beyond(seed: int) -> None:
    assert_agreement(*kinematic_motion(seed))


@pytest.mark.parametrize("seed", [6, 11, 14, 21, 48, 54])
def test_a_motion_at_its_torque_limit_is_proved_and_not_beyond(seed: int) -> None:
    assert_agreement(*torque_motion(seed))


@pytest.mark.parametrize("seed", [21, 37, 54])
def test_a_motion_with_friction_is_proved_up_to_its_torque_limit_and_not_beyond(seed: int) -> None:
    assert_agreement(*torque_motion(seed, friction=5.0))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 500))
def test_any_kinematic_motion_is_proved_up_to_its_limit_and_not_beyond(seed: int) -> None:
    assert_agreement(*kinematic_motion(seed))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 200))
def test_any_motion_at_its_torque_limit_is_proved_and_not_beyond(seed: int) -> None:
    assert_agreement(*torque_motion(seed, friction=float(seed % 2)))


def is_proved(task: TrajectoryTask, motion: Trajectory) -> bool:
    try:
        return bool(prove(task, motion))
    except NotProved:
        return False


def disagreements(seeds: range) -> list[tuple[int, int]]:
    """Return seed and kind of motions that the judge and the checker see differently; four motions of each seed.

    At a limit, too fast by 4e-6, with a coefficient moved so that the piece ends 1e-13 (nothing) or 1e-2 rad away.
    Between them lie jumps that the judge lets pass and the checker, ten times stricter, does not.
    """
    found = []
    for seed in seeds:
        task, motion = kinematic_motion(seed)
        rng = np.random.default_rng(seed)
        motions = [motion, motion.scaled(TOO_FAST)]
        for size in (1e-13, 1e-2):
            coefficients = motion.coefficients.copy()
            piece, joint, power = rng.integers(coefficients.shape)
            coefficients[piece, joint, power] += size / np.diff(motion.breakpoints)[piece] ** power
            motions.append(Trajectory(motion.breakpoints, coefficients, motion.waypoint_times))
        for kind, moved in enumerate(motions):
            if audit(task, moved).feasible != is_proved(task, moved):
                found.append((seed, kind))
    return found


def test_judge_and_checker_agree_on_a_hundred_motions() -> None:
    assert disagreements(range(1000, 1025)) == []


@pytest.mark.long
@pytest.mark.parametrize("first", range(2000, 4500, 25))
def test_judge_and_checker_agree_on_ten_thousand_motions(first: int) -> None:
    assert disagreements(range(first, first + 25)) == []


@pytest.mark.parametrize("case", ot.case_names())
def test_the_answer_to_a_packaged_case_is_proved_whole(case: str) -> None:
    task = ot.load_case(case)
    result = ot.solve(task, "ipopt", seed=0)
    text = json.dumps(prove(task, result.trajectory))
    assert len(text) < LARGEST_BYTES
    document = json.loads(text)
    assert case in check(document).statement
    claim = document["claim"]
    assert float.fromhex(claim["duration"]) == pytest.approx(result.duration, rel=1e-14)
    total = sum(weight * float.fromhex(claim["costs"][name]) for name, weight in task.objective.weights.items())
    value = ot.objective_value(task, result.trajectory)
    assert value * (1 - 1e-9) <= total <= value * (1 + 1e-6)


def test_a_torque_rate_on_its_limit_is_proved_where_friction_changes_sign() -> None:
    for seed in (21, 54, 10):
        document = prove(*torque_motion(seed, friction=1.0, rate=True))
        assert "torque_rate" in document["task"]["limits"] and not falsehood(document)


def test_costs_are_bounded_from_above_and_closely() -> None:
    weights = {"energy": 1.0, "energy_without_regeneration": 1.0, "torque": 1.0, "motor_loss": 1.0, "jerk": 1.0}
    for seed, friction in ((11, 0.0), (56, 4.0)):
        task, motion = torque_motion(seed, friction=friction)
        motor = Motor(torque_constant=0.1, resistance=0.5, gear_ratio=100.0)
        task = task.changed(objective=Objective(**weights, motor=motor))
        claimed = {name: float.fromhex(cost) for name, cost in prove(task, motion)["claim"]["costs"].items()}
        true = {
            "energy": energy(task, motion),
            "energy_without_regeneration": energy_without_regeneration(task, motion),
            "torque": torque_cost(task, motion),
            "motor_loss": motor_loss(task, motion),
            "jerk": jerk_cost(motion),
        }
        assert set(claimed) == set(weights)
        for name, value in true.items():
            assert value is not None
            assert value * (1 - 1e-8) <= claimed[name] <= value * (1 + 3e-6), name


def test_links_in_a_proof_give_the_torques_of_the_robot() -> None:
    for seed in range(8):
        robot = random_robot(seed, friction=1.0)
        task = TrajectoryTask(np.zeros((2, robot.n)), Limits(torque=1e6), robot)
        numbers: dict[str, Any] = resolve_task(task)["robot"]
        q, v, a = np.random.default_rng(seed).normal(size=(3, robot.n))
        coulomb = robot.friction.coulomb * np.sign(v)
        expected = robot.torque(q, v, a)[0]
        assert torques(numbers, q, v, a) + coulomb == pytest.approx(expected, rel=1e-10, abs=1e-9)


def test_a_payload_changes_what_is_proved() -> None:
    task, motion = torque_motion(54)
    assert task.robot is not None
    loaded = task.robot.with_changes(payload=ot.Payload(5.0, [0.1, 0.0, 0.3]))
    with pytest.raises(NotProved, match="torque of joint"):
        prove(task.changed(robot=loaded), motion)


def test_what_proofs_do_not_cover_is_said() -> None:
    task, motion = kinematic_motion(0)
    robot = ot.load_robot("ur5")
    points = np.zeros((2, 6))
    covered = TrajectoryTask(points, Limits(cartesian_speed=(("tool0", 1.0),)), robot)
    with pytest.raises(NotProved, match="speed limit of frame 'tool0'"):
        resolve_task(covered)
    with pytest.raises(InputError, match="joints, expected"):
        prove(TrajectoryTask(np.zeros((2, task.n + 1)), Limits(velocity=1.0)), motion)


def test_a_turn_within_an_instant_is_refused() -> None:
    limits = Limits(velocity=1.0, acceleration=10.0)
    task = TrajectoryTask(np.array([[0.0], [0.0]]), limits, boundary=ot.Boundary(velocity=[[0.0], [0.0]]))
    tiny, rise = 2.0**-47, 0.0625
    pieces = [[[0.0, 0.0, 4.0]], [[0.015625, 0.5, -0.5 / tiny]], [[0.015625, -0.5, 4.0]]]
    times = np.array([0.0, rise, rise + tiny, 2 * rise + tiny])
    turn = Trajectory(times, np.array(pieces), times[[0, -1]])
    with pytest.raises(NotProved, match="acceleration of joint 1"):
        prove(task, turn)


def test_equal_waypoints_may_be_passed_at_one_instant() -> None:
    document = prove(*kinematic_motion(0))
    for rows in (document["task"]["waypoints"], document["task"]["tolerance"], document["motion"]["waypoint_times"]):
        rows.insert(1, rows[0])
    for rows in (*document["task"]["limits"].values(), document["task"]["gap_durations"]):
        rows.insert(0, rows[0])
    assert check(document).kind == "motion"
