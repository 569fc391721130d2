"""
Time against energy
===================

The energy of a motion is the integral of all joints' absolute power. Weighing it against time gives a front:
each further joule saved costs more time. Every point starts from the one before.
"""

import matplotlib.pyplot as plt
import numpy as np

import ocp_traj as ot

weights = [0.003, 0.03, 0.06, 0.1]  # seconds a joule is worth
durations, energies = [], []
previous = None
for weight in weights:
    task = ot.TrajectoryTask(
        waypoints=np.deg2rad(
            [[0, -90, 90, -90, -90, 0], [45, -70, 80, -100, -90, 45], [90, -90, 90, -90, -90, 90]]
        ),
        robot=ot.load_robot("ur5"),
        limits=ot.Limits(velocity=2.1, acceleration=5.2, jerk=52.0),
        virtual_knots=3,
        boundary=ot.Boundary(acceleration=0.0),
        objective=ot.Objective(time=1.0, energy=weight),
    )
    result = ot.solve(task, "ipopt", warm_start=previous)
    assert result.feasible
    previous = result.trajectory
    durations.append(result.duration)
    energies.append(result.energy)
    print(f"{weight:5.3f} s/J: {result.energy:.3f} J in {result.duration:.4f} s")

# %%
figure, axis = plt.subplots(layout="constrained", figsize=(6, 3.5))
axis.plot(durations, energies, "o-")
axis.set_xlabel("duration, s")
axis.set_ylabel("energy, J")
print("the ends should be close to 31.39 J in 1.2518 s and 25.78 J in 1.5026 s")

np.testing.assert_allclose([energies[0], energies[-1]], [31.39, 25.78], rtol=5e-3)
assert energies == sorted(energies, reverse=True)
assert all(np.diff(durations) > -1e-3)
