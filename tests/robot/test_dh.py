"""Denavit-Hartenberg tables against transforms multiplied by hand."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.exceptions import InputError, RobotError
from ocp_traj.robot import robot_from_dh


def about_x(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1.0]])


def about_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])


def along(x: float = 0.0, z: float = 0.0) -> np.ndarray:
    result = np.eye(4)
    result[0, 3], result[2, 3] = x, z
    return result


def hand_multiplied(convention: str, rows: np.ndarray, kinds: tuple[str, ...], q: np.ndarray) -> np.ndarray:
    pose = np.eye(4)
    for (a, alpha, d, theta), kind, value in zip(rows, kinds, q, strict=True):
        turn = about_z(theta + (value if kind == "revolute" else 0.0))
        lift = along(z=d + (value if kind == "prismatic" else 0.0))
        if convention == "standard":
            pose = pose @ turn @ lift @ along(x=a) @ about_x(alpha)
        else:
            pose = pose @ about_x(alpha) @ along(x=a) @ turn @ lift
    return pose


@pytest.mark.parametrize("convention", ["standard", "modified"])
@pytest.mark.parametrize("unit", ["rad", "deg"])
def test_poses_equal_transforms_multiplied_by_hand(convention: str, unit: str) -> None:
    rng = np.random.default_rng(0)
    for n in range(1, 8):
        rows = rng.standard_normal((n, 4))
        kinds = tuple(rng.choice(["revolute", "prismatic"], n))
        scale = 180.0 / np.pi if unit == "deg" else 1.0
        robot = robot_from_dh(
            convention, rows[:, 0], rows[:, 1] * scale, rows[:, 2], rows[:, 3] * scale, unit, kinds
        )
        for q in rng.uniform(-3.0, 3.0, (5, n)):
            expected = hand_multiplied(convention, rows, kinds, q)
            np.testing.assert_allclose(robot.pose(q), expected, atol=1e-13)
            np.testing.assert_allclose(np.array(robot.symbolic.pose()(q)), expected, atol=1e-13)


def test_the_arm_of_paper_b_stretches_out_as_its_table_says() -> None:
    robot = robot_from_dh(
        "modified",
        a=[0.0, 0.200, 0.7156, 0.256, 0.0, 0.0],
        alpha=[0.0, -90.0, 0.0, -90.0, 90.0, -90.0],
        d=[0.0, 0.0, -0.0944, 0.8455, 0.0, 0.0838],
        theta=[0.0] * 6,
        unit="deg",
    )
    pose = robot.pose(np.zeros(6))
    # All joints at zero: x adds the lengths a, y holds the offset d3, and z hangs down by d4 + d6.
    np.testing.assert_allclose(pose[:3, 3], [0.200 + 0.7156 + 0.256, -0.0944, -0.8455 - 0.0838], atol=1e-15)
    np.testing.assert_allclose(pose[:3, :3], np.diag([1.0, -1.0, -1.0]), atol=1e-15)


def test_right_angles_in_degrees_leave_no_rounding() -> None:
    robot = robot_from_dh("standard", [0.0, 0.0], [90.0, -90.0], [0.0, 1.0], [180.0, 270.0], "deg")
    pose = robot.pose(np.zeros(2))
    assert set(np.abs(pose[:3, :3]).ravel().tolist()) == {0.0, 1.0}


def test_limits_are_kept_and_default_to_none() -> None:
    table = ([0.0], [0.0], [0.0], [0.0])
    free = robot_from_dh("standard", *table)
    assert np.all(np.isinf(free.position_limits)) and np.all(np.isinf(free.velocity_limits))
    limited = robot_from_dh(
        "standard", *table, position_limits=[[-1.0], [2.0]], velocity_limits=[[-3.0], [3.0]]
    )
    np.testing.assert_array_equal(limited.position_limits, [[-1.0], [2.0]])
    np.testing.assert_array_equal(limited.velocity_limits, [[-3.0], [3.0]])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"convention": "craig"}, "DH convention 'craig' is unknown, expected one of standard, modified"),
        ({"alpha": [0.0]}, r"DH column alpha has shape \(1,\), expected \(2,\)"),
        ({"d": [0.0, np.nan]}, "DH column d is .* expected finite"),
        ({"joints": ["revolute", "helical"]}, "DH joints is .* expected 2 of"),
        ({"joints": ["revolute"]}, "DH joints is .* expected 2 of"),
        ({"a": [], "alpha": [], "d": [], "theta": []}, "DH table is empty"),
        ({"position_limits": [[1.0, 1.0], [0.0, 2.0]]}, "expected lower <= upper"),
        ({"position_limits": [[1.0], [2.0]]}, r"position_limits has shape \(2, 1\), expected \(2, 2\)"),
    ],
)
def test_a_wrong_table_is_refused(changes: dict[str, object], message: str) -> None:
    given: dict[str, object] = {
        "convention": "standard",
        "a": [0.0, 0.0],
        "alpha": [0.0, 0.0],
        "d": [0.0, 0.0],
        "theta": [0.0, 0.0],
    }
    with pytest.raises(RobotError, match=message):
        robot_from_dh(**{**given, **changes})  # type: ignore[arg-type]


def test_an_unknown_unit_is_refused() -> None:
    with pytest.raises(InputError, match="unit 'grad' is unknown"):
        robot_from_dh("standard", [0.0], [0.0], [0.0], [0.0], "grad")
