"""
Measurement and Control 2023 (paper A): what energy depends on
==============================================================

A UR5 returns empty from palletizing (stand-in points: the printed ones are lost). The joint points go through forward
and inverse kinematics and back. Then the paper's three methods spend a fifth of their 50 generations, and
IPOPT its few iterations. The paper ranks ISSA before SSA before PSO; the audit says who kept the limits at all.
"""

import numpy as np
from scipy.spatial.transform import Rotation

import ocp_traj as ot
from ocp_traj.robot import solve_poses

task = ot.load_case("ur5-palletizing")
points = np.array([task.robot.pose(q) for q in task.waypoints])
rows = np.hstack([points[:, :3, 3], Rotation.from_matrix(points[:, :3, :3]).as_quat()])
again = solve_poses(task.robot, rows, start=task.waypoints[0])
print(f"joint points to poses and back: {np.abs(again - task.waypoints).max():.1e} rad, should be 0")

energies = {}
for solver, budget in (("issa-a@paper", 1300), ("ssa[population=100]", 1200), ("pso@paper-a", 1100)):
    result = ot.solve(task, solver, seed=1, budget=budget)
    energies[solver] = result.energy if result.feasible else np.inf
    kept = "keeps every limit" if result.feasible else f"is not feasible (largest ratio {result.audit.worst.ratio:.4f})"
    print(f"{solver:<20} {result.energy:6.2f} J, {kept}")
best = ot.solve(task, "ipopt")
print(f"{'ipopt':<20} {best.energy:6.2f} J, should be close to 36.91 J")

assert np.abs(again - task.waypoints).max() < 1e-9
assert abs(best.energy - 36.91) < 0.05 and best.feasible
assert all(best.energy <= energy for energy in energies.values())
