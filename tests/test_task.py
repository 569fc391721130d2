"""Tasks changed in code."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.exceptions import TaskError
from ocp_traj.task import Boundary, Limits, TrajectoryTask

POINTS = [[0.0], [1.0], [0.5], [2.0]]


def test_another_family_brings_its_own_end_conditions():
    task = TrajectoryTask(POINTS, Limits(velocity=1.0), family="3-5-3")
    assert task.boundary.acceleration is not None
    assert task.changed(family="cubic").boundary.acceleration is None
    septic = task.changed(family="septic")
    assert septic.boundary.jerk is not None


def test_given_end_conditions_stay_with_another_family():
    task = TrajectoryTask(POINTS, Limits(velocity=1.0), virtual_knots=2, boundary=Boundary(acceleration=0.0))
    assert np.array_equal(task.changed(family="quintic").boundary.acceleration, np.zeros((2, 1)))


def test_an_unknown_field_is_refused_by_name():
    with pytest.raises(TaskError, match="familly"):
        TrajectoryTask(POINTS).changed(familly="cubic")
