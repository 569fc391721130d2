"""
An objective and a limit of your own
====================================

Both are CasADi functions of (q, v, a, tau) at one instant; gradient and population solvers, the audit and the
energy account all take them. Here the hand must stay below a shelf at 0.232 m, and the elbow is kept calm.
"""

import casadi as ca
import matplotlib.pyplot as plt
import numpy as np

import ocp_traj as ot

robot = ot.load_robot("ur5")
q, v, a, tau = (ca.SX.sym(name, robot.n) for name in ("q", "v", "a", "tau"))
height = ca.Function("height", [q, v, a, tau], [robot.symbolic.pose()(q)[2, 3]])
calm_elbow = ca.Function("calm_elbow", [q, v, a, tau], [a[2] ** 2])

free = ot.TrajectoryTask(
    waypoints=np.deg2rad([[0, -20, 40, -110, -90, 0], [60, -100, 130, -120, -90, 0]]),
    limits=ot.Limits(velocity=2.0, acceleration=5.0, jerk=50.0),
    robot=robot,
    virtual_knots=4,
)
shelf = 0.232
bounded = free.changed(
    constraints=(ot.CustomConstraint("height", height, upper=shelf),),
    objective=ot.Objective(time=1.0, custom=(ot.CustomObjective("calm elbow", calm_elbow, weight=1e-4),)),
)
results = {"free": ot.solve(free), "bounded": ot.solve(bounded)}
for name, result in results.items():
    print(f"{name}: {result.duration:.4f} s, objective {result.objective:.4f}, feasible: {result.feasible}")

# %%
# Joint 1 decides the duration, so the shelf costs no time: the other joints go round it.
figure, axis = plt.subplots(layout="constrained", figsize=(6, 3.5))
highest = {}
for name, result in results.items():
    t = np.linspace(0.0, result.duration, 300)
    tool = [robot.pose(q)[2, 3] for q in result.trajectory(t)]
    highest[name] = max(tool)
    axis.plot(t, tool, label=name)
axis.axhline(shelf, color="black", linewidth=0.8)
axis.set(xlabel="time, s", ylabel="height of the tool, m")
axis.legend()

print(
    f"highest: free {highest['free']:.4f} m, bounded {highest['bounded']:.4f} m, should be close to {shelf} m"
)

assert all(result.feasible for result in results.values())
assert highest["free"] > shelf + 0.01 and highest["bounded"] < shelf + 1e-6
