"""Every named robot against Pinocchio's own algorithms."""

from __future__ import annotations

import pickle
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest

from ocp_traj.exceptions import RobotError, UnknownNameError
from ocp_traj.robot import Robot, load_robot, robot_names
from ocp_traj.robot.packaged import data_folder

STATES = 200
NAMES = robot_names()


@pytest.fixture(params=NAMES)
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(request.param)


def random_states(n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.uniform(-np.pi, np.pi, (STATES, n)), *rng.uniform(-5.0, 5.0, (2, STATES, n))


def test_the_promised_names_are_there() -> None:
    promised = {"ur3", "ur5", "ur10", "panda", "kinova", "talos-arm", "xarm7", "z1"}
    assert promised <= set(NAMES)


def test_inverse_dynamics_equals_pinocchio_rnea(robot: Robot) -> None:
    q, v, a = random_states(robot.n)
    data = robot.model.createData()
    expected = np.array([pin.rnea(robot.model, data, *state) for state in zip(q, v, a, strict=True)])
    found = np.array(robot.symbolic.inverse_dynamics(q.T, v.T, a.T)).T
    assert np.max(np.abs(found - expected) / np.maximum(1.0, np.abs(expected))) < 1e-10


def test_inverse_dynamics_jacobians_equal_pinocchio_derivatives(robot: Robot) -> None:
    q, v, a = random_states(robot.n, seed=1)
    symbols = robot.symbolic.inverse_dynamics.sx_in()
    tau = robot.symbolic.inverse_dynamics(*symbols)
    jacobians = ca.Function("J", symbols, [ca.jacobian(tau, symbol) for symbol in symbols])
    data = robot.model.createData()
    for state in zip(q, v, a, strict=True):
        by_q, by_v, by_a = pin.computeRNEADerivatives(robot.model, data, *state)
        by_a = np.triu(by_a) + np.triu(by_a, 1).T  # only the upper triangle is promised
        for found, expected in zip(jacobians(*state), (by_q, by_v, by_a), strict=True):
            error = np.abs(np.array(found) - expected) / np.maximum(1.0, np.abs(expected))
            assert np.max(error) < 1e-10


def test_forward_kinematics_equals_pinocchio_in_every_frame(robot: Robot) -> None:
    q, _, _ = random_states(robot.n, seed=2)
    frames = sorted({frame.name for frame in robot.model.frames if frame.type == pin.FrameType.BODY})
    data = robot.model.createData()
    for name in frames:
        pose = robot.symbolic.pose(name)
        index = next(
            i for i, f in enumerate(robot.model.frames) if f.name == name and f.type == pin.FrameType.BODY
        )
        for position in q[:: 1 if name == robot.tool else 100]:
            pin.framesForwardKinematics(robot.model, data, position)
            expected = data.oMf[index].homogeneous
            assert np.max(np.abs(np.array(pose(position)) - expected)) < 1e-10
            assert np.max(np.abs(robot.pose(position, name) - expected)) < 1e-12


def test_frame_velocity_equals_pinocchio(robot: Robot) -> None:
    q, v, _ = random_states(robot.n, seed=3)
    velocity = robot.symbolic.velocity()
    data = robot.model.createData()
    joint, placement = robot.frame_placement()
    for position, rate in zip(q[:20], v[:20], strict=True):
        pin.forwardKinematics(robot.model, data, position, rate)
        carrier = data.oMi[joint].act(data.v[joint])
        point = (data.oMi[joint].homogeneous @ placement)[:3, 3]
        expected = carrier.linear + np.cross(carrier.angular, point)
        np.testing.assert_allclose(np.array(velocity(position, rate)).ravel(), expected, atol=1e-10)


def test_array_program_equals_the_interpreter_bit_by_bit(robot: Robot) -> None:
    q, v, a = random_states(robot.n, seed=4)
    expected = np.array(robot.symbolic.inverse_dynamics(q.T, v.T, a.T)).T
    np.testing.assert_array_max_ulp(robot.batch.torque(q, v, a), expected, maxulp=0)


def test_the_reference_torque_agrees_with_the_batch(robot: Robot) -> None:
    q, v, a = random_states(robot.n, seed=5)
    np.testing.assert_allclose(robot.torque(q, v, a), robot.batch.torque(q, v, a), rtol=1e-10, atol=1e-10)


def test_a_robot_survives_pickling(robot: Robot) -> None:
    copy = pickle.loads(pickle.dumps(robot))
    assert copy == robot
    assert copy.digest() == robot.digest()
    assert not copy.position_limits.flags.writeable


def test_every_configuration_has_one_number_a_joint(robot: Robot) -> None:
    assert robot.model.nq == robot.model.nv == robot.n == len(robot.joint_types)
    continuous = [kind == "continuous" for kind in robot.joint_types]
    assert np.all(np.isinf(robot.position_limits[:, continuous]))
    assert robot.has_inertia


def test_ur3_has_its_own_rated_torques_and_not_those_of_the_ur10() -> None:
    assert load_robot("ur3").torque_limits[1].tolist() == [56.0, 56.0, 28.0, 12.0, 12.0, 12.0]
    assert load_robot("ur10").torque_limits[1].tolist() == [330.0, 330.0, 150.0, 54.0, 54.0, 54.0]


def test_panda_and_z1_have_locked_fingers() -> None:
    assert load_robot("panda").n == 7
    assert load_robot("z1").n == 6


def test_locking_keeps_the_mass_of_what_is_locked() -> None:
    robot = load_robot("panda")
    hand = 0.73 + 2 * 0.015
    assert robot.model.inertias[7].mass == pytest.approx(0.735522 + hand, abs=1e-6)


def test_digests_differ_between_robots() -> None:
    digests = [load_robot(name).digest() for name in NAMES]
    assert len(set(digests)) == len(digests)


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match=r"robot 'ur6' is unknown.*ur5"):
        load_robot("ur6")


def test_missing_robot_data_says_where_it_looked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OCP_TRAJ_ROBOT_DATA", "nowhere/at/all")
    with pytest.raises(RobotError, match=r"nowhere/at/all.*pip install example-robot-data"):
        load_robot("ur5")


def test_robot_data_is_found_in_condas_share_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> metadata.Distribution:
        raise metadata.PackageNotFoundError(name)

    folder = tmp_path / "share" / "example-robot-data" / "robots"
    folder.mkdir(parents=True)
    monkeypatch.setattr(metadata, "distribution", missing)
    monkeypatch.setattr(sys, "path", [str(tmp_path / "site-packages")])
    monkeypatch.setenv("CONDA_PREFIX", str(tmp_path))
    assert data_folder() == folder
    folder.rmdir()
    with pytest.raises(RobotError, match=r"the robot data is in none of .*conda-forge"):
        data_folder()


def test_listing_robots_loads_neither_pinocchio_nor_casadi() -> None:
    code = (
        "import sys; from ocp_traj.robot import robot_names; assert robot_names(); "
        "print([m for m in sys.modules if m.split('.')[0] in ('pinocchio', 'casadi')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
