"""
Export to ROS 2
===============

A controller gets samples, and interpolates between them. The exporter takes the rate, makes times increase
strictly and slows the samples, if need be, so that limits hold after sampling too.
"""

import numpy as np

import ocp_traj as ot
from ocp_traj.controller_files import sample_for_controller, to_ros2

task = ot.load_case("ur5-torque-limited")
result = ot.solve(task)
samples = sample_for_controller(result.trajectory, rate=125.0, task=task)
text = to_ros2(samples, task.robot.joint_names)
print(text[:700])
print(f"... {len(text.splitlines())} lines; send them with: ros2 action send_goal")

gap = np.abs(samples.q[-1] - task.waypoints[-1]).max()
print(f"the last sample is {gap:.1e} rad from the last waypoint, should be 0")

assert gap < 1e-8 and task.robot.joint_names[0] in text and "time_from_start" in text
