"""
A robot from a DH table
=======================

Kinematics from Denavit-Hartenberg parameters, standard or modified: enough for everything but torque and energy.
The table is paper B's arm, the case its published problem, and the curve its own (3-5-3 polynomials).
"""

import numpy as np

import ocp_traj as ot

robot = ot.robot_from_dh(
    "modified",
    a=[0.0, 0.200, 0.7156, 0.256, 0.0, 0.0],
    alpha=[0, -90, 0, -90, 90, -90],
    d=[0.0, 0.0, -0.0944, 0.8455, 0.0, 0.0838],
    theta=[0, 0, 0, 0, 0, 0],
    unit="deg",
)
task = ot.load_case("machines-2024-490")
print("tool at the first waypoint, m:", robot.pose(task.waypoints[0])[:3, 3].round(4))

# %%
# One set of durations for all joints: 4.3104 s is the best these polynomials can do within the limits.
result = ot.solve(task)
print(result)
print("the duration should be close to 4.3104 s")

# %%
# A cubic spline with three free knots in every gap, at zero end accelerations as well, needs a third of it.
better = ot.solve(task.changed(family="cubic", virtual_knots=3))
print(better)
print("the duration should be below 1.497 s; nothing is below 1.4809 s")

np.testing.assert_allclose(robot.pose(task.waypoints[2]), task.robot.pose(task.waypoints[2]), atol=1e-12)
assert abs(result.duration - 4.3104) < 1e-3 and 1.4809 < better.duration < 1.497
