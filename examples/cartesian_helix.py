"""
A Cartesian helix
=================

Waypoints can be poses of the tool. The closed-form inverse kinematics of the UR5 has eight branches; the start
position names the one to follow. On it joint 6 does not move at all.
"""

import matplotlib.pyplot as plt
import numpy as np

import ocp_traj as ot

task = ot.load_case("ur5-helix")
print("largest movement of joint 6:", np.ptp(task.waypoints[:, 5]), "rad, should be 0")
result = ot.solve(task)
print(result)
print("the duration should be close to 4.7406 s")

# %%
# The tool passes the nine poses; between them it follows the spline in joint space.
t = np.linspace(0.0, result.duration, 300)
tool = np.array([task.robot.pose(q)[:3, 3] for q in result.trajectory(t)])
points = np.array([task.robot.pose(q)[:3, 3] for q in task.waypoints])
axis = plt.figure(figsize=(5, 5)).add_subplot(projection="3d")
axis.plot(*tool.T)
axis.plot(*points.T, "o")
axis.set(xlabel="x, m", ylabel="y, m", zlabel="z, m")

assert np.ptp(task.waypoints[:, 5]) < 1e-6
assert result.feasible and abs(result.duration - 4.7406) < 5e-3
