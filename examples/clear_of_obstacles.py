"""
Clear of obstacles
==================

A motion across a wall is refused, with who touches what and when; one over it is proved clear at every instant.
"""

import numpy as np

import ocp_traj as ot
from ocp_traj.collision import CollisionScene, Shape, Solid

# %%
# A wall between the first waypoint and the last, and a gripper at the tool. Poses are x, y, z and a quaternion.

wall = Solid("wall", Shape("box", (0.3, 0.02, 0.3)), (0.6, 0.1, 0.15, 0, 0, 0, 1), margin=0.01)
floor = Solid("floor", Shape("halfspace", (0, 0, 1, -0.05)))
gripper = Solid("gripper", Shape("capsule", (0.03, 0.08)), (0, 0, 0.05, 0, 0, 0, 1))
scene = CollisionScene((wall, floor), tool=(gripper,))

# %%
# The straight way through joint space runs into the wall.

start, goal = np.deg2rad([[-15, -60, 100, -130, -90, 0], [35, -60, 100, -130, -90, 0]])
limits = ot.Limits(velocity=2.0, acceleration=8.0)
arm = ot.load_robot("ur5")
straight = ot.TrajectoryTask([start, goal], limits, arm, virtual_knots=3, collision=scene)
through = ot.solve(straight)
print(through.audit)
print("the smallest clearance should be about -49 mm, between wrist 1 and the wall")
assert not through.feasible

# %%
# One more waypoint above the wall leads over it.

above = np.deg2rad([10, -105, 60, -45, -90, 0])
over = ot.solve(ot.TrajectoryTask([start, above, goal], limits, arm, virtual_knots=3, collision=scene))
print(over.audit)
print("the duration should be close to 2.0669 s")
assert over.feasible
