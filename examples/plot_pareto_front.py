"""
The whole front of time against energy
======================================

How much energy does a slower motion save? `pareto_front` finds the shortest motion and then, for longer and longer
bounds on the duration, the motion with the least energy, each started from its neighbour. Every point is audited.
The command line does the same: ``ocp-traj pareto CASE --plot front.png``.
"""

import matplotlib.pyplot as plt
import numpy as np

import ocp_traj as ot

task = ot.TrajectoryTask(
    waypoints=np.deg2rad([[0, -90, 90, -90, -90, 0], [45, -70, 80, -100, -90, 45]]),
    robot=ot.load_robot("ur5"),
    limits=ot.Limits(velocity=2.1, acceleration=5.2),
    virtual_knots=2,
    boundary=ot.Boundary(acceleration=0.0),
    name="lift",
)
front = ot.pareto_front(task, points=6, objective="energy", slowest=1.8)
print(front)
print("a slower motion should be no dearer")
assert front.feasible.all()
assert (np.diff(front.values) <= 0).all()  # slower is never dearer along a front
assert front.values[-1] < front.values[0]

# %%
# Smoothness needs no masses: the integral of squared accelerations falls with the third power of the duration.
smooth = ot.pareto_front(task, points=6, objective="acceleration", slowest=1.8)
figure, axes = plt.subplots(1, 2, layout="constrained", figsize=(8, 3.2))
for axis, each in zip(axes, (front, smooth)):
    axis.plot(each.durations[each.efficient], each.values[each.efficient], "o-")
    axis.set_xlabel("duration, s")
    axis.set_ylabel(f"{each.quantity}, {each.unit}")
