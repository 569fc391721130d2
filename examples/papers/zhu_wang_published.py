"""
Zhu and Wang (paper D): the printed durations before the judge
==============================================================

The paper prints three durations and no limits. With FANUC's own velocities (accelerations are a stand-in) they are
feasible, but only if the sign of one printed angle is mended. The durations could be less than half as long.
"""

import numpy as np
from scipy.spatial.transform import Rotation

import ocp_traj as ot
from ocp_traj.robot import solve_poses
from ocp_traj.transcription import trajectory_from_durations

durations = [0.311, 0.660, 1.676]
mended = ot.load_case("fanuc-m10id8l")
poses = np.array([mended.robot.pose(q) for q in mended.waypoints])
rows = np.hstack([poses[:, :3, 3], Rotation.from_matrix(poses[:, :3, :3]).as_quat()])
again = solve_poses(mended.robot, rows, start=mended.waypoints[0])
print(f"joint points to poses and back: {np.abs(again - mended.waypoints).max():.1e} rad, should be 0")

degrees = np.rad2deg(mended.waypoints).round(3)
degrees[2, 2] = 63.179
printed = ot.load_case("fanuc-m10id8l", overrides=[f"waypoints.joints={degrees.tolist()}"])
verdicts = []
for words, task in (("mended", mended), ("as printed", printed)):
    verdict = ot.audit(task, trajectory_from_durations(task, durations))
    verdicts.append(verdict.feasible)
    print(f"{sum(durations):.3f} s, {words}: feasible {verdict.feasible}, {verdict.worst}")

best = ot.solve(mended, "ipopt")
print(f"shared durations: {best.duration:.4f} s, should be close to 1.2243 s")

assert np.abs(again - mended.waypoints).max() < 1e-9
assert verdicts == [True, False]
assert best.feasible and abs(best.duration - 1.2243) < 1e-3
