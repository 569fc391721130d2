"""Problems that peers publish themselves, as tasks; numbers copied from the places named."""

from __future__ import annotations

import numpy as np

from ocp_traj.task import Limits, TrajectoryTask


def toppra_kinematics() -> TrajectoryTask:
    """toppra's examples/plot_kinematics.py: five random points of seven joints (seed 9)."""
    rng = np.random.RandomState(9)  # the generator the example draws from
    waypoints = rng.randn(5, 7)
    limits = Limits(velocity=10 + rng.rand(7) * 20, acceleration=10 + rng.rand(7) * 2)
    return TrajectoryTask(waypoints, limits, virtual_knots=7, name="toppra-kinematics")


def moveit_test1() -> TrajectoryTask:
    """MoveIt's test1 of time-optimal trajectory generation: two points 1 mm apart, expected 40.080256821829849 s."""
    waypoints = [[1424.0, 984.999694824219, 2126.0, 0.0], [1423.0, 985.000244140625, 2126.0, 0.0]]
    limits = Limits(velocity=[1.3, 0.67, 0.67, 0.5], acceleration=0.00249)
    return TrajectoryTask(np.array(waypoints), limits, virtual_knots=7, name="moveit-test1")


def moveit_test3() -> TrajectoryTask:
    """MoveIt's test3 of the same: five points, corners rounded by up to 100, expected 1919.5597888812974 s."""
    waypoints = [
        [1427.0, 368.0, 690.0, 90.0],
        [1427.0, 368.0, 790.0, 90.0],
        [952.499938964844, 433.0, 1051.0, 90.0],
        [452.5, 533.0, 1051.0, 90.0],
        [452.5, 533.0, 951.0, 90.0],
    ]
    limits = Limits(velocity=[1.3, 0.67, 0.67, 0.5], acceleration=0.002)
    return TrajectoryTask(np.array(waypoints), limits, virtual_knots=7, name="moveit-test3")
