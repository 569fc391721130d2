"""Cases of the literature and small arms for the tests of references and bounds."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.task import Limits, TrajectoryTask

DEGREE = np.pi / 180.0


@pytest.fixture
def machines() -> TrajectoryTask:
    """The four waypoints and limits of paper B (Machines 12(7) 490), Tables 2 and 3."""
    points = [
        [0, 0, -45, 0, 0, 0],
        [0, -30, -30, 30, 0, 0],
        [0, -45, -20, 45, 30, 0],
        [0, -50, -20, 60, 60, 30],
    ]
    limits = Limits(
        velocity=DEGREE * np.array([150.0, 180, 210, 360, 360, 450]),
        acceleration=DEGREE * np.array([93.0, 120, 160, 170, 260, 330]),
    )
    return TrajectoryTask(
        DEGREE * np.array(points, dtype=float), limits, family="3-5-3", name="machines-2024-490"
    )


@pytest.fixture
def fanuc() -> TrajectoryTask:
    """The four waypoints of paper D with the manufacturer's velocities and stand-in accelerations."""
    points = [
        [-23.496, 73.451, -62.949, 77.747, 41.879, -2.099],
        [-20.128, 80.381, -55.208, 78.321, 35.783, -12.636],
        [-7.361, 68.721, -63.179, -35.605, 27.940, 53.129],
        [-8.055, 61.474, -68.520, -29.593, 32.293, 46.917],
    ]
    speed = DEGREE * np.array([210.0, 210, 220, 430, 450, 720])
    limits = Limits(velocity=speed, acceleration=4 * speed)
    return TrajectoryTask(DEGREE * np.array(points), limits, family="3-5-3", name="fanuc-m10id8l")
