"""
Zhang et al. 2022 (paper C): a helix, one branch of eight, and Tent chaos
=========================================================================

The paper drives a UR5 through Cartesian points of a helix. Along a path without singularities only the branch of one
unique domain has to be computed instead of eight: the same joint positions for less work. Its search starts from a
Tent-chaos population, said to fill [0, 1] more evenly than pseudo-random numbers. Limits and height are stand-ins.
"""

import numpy as np

import ocp_traj as ot
from metaheuristics.algorithms.chaos import draw_tent, measure_uniformity
from ocp_traj.robot.inverse_kinematics.domain_timing import measure_domain_timing

task = ot.load_case("ur5-helix")
poses = np.array([task.robot.pose(q) for q in task.waypoints])
timing = measure_domain_timing(task.robot, poses, task.waypoints[0], [6, 5, 4, 3, 2, 1])
print(
    f"one domain saves {100 * timing.saving:.0f} % of the inverse kinematics' time; the paper reports 39.76 %"
)
print(f"joint 6 travels {np.ptp(task.waypoints[:, 5]):.0e} rad, should be 0")

own = ot.solve(task, "tadf-ssa@paper-tadf-ssa", seed=0, budget=8900)
best = ot.solve(task, "ipopt")
print(
    f"TADF-SSA, 80 generations: {own.duration:.3f} s; IPOPT: {best.duration:.4f} s, should be close to 4.7406 s"
)

rng = np.random.default_rng(0)
tent = np.median([measure_uniformity(draw_tent(1, 1000, rng)[0])[1] for _ in range(200)])
plain = np.median([measure_uniformity(rng.random(1000))[1] for _ in range(200)])
print(
    f"chi-square over ten bins, median of 200: Tent {tent:.1f}, pseudo-random {plain:.1f}, should be about 8.3"
)

assert timing.saving > 0
assert np.ptp(task.waypoints[:, 5]) < 1e-6
assert best.feasible and abs(best.duration - 4.7406) < 1e-3 and own.duration > best.duration
assert tent < plain + 1 and abs(plain - 8.3) < 1.5
