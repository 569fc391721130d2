"""
Paper A: what energy depends on
===============================

A UR5 returns empty from palletizing (stand-in points). Paper A ranks three methods by energy after 50 generations;
here each gets the same few hundred evaluations, and the audit says who kept the limits.
"""

import ocp_traj as ot

task = ot.load_case("ur5-palletizing")
energies = {}
for solver in ("issa-a@paper", "ssa[population=100]", "pso@paper-a"):
    result = ot.solve(task, solver, seed=1, budget=1500)
    energies[solver] = result.energy
    print(f"{solver:<20} {result.energy:7.2f} J in {result.duration:.3f} s, feasible: {result.feasible}")

assert all(energy > 0 for energy in energies.values())
