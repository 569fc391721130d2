"""What references say on request (bounded jerk, certificates), and what they say where there is nothing to say."""

from __future__ import annotations

import logging

import numpy as np
import pytest

import ocp_traj.references as package
from ocp_traj.references import collect_references, toppra_reference
from ocp_traj.references.timing.result import ReferenceResult
from ocp_traj.references.timing.toppra_reference import LARGEST_GRID, refine
from ocp_traj.task import Boundary, Limits, TrajectoryTask


def line(**changes) -> TrajectoryTask:
    """One joint, one rad, from rest to rest."""
    limits = {"velocity": 1.0, "acceleration": 2.0, "jerk": 20.0, **changes.pop("limits", {})}
    return TrajectoryTask(np.array([[0.0], [1.0]]), Limits(**limits), name="line", **{"virtual_knots": 0, **changes})


def test_bounded_jerk_takes_longer_than_the_bound_and_is_told_by_path() -> None:
    found = collect_references(line(), convex=False, jerk=True, time_limit=1e9)
    table = found.to_json()
    assert set(table["jerk_estimate"]) == {"estimate", "uniform", "chord"}
    # The ends may have any acceleration: 0.45 s at 2 rad/s^2 and 0.1 s of jerk reach 1 rad/s after 0.29917 rad; the
    # same at the end, and 0.40167 s in between.
    assert table["jerk_estimate"]["estimate"] == pytest.approx(1.1 + 0.401667, rel=1e-4)
    assert table["jerk_estimate"]["uniform"] == pytest.approx(1.1 + 0.401667, rel=2e-2)
    assert 1.5 * (1 - 2e-3) <= table["kinematic_bound"]["lower"] <= 1.5
    assert found.messages()["jerk_estimate"] == found.jerk.message
    assert table["convex"] == {"uniform": None, "chord": None}


def test_why_there_is_no_estimate_with_bounded_jerk_is_told() -> None:
    found = collect_references(line(boundary=Boundary(velocity=[[0.2], [0.0]])), jerk=True, time_limit=1e9)
    assert found.jerk is None and "jerk_estimate" not in found.to_json()
    assert found.messages()["jerk_estimate"] == found.findings["jerk_estimate"].messages[""] != ""


def test_a_certificate_is_told_with_its_proof() -> None:
    task = TrajectoryTask(
        np.array([[0.0], [1.0]]), Limits(velocity=1.0, acceleration=2.0), family="cubic", virtual_knots=0, name="cubic"
    )
    found = collect_references(task, convex=False, certificate=True, time_limit=1e9)
    table = found.to_json()
    # a cubic from rest to rest: largest velocity 1.5 / T, largest acceleration 6 / T^2
    assert table["certificate"]["upper"] == pytest.approx(np.sqrt(3.0), rel=1e-3)
    assert table["certificate"]["lower"] <= table["certificate"]["upper"]
    assert table["messages"]["certificate"] == found.certificate.message


def test_paths_that_cannot_be_timed_are_logged(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "ocp_traj"):
        collect_references(TrajectoryTask(np.array([[0.0], [1.0]]), Limits()), convex=False, time_limit=1e9)
    assert "toppra on the path uniform: no velocity, acceleration or torque limit" in caplog.text


def test_a_duration_that_never_settles_is_told(caplog: pytest.LogCaptureFixture) -> None:
    asked = []

    def solve(cells: int) -> ReferenceResult:
        asked.append(cells)
        return ReferenceResult("toppra", "mine", 1.0 + len(asked) % 2)

    with caplog.at_level(logging.WARNING, "ocp_traj"):
        result = refine(solve, 1e-3, None)
    assert asked[-1] == LARGEST_GRID and result.duration is not None
    assert (
        f"mine path: the duration still changes by more than 0.001 with {LARGEST_GRID} cells" in caplog.text
    )


def test_a_path_without_a_timing_has_none_with_a_wanted_duration_either() -> None:
    task = TrajectoryTask(np.array([[0.0], [1.0]]), Limits())
    assert (
        toppra_reference(task, "chord", duration=3.0).reason == toppra_reference(task, "chord").reason != ""
    )


def test_moving_ends_cannot_be_slowed() -> None:
    task = line(boundary=Boundary(velocity=[[0.2], [0.0]]))
    result = toppra_reference(task, "chord", duration=5.0)
    assert result.duration is None
    assert result.reason.endswith("but with moving ends the motion cannot be slowed")


def test_the_package_lists_what_it_has_and_names_what_it_has_not() -> None:
    assert set(dir(package)) >= {"kinematic_bound", "certify", "toppra_reference"}
    with pytest.raises(AttributeError, match="has no attribute 'magic'"):
        package.magic
