"""Closed-form inverse kinematics: exact, complete, and the papers' own formulas."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from ocp_traj.exceptions import RobotError
from ocp_traj.robot import Robot, load_robot, robot_from_dh
from ocp_traj.robot.inverse_kinematics import (
    SIGNS,
    ClosedForm,
    DampedLeastSquares,
    SphericalWrist,
    ThreeParallelAxes,
    inverse_kinematics_of,
)
from ocp_traj.robot.inverse_kinematics.screws import wrap

PAPER_B = {
    "a": [0.0, 0.200, 0.7156, 0.256, 0.0, 0.0],
    "alpha": [0.0, -90.0, 0.0, -90.0, 90.0, -90.0],
    "d": [0.0, 0.0, -0.0944, 0.8455, 0.0, 0.0838],
}
PAPER_D = {
    "a": [0.0, 0.075, 0.840, 0.195, 0.0, 0.0],
    "alpha": [0.0, 90.0, 0.0, 90.0, -90.0, 90.0],
    "d": [0.450, 0.0, 0.0, 1.100, 0.0, 0.075],
}


def dh_robot(name: str) -> Robot:
    table = {"paper-b": PAPER_B, "paper-d": PAPER_D}[name]
    return robot_from_dh("modified", **table, theta=[0.0] * 6, unit="deg", name=name)


def turned_spherical_arm() -> Robot:
    """A spherical-wrist arm with zeros, turning directions and a tool unlike any textbook's."""
    return robot_from_dh(
        "standard",
        a=[0.05, -0.4, 0.03, 0.0, 0.0, 0.1],
        alpha=[90.0, 180.0, -90.0, 90.0, -70.0, 33.0],
        d=[0.3, 0.1, -0.05, 0.45, 0.0, 0.12],
        theta=[10.0, -20.0, 30.0, 40.0, -50.0, 60.0],
        unit="deg",
        name="turned",
    )


ARMS = {
    "ur3": lambda: load_robot("ur3"),
    "ur5": lambda: load_robot("ur5"),
    "ur10-turned-base": lambda: load_robot("ur10").with_changes(base="base", tool="ee_link"),
    "z1": lambda: load_robot("z1"),
    "kinova": lambda: load_robot("kinova"),
    "paper-b": lambda: dh_robot("paper-b"),
    "paper-d": lambda: dh_robot("paper-d"),
    "turned": turned_spherical_arm,
}


@pytest.fixture(params=list(ARMS))
def arm(request: pytest.FixtureRequest) -> ClosedForm:
    inverse = inverse_kinematics_of(ARMS[request.param]())
    assert isinstance(inverse, ClosedForm)
    return inverse


def random_positions(count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, 6))


def poses_of(robot: Robot, q: np.ndarray) -> np.ndarray:
    forward = robot.symbolic.pose()
    return np.array(forward(q.T)).reshape(4, len(q), 4).transpose(1, 0, 2)


def test_every_arm_gets_the_closed_form_of_its_type() -> None:
    for name in ("ur3", "ur5", "ur10", "z1"):
        assert isinstance(inverse_kinematics_of(load_robot(name)), ThreeParallelAxes)
    assert isinstance(inverse_kinematics_of(load_robot("kinova")), SphericalWrist)
    for name in ("paper-b", "paper-d"):
        assert isinstance(inverse_kinematics_of(dh_robot(name)), SphericalWrist)
    for name in ("panda", "talos-arm", "so100"):
        assert isinstance(inverse_kinematics_of(load_robot(name)), DampedLeastSquares)


def test_all_branches_of_1000_poses_close_to_1e_9(arm: ClosedForm) -> None:
    q = random_positions(1000)
    poses = poses_of(arm.robot, q)
    found = arm.branches(poses)
    pose_number, _ = np.nonzero(found.exists)
    reached = poses_of(arm.robot, found.q[found.exists])
    assert np.max(np.abs(reached - poses[pose_number])) < 1e-9
    for index in range(len(poses)):
        branches = found.q[index][found.exists[index]]
        # The position the pose came from is one of them, and no two are the same.
        assert np.min(np.max(np.abs(wrap(branches - q[index])), axis=1)) < 1e-6
        gaps = np.abs(wrap(branches[:, None] - branches[None])).max(axis=-1)
        assert np.min(gaps[~np.eye(len(branches), dtype=bool)]) > 1e-6


def test_angles_lie_within_a_half_turn_of_zero(arm: ClosedForm) -> None:
    found = arm.branches(poses_of(arm.robot, random_positions(50)))
    angles = found.q[found.exists]
    assert np.all((angles > -np.pi) & (angles <= np.pi))


def test_branches_are_complete(arm: ClosedForm) -> None:
    """Whatever damped least squares finds from many starts is one of the branches."""
    free = replace(arm.robot, position_limits=np.array([[-np.inf] * 6, [np.inf] * 6]))
    numeric = DampedLeastSquares(free, starts=40, iterations=40)
    seen = 0
    for q in random_positions(4, seed=5):
        pose = arm.robot.pose(q)
        expected = arm.solve(pose)
        found = numeric.solve(pose)
        distance = np.abs(wrap(found[:, None] - expected[None])).max(axis=-1)
        assert np.max(np.min(distance, axis=1)) < 1e-6
        seen += int(np.sum(np.min(distance, axis=0) < 1e-6))
    assert seen > 16  # the oracle is no straw man: it finds most branches of four poses


@pytest.mark.parametrize(
    "poses", [pytest.param(100, marks=pytest.mark.slow), pytest.param(1000, marks=pytest.mark.long)]
)
def test_branches_of_many_poses_are_complete(arm: ClosedForm, poses: int) -> None:
    """Of many poses, too, with fewer starts each: nothing foreign is found, and most branches are."""
    free = replace(arm.robot, position_limits=np.array([[-np.inf] * 6, [np.inf] * 6]))
    numeric = DampedLeastSquares(free, starts=16, iterations=40)
    branches = seen = 0
    for q in random_positions(poses, seed=7):
        pose = arm.robot.pose(q)
        expected, found = arm.solve(pose), numeric.solve(pose)
        distance = np.abs(wrap(found[:, None] - expected[None])).max(axis=-1)
        assert np.max(np.min(distance, axis=1), initial=0.0) < 1e-6
        branches += len(expected)
        seen += int(np.sum(np.min(distance, axis=0, initial=np.inf) < 1e-6))
    assert seen > 0.75 * branches


def test_the_domain_of_a_position_is_its_branch(arm: ClosedForm) -> None:
    q = random_positions(300, seed=1)
    found = arm.branches(poses_of(arm.robot, q), None)
    signs = arm.domain(q)
    for index in range(len(q)):
        row = int(np.flatnonzero((signs[index] == SIGNS).all(axis=1))[0])
        assert np.max(np.abs(wrap(found.q[index, row] - q[index]))) < 1e-6


def test_one_domain_alone_gives_the_same_as_among_all_eight(arm: ClosedForm) -> None:
    poses = poses_of(arm.robot, random_positions(50, seed=2))
    everything = arm.branches(poses)
    for row, signs in enumerate(SIGNS):
        alone = arm.branches(poses, signs[None])
        np.testing.assert_allclose(alone.q[:, 0], everything.q[:, row], atol=1e-14)


def test_the_sign_of_the_jacobian_determinant_is_that_of_the_domain(arm: ClosedForm) -> None:
    model = arm.robot.bare_model
    data = model.createData()
    q = random_positions(400, seed=3)
    determinants = [np.linalg.det(pin.computeJointJacobian(model, data, row, 6)) for row in q]
    products = np.sign(determinants) * np.prod(arm.domain(q), axis=1)
    assert abs(np.sum(products)) == len(q)


def test_the_determinant_vanishes_where_a_factor_does(arm: ClosedForm) -> None:
    """Bisect each factor's sign change along a line and look at det J there."""
    model = arm.robot.bare_model
    data = model.createData()
    first, second = random_positions(8, seed=4), random_positions(8, seed=6)
    seen = 0
    for start, end in zip(first, second, strict=True):
        for factor in range(3):
            low, high = 0.0, 1.0
            at = arm.factors(np.array([start, end]))[:, factor]
            if at[0] * at[1] > 0:
                continue
            for _ in range(45):
                middle = 0.5 * (low + high)
                value = arm.factors((start + middle * (end - start))[None])[0, factor]
                low, high = (middle, high) if value * at[0] > 0 else (low, middle)
            q = start + low * (end - start)
            if abs(arm.factors(q[None])[0, factor]) > 1e-6:
                continue  # a jump through the angle's end, not a zero
            singular = np.linalg.svd(pin.computeJointJacobian(model, data, q, 6), compute_uv=False)
            assert singular[-1] / singular[0] < 1e-7
            seen += 1
    assert seen > 4


def test_a_pose_out_of_reach_has_no_branch(arm: ClosedForm) -> None:
    pose = np.eye(4)
    pose[:3, 3] = 5.0
    assert arm.solve(pose).shape == (0, 6)


def test_a_singular_wrist_still_closes() -> None:
    robot = load_robot("ur5")
    arm = inverse_kinematics_of(robot)
    pose = robot.pose([0.3, -1.0, 1.2, 0.4, 0.0, 0.2])
    solutions = arm.solve(pose)
    assert len(solutions) >= 4
    assert np.max(np.abs(poses_of(robot, solutions) - pose)) < 1e-7


def test_a_robot_of_another_type_is_refused_with_the_reason() -> None:
    with pytest.raises(RobotError, match="axis 6 does not pass through"):
        SphericalWrist(load_robot("ur5"))
    with pytest.raises(RobotError, match="axes 3 and 4 are not parallel"):
        ThreeParallelAxes(dh_robot("paper-b"))
    with pytest.raises(RobotError, match="axes 2 and 3 are not parallel"):
        SphericalWrist(load_robot("talos-arm"))
    with pytest.raises(RobotError, match="six revolute joints"):
        ThreeParallelAxes(load_robot("panda"))


def test_equations_5_to_15_of_paper_b_hold_for_the_wrist_centre() -> None:
    """The printed equations, signs as derived, with p - d6 a in the place of the printed p."""
    robot = dh_robot("paper-b")
    (_, a1, a2, a3, _, _), d3, d4, d6 = PAPER_B["a"], PAPER_B["d"][2], PAPER_B["d"][3], PAPER_B["d"][5]
    arm = inverse_kinematics_of(robot)
    misses_as_printed = 0
    for q in random_positions(100, seed=7):
        pose = robot.pose(q)
        px, py, pz = pose[:3, 3] - d6 * pose[:3, 2]
        expected = arm.solve(pose)
        found = []
        for first in (1.0, -1.0):
            t1 = np.arctan2(py, px) - np.arctan2(d3, first * np.sqrt(px**2 + py**2 - d3**2))  # Eq. (6)
            assert -np.sin(t1) * px + np.cos(t1) * py == pytest.approx(d3, abs=1e-12)  # Eq. (5)
            out = np.cos(t1) * px + np.sin(t1) * py
            k = (out**2 + d3**2 + pz**2 + a1**2 - a2**2 - a3**2 - d3**2 - d4**2 - 2 * a1 * out) / (2 * a2)
            root = a3**2 + d4**2 - k**2
            if root < 0:
                continue
            for second in (1.0, -1.0):
                t3 = np.arctan2(a3, d4) - np.arctan2(k, second * np.sqrt(root))  # Eq. (9)
                assert a3 * np.cos(t3) - d4 * np.sin(t3) == pytest.approx(k, abs=1e-12)  # Eq. (8)
                c3, s3 = np.cos(t3), np.sin(t3)
                s23 = (-a3 - a2 * c3) * pz + (out - a1) * (
                    a2 * s3 - d4
                )  # Eq. (14), both over the same square
                c23 = (-d4 + a2 * s3) * pz + (out - a1) * (a2 * c3 + a3)  # Eq. (15)
                found.append([t1, np.arctan2(s23, c23) - t3, t3])
        distance = np.abs(wrap(np.array(found)[:, None] - expected[None, :, :3])).max(axis=-1)
        assert np.max(np.min(distance, axis=0)) < 1e-9
        assert np.max(np.min(distance, axis=1)) < 1e-9
        printed = -np.sin(q[0]) * pose[0, 3] + np.cos(q[0]) * pose[1, 3]
        misses_as_printed += abs(printed - d3) > 1e-3
    assert misses_as_printed > 90


def test_equation_3_of_paper_d_holds_with_the_mended_signs_of_alpha() -> None:
    robot = dh_robot("paper-d")
    (_, a1, a2, a3, _, _), d1, d4, d6 = PAPER_D["a"], PAPER_D["d"][0], PAPER_D["d"][3], PAPER_D["d"][5]
    for q in random_positions(100, seed=8):
        pose = robot.pose(q)
        ax, ay, az = pose[:3, 2]
        nx, ny, nz = pose[:3, 0]
        px, py, pz = pose[:3, 3] - d6 * pose[:3, 2]
        c1, s1, c2, s2, c3, s3 = (f(angle) for angle in q[:3] for f in (np.cos, np.sin))
        c4, s4, c5, s5 = (f(angle) for angle in q[3:5] for f in (np.cos, np.sin))
        c23, s23 = np.cos(q[1] + q[2]), np.sin(q[1] + q[2])
        k1, k2 = c1 * px + s1 * py - a1, pz - d1
        assert np.abs(s1 * px - c1 * py) < 1e-12  # theta_1 = Atan2(+-py, +-px)
        assert k1 - a2 * c2 == pytest.approx(a3 * c23 + d4 * s23, abs=1e-12)
        assert k2 - a2 * s2 == pytest.approx(a3 * s23 - d4 * c23, abs=1e-12)
        h = (k1**2 + k2**2 - a2**2 - a3**2 - d4**2) / (2 * a2)
        assert a3 * c3 + d4 * s3 == pytest.approx(h, abs=1e-12)
        p1 = ax * (s1 * s4 + c1 * c4 * c23) + ay * (s1 * c4 * c23 - c1 * s4) + az * c4 * s23
        p2 = ax * c1 * s23 + ay * s1 * s23 - az * c23
        assert (
            np.abs(wrap(np.arctan2(-p1, -p2) - q[4])) < 1e-9 or np.abs(wrap(np.arctan2(p1, p2) - q[4])) < 1e-9
        )
        m31, m32, m33 = s1 * c4 - c1 * s4 * c23, -c1 * c4 - s1 * s4 * c23, -s4 * s23
        m11 = s1 * s4 * c5 - c1 * s5 * s23 + c1 * c4 * c5 * c23
        m12 = -c1 * s4 * c5 - s1 * s5 * s23 + s1 * c4 * c5 * c23
        m13 = s5 * c23 + c4 * c5 * s23
        sine, cosine = nx * m31 + ny * m32 + nz * m33, nx * m11 + ny * m12 + nz * m13
        assert np.abs(wrap(np.arctan2(sine, cosine) - q[5])) < 1e-9
