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
expected = {"cubic": 6.450, "quintic": 7.728, "septic": 7.304}
for axis, family in zip(axes, expected):
    task = ot.load_case("zou-2024-eight-points", [f"spline.family={family}", "spline.virtual_knots=0"])
    result = ot.solve(task)
    found[family] = result.duration
    print(f"{family}: {result.duration:.4f} s, should be close to {expected[family]} s")
    assert result.feasible
    t = np.linspace(0.0, result.duration, 1000)
    axis.plot(t, np.rad2deg(result.trajectory(t, derivative=3)))
    axis.set_ylabel(f"{family}\njerk, deg/s³")
axes[-1].set_xlabel("time, s")

assert all(abs(found[family] - expected[family]) < 0.003 for family in expected)
