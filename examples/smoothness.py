"""
Smoothness: cubic, quintic, septic
==================================

A cubic spline has steps in its jerk, a quintic has none, a septic one is smooth up to its sixth derivative.
With knots at the waypoints only, smoothness costs time: the degree-7 motion through these eight points takes
about 7.30 s, the cubic one 6.45 s (published for degree 7, by particle swarm: 39.60 s).
"""

import matplotlib.pyplot as plt
import numpy as np

import ocp_traj as ot

figure, axes = plt.subplots(3, 1, layout="constrained", sharey=True, figsize=(7, 6))
found = {}
for axis, family in zip(axes, ("cubic", "quintic", "septic")):
    task = ot.load_case("zou-2024-eight-points", [f"spline.family={family}"])
    result = ot.solve(task)
    found[family] = result.duration
    print(f"{family}: {result.duration:.4f} s, feasible: {result.feasible}")
    t = np.linspace(0.0, result.duration, 1000)
    axis.plot(t, np.rad2deg(result.trajectory(t, derivative=3)))
    axis.set_ylabel(f"{family}\njerk, deg/s³")
axes[-1].set_xlabel("time, s")

assert abs(found["septic"] - 7.302) < 0.005
assert abs(found["cubic"] - 6.450) < 0.001
