"""Pictures show what the motion does, as well-formed SVG and as files."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from ocp_traj.exceptions import InputError
from ocp_traj.pictures.axes import Axis, fit_axis
from ocp_traj.pictures.matplotlib_ import save_picture
from ocp_traj.pictures.motion import (
    motion_picture,
    path_length,
    path_picture,
    power_picture,
    sample_limits,
    tool_path,
)
from ocp_traj.pictures.picture import Band, Line, Panel, Picture
from ocp_traj.pictures.svg import draw_picture
from ocp_traj.robot import load_robot
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory


@pytest.fixture(scope="module")
def case() -> tuple[TrajectoryTask, Trajectory]:
    """The UR5 from rest to rest along one quintic."""
    robot = load_robot("ur5")
    start, travel = np.zeros(6), np.array([0.5, -0.4, 0.3, 0.2, 0.1, -0.1])
    coefficients = np.zeros((1, 6, 6))
    coefficients[0, :, 0] = start
    coefficients[0, :, 3:] = travel[:, None] * np.array([10.0, -15.0, 6.0])
    motion = Trajectory(np.array([0.0, 1.0]), coefficients, np.array([0.0, 1.0]), "quintic", "x")
    task = TrajectoryTask(
        np.array([start, start + travel]), Limits(velocity=2.0, acceleration=10.0), robot, virtual_knots=3
    )
    return task, motion


def test_shares_of_limits_are_values_over_limits(case: tuple[TrajectoryTask, Trajectory]) -> None:
    picture = motion_picture(*case, relative=True)
    velocity = next(panel for panel in picture.panels if panel.title == "Velocity")
    assert velocity.y_label == "share of the limit"
    assert velocity.lines[0].y.max() == pytest.approx(
        0.5 * 1.875 / 2.0, rel=1e-4
    )  # the quintic peaks at 15/8


def test_what_has_no_limit_is_shown_in_its_unit(case: tuple[TrajectoryTask, Trajectory]) -> None:
    picture = motion_picture(*case, relative=True)
    jerk = next(panel for panel in picture.panels if panel.title == "Jerk")
    assert jerk.y_label == "jerk (rad/s³)"


def test_torques_are_those_of_the_robot(case: tuple[TrajectoryTask, Trajectory]) -> None:
    task, motion = case
    torque = next(panel for panel in motion_picture(task, motion).panels if panel.title == "Torque")
    assert task.robot is not None
    expected = task.robot.torque(motion([0.0]), motion([0.0], 1), motion([0.0], 2))
    np.testing.assert_allclose([line.y[0] for line in torque.lines[:6]], expected[0])


def test_the_tool_path_is_the_robots(case: tuple[TrajectoryTask, Trajectory]) -> None:
    task, motion = case
    assert task.robot is not None
    points = tool_path(task, motion, np.array([0.0, 1.0]))
    np.testing.assert_allclose(points[1], task.robot.pose(motion(1.0))[:3, 3])
    assert path_length(np.array([[0.0, 0, 0], [3, 4, 0], [3, 4, 1]])) == 6.0


def test_the_energy_shown_is_that_of_the_samples(case: tuple[TrajectoryTask, Trajectory]) -> None:
    from ocp_traj.audit.costs import energy

    exact = energy(*case)
    assert exact is not None
    assert power_picture(*case).panels[1].lines[0].y[-1] == pytest.approx(exact, rel=1e-3)


def test_a_task_without_robot_has_no_tool_path(case: tuple[TrajectoryTask, Trajectory]) -> None:
    bare = TrajectoryTask(case[0].waypoints, virtual_knots=3)
    with pytest.raises(InputError, match="has no robot, so there is no tool path"):
        path_picture(bare, case[1])
    with pytest.raises(InputError, match="so there is no power"):
        power_picture(bare, case[1])


def test_limits_of_unknown_gaps_are_the_tightest() -> None:
    velocity = np.array([[[-1.0], [1.0]], [[-2.0], [0.5]]])
    task = TrajectoryTask(np.array([[0.0], [1.0], [2.0]]), Limits(velocity=velocity), virtual_knots=3)
    line = Trajectory(np.array([0.0, 1.0]), np.array([[[0.0, 2.0]]]), np.array([0.0, 1.0]))
    np.testing.assert_array_equal(sample_limits(task, line, "velocity", np.array([0.5])), [[[-1.0], [0.5]]])


def test_svg_is_well_formed_and_escapes() -> None:
    x = np.array([1.0, 10.0, 100.0])
    lines = (Line(x, np.array([1.0, np.inf, 2.0]), "<a & b>"), Line(x, x * np.nan, "nothing", 1, step=True))
    panel = Panel("T <", "x", "y", lines, (Band(x, x, 2 * x, 0),), log_x=True, log_y=True)
    drawn = draw_picture(Picture("n", "t", "c & d", (panel, panel)))
    tree = ElementTree.fromstring(drawn)
    assert "nan" not in drawn and "inf" not in drawn
    assert len(list(tree.iter("svg"))) == 4


def test_empty_pictures_are_drawn() -> None:
    ElementTree.fromstring(draw_picture(Picture("n", "t", "c", (Panel("T", "x", "y", ()),))))


@pytest.mark.parametrize("ending", [".png", ".pdf", ".svg"])
def test_pictures_are_written_as_files(
    tmp_path: Path, case: tuple[TrajectoryTask, Trajectory], ending: str
) -> None:
    save_picture(motion_picture(*case), tmp_path / f"picture{ending}")
    head = (tmp_path / f"picture{ending}").read_bytes()[:300]
    assert {".png": b"\x89PNG", ".pdf": b"%PDF", ".svg": b"<svg"}[ending] in head or b"<?xml" in head


def test_another_ending_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"ends in '.gif', expected one of .pdf, .png, .svg"):
        save_picture(Picture("n", "t", "c", ()), tmp_path / "x.gif")


@pytest.mark.parametrize(
    ("axis", "labels"),
    [
        (Axis(0.0, 1.0), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]),
        (Axis(-0.013, 0.013), ["-0.010", "-0.005", "0", "0.005", "0.010"]),
        (Axis(1.0, 1e4, True), ["1", "10", "100", "1000", "10000"]),
        (Axis(1.0, 2.1, True), ["1", "1.2", "1.5", "2"]),
    ],
)
def test_ticks_are_round_numbers(axis: Axis, labels: list[str]) -> None:
    assert [label for _, label in axis.ticks()] == labels


def test_an_axis_of_one_value_has_a_width() -> None:
    axis = fit_axis([np.array([3.0, 3.0])])
    assert axis.lower < 3.0 < axis.upper
    assert fit_axis([np.array([np.nan, -1.0])], log=True).log
