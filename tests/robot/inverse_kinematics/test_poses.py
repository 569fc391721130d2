"""From Cartesian waypoints to joint waypoints: branch choice, singularities, errors, paper C's domains."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from ocp_traj.exceptions import InputError, RobotError, UnreachablePoseError
from ocp_traj.robot import Robot, load_robot, robot_from_dh, robot_names, solve_poses
from ocp_traj.robot.inverse_kinematics import (
    ClosedForm,
    DampedLeastSquares,
    find_crossings,
    follow_domain,
    inverse_kinematics_of,
    poses_to_matrices,
)
from ocp_traj.robot.inverse_kinematics.branch_choice import nearest_branch, nearest_turns
from ocp_traj.robot.inverse_kinematics.domain_timing import measure_domain_timing
from ocp_traj.robot.inverse_kinematics.universal_robots import ALL_SIGNS, universal_robots_table

# The helix of case ur5-helix: centre (-200, 100) mm, radius 60 mm, pitch 10 mm, constant orientation.
START = np.array([1.731, -2.032, 2.096, -0.065, -1.410, 1.571])
WEIGHTS = np.array([6.0, 5.0, 4.0, 3.0, 2.0, 1.0])


def helix(count: int = 9) -> np.ndarray:
    angle = np.linspace(0.0, 2.0 * np.pi, count)
    rows = np.tile([0.0, 0.0, 0.0, 0.5, -0.5, 0.5, 0.5], (count, 1))
    rows[:, 0], rows[:, 1] = -0.2 + 0.06 * np.cos(angle), 0.1 + 0.06 * np.sin(angle)
    rows[:, 2] = 0.35 + 0.01 * angle / (2.0 * np.pi)
    return rows


def helix_robot() -> Robot:
    return load_robot("ur5").with_changes(tool="tool0", base="base_link")


def rows_of(robot: Robot, q: np.ndarray) -> np.ndarray:
    return np.array([pin.SE3ToXYZQUAT(pin.SE3(robot.pose(row))) for row in np.atleast_2d(q)])


@pytest.mark.parametrize("method", ["nearest", "unique-domain"])
def test_the_helix_of_paper_c_keeps_joint_6_still(method: str) -> None:
    robot = helix_robot()
    q = solve_poses(robot, helix(), START, WEIGHTS, method)  # type: ignore[arg-type]
    assert np.ptp(q[:, 5]) < 1e-6
    assert np.max(np.abs(q[0] - START)) < 2e-3
    np.testing.assert_allclose([robot.pose(row) for row in q], poses_to_matrices(helix()), atol=1e-9)


def test_both_methods_agree_along_the_helix() -> None:
    robot = helix_robot()
    nearest = solve_poses(robot, helix(100), START, WEIGHTS)
    domain = solve_poses(robot, helix(100), START, WEIGHTS, "unique-domain")
    np.testing.assert_allclose(nearest, domain, atol=1e-12)


def test_poses_and_joints_go_back_and_forth_along_a_path() -> None:
    """Paper A's way: joint points, their poses, and back."""
    robot = load_robot("ur5")
    degrees = [
        [-48.91, -64.72, 108.46, -133.73, -90.0, 131.09],
        [14.03, -103.29, 98.98, -85.68, -90.0, 194.03],
    ]
    q = np.radians(degrees)
    np.testing.assert_allclose(solve_poses(robot, rows_of(robot, q), q[0]), q, atol=1e-9)


@pytest.mark.parametrize("name", robot_names())
def test_every_named_robot_returns_to_reachable_poses(name: str) -> None:
    robot = load_robot(name)
    rng = np.random.default_rng(0)
    lower = np.maximum(robot.position_limits[0], -np.pi)
    upper = np.minimum(robot.position_limits[1], np.pi)
    middle = 0.5 * (lower + upper)
    q = middle + rng.uniform(-0.35, 0.35, (3, robot.n)) * (upper - lower)
    for row in q:
        pose = rows_of(robot, row)
        found = solve_poses(robot, pose, row + 1e-3)
        assert np.max(np.abs(robot.pose(found[0]) - robot.pose(row))) < 1e-9
        assert np.all(found >= robot.position_limits[0]) and np.all(found <= robot.position_limits[1])
        if robot.n <= 6:
            np.testing.assert_allclose(found[0], row, atol=1e-6)


@pytest.mark.parametrize("name", ["panda", "talos-arm", "xarm7", "so101", "tiago"])
def test_damped_least_squares_closes_to_1e_9_for_reachable_poses(name: str) -> None:
    robot = load_robot(name)
    inverse = DampedLeastSquares(robot)
    lower, upper = (np.clip(limit, -np.pi, np.pi) for limit in robot.position_limits)
    for q in np.random.default_rng(1).uniform(lower, upper, (40, robot.n)):
        pose = robot.pose(q)
        starts = inverse.start_positions(60)
        end = next(end for end in (inverse.descend(pose, start) for start in starts) if end.converged)
        assert np.max(np.abs(robot.pose(end.q) - pose)) < 1e-9
        assert np.all(end.q >= robot.position_limits[0]) and np.all(end.q <= robot.position_limits[1])


@pytest.mark.parametrize(
    "poses", [pytest.param(100, marks=pytest.mark.slow), pytest.param(1000, marks=pytest.mark.long)]
)
@pytest.mark.parametrize("name", [name for name in robot_names() if load_robot(name).n != 2])
def test_many_reachable_poses_of_every_robot_close_to_1e_9(name: str, poses: int) -> None:
    robot = load_robot(name)
    inverse = DampedLeastSquares(robot)
    lower, upper = (np.clip(limit, -np.pi, np.pi) for limit in robot.position_limits)
    for q in np.random.default_rng(2).uniform(lower, upper, (poses, robot.n)):
        pose = robot.pose(q)
        starts = inverse.start_positions(200)
        end = next(end for end in (inverse.descend(pose, start) for start in starts) if end.converged)
        assert np.max(np.abs(robot.pose(end.q) - pose)) < 1e-9


def test_damped_least_squares_finds_the_branches_of_a_closed_form() -> None:
    robot = replace(load_robot("ur5"), position_limits=np.array([[-np.inf] * 6, [np.inf] * 6]))
    closed = inverse_kinematics_of(robot)
    pose = robot.pose([0.4, -1.2, 1.4, -0.8, 0.9, 0.2])
    found = DampedLeastSquares(robot, starts=80).solve(pose)
    assert len(found) == len(closed.solve(pose)) == 8


def test_weights_make_light_joints_move_more() -> None:
    robot = load_robot("panda")
    q = np.array([0.1, -0.4, 0.2, -2.0, 0.3, 1.8, 0.5])
    pose = rows_of(robot, q)
    start = q + 0.1
    moved = [
        np.abs(solve_poses(robot, pose, start, weights) - start)[0, 0]
        for weights in (np.ones(7), [1e4] + [1.0] * 6)
    ]
    assert moved[1] < moved[0]


def test_the_nearest_turn_within_the_limits_is_taken() -> None:
    robot = load_robot("ur5")
    previous = np.array([6.0, -6.0, 0.0, 3.2, 0.0, 0.0])
    q = np.array([-0.2, 0.2, 3.0, -3.1, 0.1, 0.0])
    expected = [-0.2 + 2 * np.pi, 0.2 - 2 * np.pi, 3.0, -3.1 + 2 * np.pi, 0.1, 0.0]
    np.testing.assert_allclose(nearest_turns(robot, q, previous), expected, atol=1e-15)
    # One more turn would be nearer but leaves +-2 pi.
    np.testing.assert_allclose(nearest_turns(robot, np.full(6, 0.3), np.full(6, 6.2))[0], 0.3)
    assert (
        np.isnan(nearest_turns(robot, np.array([0.0, 0.0, 3.2, 0.0, 0.0, 0.0]), np.zeros(6))[2]) is np.False_
    )
    narrow = replace(robot, position_limits=np.array([[-1.0] * 6, [1.0] * 6]))
    assert np.isnan(nearest_turns(narrow, np.full(6, 2.0), np.zeros(6))).all()


def test_the_weighted_nearest_rule_by_hand() -> None:
    robot = load_robot("two-dof")
    branches = np.array([[1.0, 0.0], [0.0, 1.5], [np.nan, 0.0]])
    previous = np.zeros(2)
    assert nearest_branch(robot, branches, previous, np.array([2.0, 1.0])) == 1  # 2.0 against 1.5
    assert nearest_branch(robot, branches, previous, np.array([1.0, 1.0])) == 0  # 1.0 against 1.5
    assert nearest_branch(robot, branches[2:], previous, np.ones(2)) is None


def test_a_waypoint_out_of_reach_is_named() -> None:
    poses = helix()
    poses[3, :3] = [2.0, 0.0, 0.0]
    for method in ("nearest", "unique-domain"):
        with pytest.raises(UnreachablePoseError, match=r"waypoint 4 at \(2, 0, 0\) m is out of reach"):
            solve_poses(helix_robot(), poses, START, WEIGHTS, method)  # type: ignore[arg-type]


def test_a_waypoint_outside_of_the_joint_limits_is_named() -> None:
    robot = replace(
        helix_robot(), position_limits=np.array([[1.6, -3, 0, -3, -3, 0], [1.8, 0, 3, 3, 0, 3.0]])
    )
    with pytest.raises(UnreachablePoseError, match=r"waypoint 3 at .* only outside of the joint limits"):
        solve_poses(robot, helix(), START, WEIGHTS)


@pytest.mark.parametrize(
    ("q", "factor"),
    [([0.3, -1.0, 1.2, 0.4, 0.0, 0.2], "wrist"), ([0.3, -1.0, 0.0, 0.4, 0.7, 0.2], "elbow")],
)
def test_a_singular_waypoint_is_named_with_its_cause(q: list[float], factor: str) -> None:
    robot = load_robot("ur5")
    with pytest.raises(UnreachablePoseError, match=rf"waypoint 2 at .* is singular \({factor}: det J = 0\)"):
        solve_poses(robot, rows_of(robot, np.array([[0.3, -1.0, 0.8, 0.4, 0.5, 0.2], q])), q)


def test_a_singular_waypoint_of_an_arm_without_closed_form_is_named() -> None:
    robot = load_robot("panda")
    stretched = np.array([0.1, 0.0, 0.0, -0.07, 0.0, 0.03, 0.2])
    singular = replace(robot, position_limits=robot.position_limits + np.array([[-0.2] * 7, [0.2] * 7]))
    stretched[[3, 5]] = 0.0
    with pytest.raises(UnreachablePoseError, match=r"waypoint 1 at .* is singular"):
        solve_poses(singular, rows_of(singular, stretched), stretched)


def test_a_pose_a_short_arm_cannot_reach_says_by_how_much() -> None:
    pose = rows_of(load_robot("so101"), np.zeros(5))
    pose[0, :3] += [0.0, 0.3, 0.0]
    with pytest.raises(UnreachablePoseError, match=r"waypoint 1 .* nearest pose found is off by 0\.\d+"):
        solve_poses(load_robot("so101"), pose, np.zeros(5))


def through_a_wrist_singularity() -> tuple[Robot, np.ndarray, np.ndarray]:
    robot = load_robot("ur5")
    q = np.tile([0.3, -1.0, 1.2, 0.4, 0.5, 0.2], (3, 1))
    q[:, 4] = [0.4, 0.2, -0.2]
    return robot, q, poses_to_matrices(rows_of(robot, q))


def test_a_path_through_a_singularity_is_found_and_placed() -> None:
    robot, q, poses = through_a_wrist_singularity()
    inverse = inverse_kinematics_of(robot)
    assert isinstance(inverse, ClosedForm)
    assert find_crossings(inverse, poses[:2], q[0]) == ()
    (crossing,) = find_crossings(inverse, poses, q[0])
    # Between the last two positions only joint 5 turns, from 0.2 to -0.2: it is at zero half way.
    assert (crossing.gap, crossing.factor, crossing.effect) == (2, "wrist", "swings")
    assert crossing.fraction == pytest.approx(0.5, abs=1e-6)
    rows = rows_of(robot, q)
    with pytest.raises(UnreachablePoseError, match=r"between waypoints 2 and 3, 50.0 % .* \(wrist\)"):
        solve_poses(robot, rows, q[0], method="unique-domain")
    np.testing.assert_allclose(solve_poses(robot, rows, q[0]), q, atol=1e-9)  # the nearest rule goes through


def test_a_path_exactly_through_a_singularity_makes_the_branch_jump() -> None:
    # Without an offset behind the spherical wrist, turning joint 5 alone is a straight way.
    robot = robot_from_dh(
        "modified",
        a=[0.0, 0.2, 0.7, 0.25, 0.0, 0.0],
        alpha=[0.0, -90.0, 0.0, -90.0, 90.0, -90.0],
        d=[0.0, 0.0, -0.1, 0.85, 0.0, 0.0],
        theta=[0.0] * 6,
        unit="deg",
    )
    q = np.tile([0.3, -0.6, 0.4, 0.4, 0.1, 0.2], (2, 1))
    q[1, 4] = -0.3
    inverse = inverse_kinematics_of(robot)
    assert isinstance(inverse, ClosedForm)
    (crossing,) = find_crossings(inverse, poses_to_matrices(rows_of(robot, q)), q[0])
    assert (crossing.gap, crossing.factor, crossing.effect) == (1, "wrist", "jumps")
    # Double roots count as met within 1e-6 rad, that is 1e-5 of this gap.
    assert crossing.fraction == pytest.approx(0.25, abs=1e-5)


def test_a_path_that_leaves_the_reach_between_waypoints_is_found() -> None:
    """Two reachable points whose straight connection passes through the hole around the shoulder axis."""
    robot = load_robot("ur5")
    inverse = inverse_kinematics_of(robot)
    assert isinstance(inverse, ClosedForm)
    q = np.array([0.3, -1.5, 2.0, -2.0, -1.4, 0.2])
    first = robot.pose(q)
    last = first.copy()
    last[:2, 3] *= -1.0
    (crossing,) = find_crossings(inverse, np.array([first, last]), q)
    assert crossing.factor in ("shoulder", "elbow") and crossing.effect == "ends"
    assert "1 and 2" in str(crossing) and "ends" in str(crossing)


def test_following_a_domain_leaves_rows_without_solution_empty() -> None:
    robot = helix_robot()
    inverse = inverse_kinematics_of(robot)
    assert isinstance(inverse, ClosedForm)
    poses = poses_to_matrices(helix())
    poses[4, 0, 3] = 3.0
    q = follow_domain(inverse, poses, START)
    assert np.isnan(q[4]).all() and not np.isnan(np.delete(q, 4, axis=0)).any()


def test_a_start_on_a_border_has_no_domain() -> None:
    singular = START.copy()
    singular[4] = 0.0
    with pytest.raises(UnreachablePoseError, match=r"start position .* is singular .wrist"):
        solve_poses(helix_robot(), helix(), singular, WEIGHTS, "unique-domain")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"poses": np.zeros((2, 6))}, r"poses have shape \(2, 6\), expected \(K, 7\)"),
        ({"poses": np.full((1, 7), np.nan)}, "pose of waypoint 1 is .* expected finite"),
        (
            {"poses": [[0, 0, 0, 0, 0, 0, 1.0], [0, 0, 0, 0, 0, 0, 2.0]]},
            "quaternion of waypoint 2 has norm 2",
        ),
        ({"start": np.zeros(5)}, r"start has shape \(5,\), expected \(6,\)"),
        ({"weights": np.zeros(6)}, "weights are .* expected positive"),
        ({"method": "newton"}, "method 'newton' is unknown"),
    ],
)
def test_wrong_arguments_are_refused(changes: dict[str, object], message: str) -> None:
    given: dict[str, object] = {"poses": helix(), "start": START, "weights": WEIGHTS, "method": "nearest"}
    with pytest.raises(InputError, match=message):
        solve_poses(helix_robot(), **{**given, **changes})  # type: ignore[arg-type]


def test_unique_domains_need_a_closed_form() -> None:
    robot = load_robot("panda")
    with pytest.raises(InputError, match="needs a closed form, robot 'panda' has none"):
        solve_poses(robot, rows_of(robot, np.zeros(7)), np.zeros(7), method="unique-domain")


@pytest.mark.parametrize("name", ["ur3", "ur5", "ur10"])
def test_the_plain_python_form_has_the_same_branches(name: str) -> None:
    robot = load_robot(name).with_changes(base="base", tool="tool0")
    table, inverse = universal_robots_table(robot), inverse_kinematics_of(robot)
    for q in np.random.default_rng(3).uniform(-3.0, 3.0, (100, 6)):
        pose = robot.pose(q)
        found = np.array(table.solve_all(pose.tolist()))
        one_by_one = [table.solve(pose.tolist(), k) for k in ALL_SIGNS]
        assert [tuple(row) for row in found.tolist()] == [row for row in one_by_one if row is not None]
        expected = inverse.solve(pose)
        assert len(found) == len(expected)
        distance = np.abs((found[:, None] - expected[None] + np.pi) % (2 * np.pi) - np.pi).max(axis=-1)
        assert max(np.max(np.min(distance, axis=0)), np.max(np.min(distance, axis=1))) < 1e-6


def test_the_table_of_the_ur5_is_the_published_one() -> None:
    table = universal_robots_table(load_robot("ur5"))
    found = [table.d1, table.a2, table.a3, table.d4, table.d5, table.d6]
    np.testing.assert_allclose(found, [0.089159, -0.425, -0.39225, 0.10915, 0.09465, 0.0823], atol=1e-9)


@pytest.mark.parametrize("name", ["panda", "z1"])
def test_other_arms_have_no_table(name: str) -> None:
    with pytest.raises(RobotError, match="is no UR arm"):
        universal_robots_table(load_robot(name))


@pytest.mark.parametrize("form", ["python", "vectorised"])
def test_the_timing_of_unique_domains_compares_equal_answers(form: str) -> None:
    timing = measure_domain_timing(
        helix_robot(), poses_to_matrices(helix(50)), START, WEIGHTS, form, repeats=3
    )  # type: ignore[arg-type]
    assert timing.form == form
    assert timing.eight_branches.shape == timing.one_domain.shape == (3,)
    assert timing.saving == 1.0 - min(timing.one_domain) / min(timing.eight_branches)


def test_the_timing_refuses_a_path_that_leaves_its_domain() -> None:
    robot, q, poses = through_a_wrist_singularity()
    with pytest.raises(UnreachablePoseError, match="not that of one domain"):
        measure_domain_timing(robot, poses, q[0], np.ones(6), "vectorised")
