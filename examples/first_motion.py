"""
First motion of a UR5
=====================

Ten lines: a robot by name, waypoints, limits, and the shortest motion through them. The robot's own limits of
position, velocity and torque hold as well; the audit checks all of them at every instant.
"""

import matplotlib.pyplot as plt
import numpy as np

import ocp_traj as ot

task = ot.TrajectoryTask(
    waypoints=np.deg2rad(
        [[0, -90, 90, -90, -90, 0], [45, -70, 80, -100, -90, 45], [90, -90, 90, -90, -90, 90]]
    ),
    robot=ot.load_robot("ur5"),
    limits=ot.Limits(velocity=2.0, acceleration=6.0, jerk=60.0),
    virtual_knots=3,
    boundary=ot.Boundary(acceleration=0.0),
)
result = ot.solve(task, "ipopt")
print(result)
print(result.audit)
print("the duration should be close to 1.2187 s")

# %%
# Any derivative at any time: the trajectory is an exact piecewise polynomial.
t = np.linspace(0.0, result.duration, 400)
figure, axes = plt.subplots(2, 1, layout="constrained", sharex=True, figsize=(7, 5))
axes[0].plot(t, result.trajectory(t, derivative=1))
axes[0].set_ylabel("velocity, rad/s")
axes[1].plot(t, result.trajectory(t, derivative=2))
axes[1].set_ylabel("acceleration, rad/s²")
axes[1].set_xlabel("time, s")
axes[0].legend([f"joint {joint + 1}" for joint in range(task.n)], ncol=3, fontsize="small")

assert result.feasible and abs(result.duration - 1.2187) < 1e-3
