"""The judge on a hand-computed motion."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.audit import audit
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory


def test_a_rest_to_rest_cubic_has_its_known_peaks() -> None:
    # q = 3 x^2 - 2 x^3 with x = t / 2: velocity 3/4 at 1 s, acceleration 3/2 at the ends, jerk -3/2
    trajectory = Trajectory([0.0, 2.0], [[[0.0, 0.0, 0.75, -0.25]]], [0.0, 2.0])
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=1.5, acceleration=3.0, jerk=3.0))
    verdict = audit(task, trajectory)
    assert verdict.feasible
    assert {name: peak.ratio for name, peak in verdict.limits.items()} == pytest.approx(
        {"velocity": 0.5, "acceleration": 0.5, "jerk": 0.5}
    )
    assert verdict.limits["velocity"].time == pytest.approx(1.0)
    assert verdict.smallest_feasible_scale == pytest.approx(0.5 ** (1 / 3))
    assert np.isfinite(verdict.waypoint_error)
