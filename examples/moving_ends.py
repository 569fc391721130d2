"""
Ends that move
==============

A motion need not start or end at rest: here the arm joins a conveyor's motion at its first point and leaves the
last one with a velocity of its own.
"""

import numpy as np

import ocp_traj as ot

task = ot.TrajectoryTask(
    waypoints=[[0.0, 0.0], [0.8, 0.5], [1.5, 0.2]],
    limits=ot.Limits(velocity=1.5, acceleration=4.0, jerk=40.0),
    virtual_knots=3,
    boundary=ot.Boundary(velocity=[[0.5, 0.2], [0.8, -0.3]], acceleration=0.0),
)
result = ot.solve(task)
print(result)

start, end = result.trajectory([0.0, result.duration], derivative=1)
print(f"velocity at the start {start}, should be [0.5 0.2], and at the end {end}, should be [0.8 -0.3]")

# %%
# The same points from rest to rest take longer.
at_rest = ot.solve(task.changed(boundary=ot.Boundary(acceleration=0.0)))
print(
    f"moving ends {result.duration:.4f} s, at rest {at_rest.duration:.4f} s; should be close to 1.2419 and 1.4750 s"
)

np.testing.assert_allclose([start, end], [[0.5, 0.2], [0.8, -0.3]], atol=1e-8)
assert result.feasible and at_rest.feasible
np.testing.assert_allclose([result.duration, at_rest.duration], [1.2419, 1.4750], rtol=2e-3)
