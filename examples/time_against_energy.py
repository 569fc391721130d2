"""
Time against energy
===================

The energy a motion costs, the integral of all joints' absolute power, falls with the time it may take, up to a point:
after that, holding the arm against gravity on the way costs the same however slowly it moves. Each point is the
energy-optimal septic spline within a given duration, started from the one before.
"""

import matplotlib.pyplot as plt

import ocp_traj as ot

durations = [2.4, 2.8, 3.4, 4.0]
energies = []
previous = None
for duration in durations:
    task = ot.load_case("ur5-palletizing", [f"objective.bounds.duration=[0.1, {duration}]"])
    result = ot.solve(task, "ipopt", warm_start=previous)
    assert result.feasible
    previous = result.trajectory
    energies.append(result.energy)
    print(f"at most {duration:.1f} s: {result.energy:.3f} J in {result.duration:.3f} s")

# %%
figure, axis = plt.subplots(layout="constrained", figsize=(6, 3.5))
axis.plot(durations, energies, "o-")
axis.set_xlabel("allowed duration, s")
axis.set_ylabel("energy, J")

assert energies == sorted(energies, reverse=True)
