"""Timings and estimates with bounded jerk."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.exceptions import InputError
from ocp_traj.references import jerk_estimate, jerk_limited_reference
from ocp_traj.task import Boundary, Limits, TrajectoryTask

DEGREE = np.pi / 180.0


def fang() -> TrajectoryTask:
    """Fang et al. (2020), Tables 2 to 4: the shortest time with bounded jerk is 4.000 s."""
    points = [[-10.0, 20, 15, 150, 30, 120], [55, 35, 30, 10, 70, 25]]
    limits = Limits(
        velocity=DEGREE * np.array([100.0, 95, 100, 150, 130, 110]),
        acceleration=DEGREE * np.array([60.0, 60, 75, 70, 90, 80]),
        jerk=DEGREE * np.array([60.0, 66, 85, 70, 75, 70]),
    )
    boundary = Boundary(acceleration=0.0)
    return TrajectoryTask(DEGREE * np.array(points), limits, virtual_knots=7, boundary=boundary)


def test_estimate_of_fang_is_four_seconds() -> None:
    assert jerk_estimate(fang()).estimate == pytest.approx(4.0, abs=1e-6)


def test_jerk_alone_gives_the_closed_form() -> None:
    # from rest to rest with zero end accelerations: T = (32 d / J)^(1/3)
    task = TrajectoryTask(
        np.array([[0.0], [1.0]]), Limits(jerk=2.0), virtual_knots=3, boundary=Boundary(acceleration=0.0)
    )
    assert jerk_estimate(task, knots=3).estimate == pytest.approx(16 ** (1 / 3), rel=1e-6)


def test_timing_of_a_line_approaches_the_known_optimum_from_near() -> None:
    result = jerk_limited_reference(fang(), "chord", points=150)
    # discretisation of the first order: 3.926 s with 150 cells, 3.961 s with 300
    assert result.duration == pytest.approx(4.0, rel=0.03)
    assert result.largest_ratio <= 1 + 1e-6


def test_jerk_needs_a_jerk_limit_and_rest() -> None:
    task = TrajectoryTask(np.array([[0.0], [1.0]]), Limits(acceleration=1.0))
    for function in (jerk_estimate, jerk_limited_reference):
        with pytest.raises(InputError, match="the task has no jerk limit"):
            function(task)
        moving = task.changed(limits=Limits(jerk=1.0), boundary=Boundary(velocity=[[0.1], [0.0]]))
        with pytest.raises(InputError, match="an end is not at rest"):
            function(moving)
    with pytest.raises(InputError, match="knots is 0, expected 1 or more"):
        jerk_estimate(fang(), knots=0)
