"""
Your own URDF
=============

Any serial arm in a URDF file, with a payload in its hand, mounted on the ceiling.
"""

import tempfile
from pathlib import Path

import numpy as np

import ocp_traj as ot

INERTIA = '<inertia ixx="0.01" iyy="0.07" izz="0.07" ixy="0" ixz="0" iyz="0"/>'
LINK = f'<inertial><origin xyz="0.25 0 0"/><mass value="3"/>{INERTIA}</inertial>'
JOINT = '<axis xyz="0 1 0"/><limit lower="-2.5" upper="2.5" velocity="3" effort="60"/>'
URDF = f"""
<robot name="two-links">
  <link name="base"/>
  <link name="upper">{LINK}</link>
  <link name="lower">{LINK}</link>
  <link name="hand"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>{JOINT}</joint>
  <joint name="elbow" type="revolute"><origin xyz="0.5 0 0"/><parent link="upper"/><child link="lower"/>{JOINT}</joint>
  <joint name="wrist" type="fixed"><origin xyz="0.5 0 0"/><parent link="lower"/><child link="hand"/></joint>
</robot>
"""
with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "arm.urdf"
    path.write_text(URDF)
    robot = ot.robot_from_urdf(path, tool="hand")

payload = ot.Payload(mass=2.0, com=[0.0, 0.0, 0.05])
ceiling = robot.with_changes(gravity=[0.0, 0.0, 9.81], payload=payload)
limits = ot.Limits(acceleration=60.0)  # position, velocity and torque are the robot's own
durations = {}
for name, arm in {"bare, on the floor": robot, "loaded, on the ceiling": ceiling}.items():
    task = ot.TrajectoryTask([[0.0, 0.0], [0.6, -0.8], [1.2, 0.3]], limits, arm, virtual_knots=3)
    result = ot.solve(task)
    durations[name] = result.duration
    print(
        f"{name}: {result.duration:.4f} s, feasible: {result.feasible}, closest limit: {result.audit.worst}"
    )
    assert result.feasible
print("the durations should be close to 0.7583 and 0.9127 s")
assert np.allclose(list(durations.values()), [0.7583, 0.9127], rtol=2e-3)
