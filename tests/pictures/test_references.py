"""Phase planes and bounds: the pictures show what the references say."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from ocp_traj.exceptions import InputError
from ocp_traj.pictures.bounds import TimeEntry, bounds_panel, bounds_picture
from ocp_traj.pictures.matplotlib_ import save_picture
from ocp_traj.pictures.phase_plane import phase_plane_picture
from ocp_traj.pictures.references import references_picture
from ocp_traj.pictures.svg import draw_picture
from ocp_traj.references import ReferenceSet, collect_references, limit_curves, toppra_reference
from ocp_traj.references.reference import ESTIMATED, FOUND, PROVED
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory


@pytest.fixture(scope="module")
def task() -> TrajectoryTask:
    """Two joints that move, one of them forth and back."""
    points = np.array([[0.0, 0.0], [1.0, 0.6], [2.0, 0.1]])
    return TrajectoryTask(points, Limits(velocity=1.0, acceleration=[2.0, 3.0]), name="bend")


@pytest.fixture(scope="module")
def motion() -> Trajectory:
    """A quintic that passes the three waypoints' first and last in three seconds."""
    coefficients = np.zeros((2, 2, 6))
    coefficients[0, :, 3:] = np.outer([1.0, 0.6], [10.0, -15.0, 6.0])
    coefficients[1, :, 0] = [1.0, 0.6]
    coefficients[1, :, 3:] = np.outer([1.0, -0.5], [10.0, -15.0, 6.0])
    return Trajectory(np.array([0.0, 1.0, 2.0]), coefficients, np.array([0.0, 1.0, 2.0]), "quintic", "bend")


@pytest.fixture(scope="module")
def found(task: TrajectoryTask, motion: Trajectory) -> ReferenceSet:
    """The references of the task and of the motion's path."""
    return collect_references(task, motion, time_limit=300.0)


def test_no_profile_crosses_the_limit_curves(task: TrajectoryTask) -> None:
    for path in ("uniform", "chord"):
        curves = limit_curves(task, path, points=400)
        result = toppra_reference(task, path, points=400)
        assert np.array_equal(curves.s, result.s)
        for curve in (curves.velocity, curves.by_kind["acceleration"]):
            assert (result.speed <= curve * (1 + 1e-6) + 1e-9).all()
        assert set(curves.by_kind) == {"acceleration"}


def test_the_limit_curve_of_a_circle_is_the_centripetal_one() -> None:
    angle = np.linspace(0, np.pi, 60)
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    curves = limit_curves(TrajectoryTask(points, Limits(acceleration=2.0)), "chord", points=600)
    # radius 1: in the middle of the half circle only joint 2 bends, and speed^2 = A
    middle = np.interp(0.5, curves.s, curves.by_kind["acceleration"]) * np.pi
    assert middle == pytest.approx(np.sqrt(2.0), rel=1e-3)
    # at 45 degrees tangent and normal share both joints: speed^2 = sqrt(2) A
    quarter = np.interp(0.25, curves.s, curves.by_kind["acceleration"]) * np.pi
    assert quarter == pytest.approx(np.sqrt(2.0 * np.sqrt(2.0)), rel=1e-2)
    assert np.isinf(curves.velocity).all()


def test_a_path_without_motion_has_no_phase_plane() -> None:
    still = TrajectoryTask(np.ones((3, 2)), Limits(acceleration=1.0))
    with pytest.raises(InputError, match="nothing moves along the path, so it has no phase plane"):
        limit_curves(still)
    with pytest.raises(InputError, match="nothing moves"):
        phase_plane_picture(still)


def test_the_phase_plane_colours_every_cell_by_its_active_limit(
    task: TrajectoryTask, found: ReferenceSet
) -> None:
    paths = ["uniform", "chord"]
    timings = list(zip(found.toppra[:2], found.convex[:2]))
    picture = phase_plane_picture(task, paths, timings)
    for panel, (_, convex) in zip(picture.panels, timings):
        coloured = [line for line in panel.lines if line.wide]
        assert sum(len(line.x) - 1 for line in coloured) == len(convex.active)
        assert {line.label.removesuffix(" active") for line in coloured} - {"no limit"} <= set(convex.active)
        by_label: dict[str, set[int]] = {}
        for line in coloured:
            by_label.setdefault(line.label, set()).add(line.colour)
        assert all(len(colours) == 1 for colours in by_label.values())
        assert any(line.label == "TOPP-RA" for line in panel.lines)
        top = panel.y_range[1]
        assert all((line.y <= top * (1 + 1e-12)).all() and (line.y >= 0).all() for line in panel.lines)


def test_a_motions_own_speed_is_drawn_with_its_path(task: TrajectoryTask, motion: Trajectory) -> None:
    timing = toppra_reference(task, motion, points=100)
    (panel,) = phase_plane_picture(task, [motion], [(timing, None)]).panels
    (own,) = [line for line in panel.lines if line.label == "the motion itself"]
    assert panel.title == f"Path spline: {timing.duration:.4f} s (the motion takes 2.0000 s)"
    # time is the integral of ds over sdot; the motion rests at its ends and at the waypoint
    inner = own.y > 1e-3
    middle = 0.5 * (own.y[inner][1:] + own.y[inner][:-1])
    assert (np.diff(own.x[inner]) / middle).sum() == pytest.approx(2.0, rel=0.1)
    assert own.x[-1] == 1.0 and own.y[0] == 0.0


def test_bounds_are_rows_in_order_with_their_gaps() -> None:
    entries = [
        TimeEntry("pso", 3.0, FOUND),
        TimeEntry("kinematic bound", 2.0, PROVED),
        TimeEntry("kinematic estimate", 2.1, ESTIMATED),
    ]
    panel = bounds_panel(entries, "case")
    assert panel.row_names == (
        "kinematic bound: 2.0000 s",
        "kinematic estimate: 2.1000 s (+5 %)",
        "pso: 3.0000 s (+50 %)",
    )
    ends = [line.x[0] for line in panel.lines if line.wide]
    assert ends == [2.0, 2.1, 3.0]
    with pytest.raises(InputError, match="there are no bounds, references or results to draw"):
        bounds_panel([], "case")


def test_without_a_bound_gaps_are_to_the_shortest() -> None:
    picture = bounds_picture([TimeEntry("a", 1.0, FOUND), TimeEntry("b", 1.5, FOUND)], "case")
    assert picture.panels[0].row_names == ("a: 1.0000 s", "b: 1.5000 s (+50 %)")
    assert picture.caption.startswith("Percentages are the gap to the shortest.")


def test_all_references_are_one_picture_as_svg_and_as_file(
    found: ReferenceSet, motion: Trajectory, tmp_path: Path
) -> None:
    picture = references_picture(found, motion, {"the result given": motion.duration})
    assert len(picture.panels) == 4
    names = picture.panels[-1].row_names
    assert len(names) == 2 + 3 + 3 + 1
    assert any(name.startswith("the result given: 2.0000 s") for name in names)
    root = ElementTree.fromstring(draw_picture(picture))
    rows = [node.text for node in root.iter("text") if node.get("class") == "row"]
    assert rows == list(names)
    save_picture(picture, tmp_path / "references.png")
    assert (tmp_path / "references.png").read_bytes()[:4] == b"\x89PNG"
