"""
Torque limits
=============

The same points at full torque and at 30 % of it. Between its samples a torque can exceed its limit: the solver
adds points where that happens, and the audit measures the torque of the answer with Pinocchio's own algorithm.
"""

import matplotlib.pyplot as plt
import numpy as np

import ocp_traj as ot

limited = ot.load_case("ur5-torque-limited")
rated = ot.load_case("ur5-torque-limited", ["limits.torque=[150, 150, 150, 28, 28, 28]"])
results = {"30 % of the rated torque": ot.solve(limited), "rated torque": ot.solve(rated)}
for name, result in results.items():
    print(
        f"{name}: {result.duration:.4f} s, feasible: {result.feasible}, closest limit: {result.audit.worst}"
    )

# %%
# Joint 2 carries the arm; its torque is the one that decides.
figure, axis = plt.subplots(layout="constrained", figsize=(7, 3.5))
for name, result in results.items():
    t = np.linspace(0.0, result.duration, 500)
    q, v, a = (result.trajectory(t, derivative=order) for order in range(3))
    axis.plot(t, limited.robot.torque(q, v, a)[:, 1], label=name)
axis.axhline(45.0, color="black", linewidth=0.8)
axis.axhline(-45.0, color="black", linewidth=0.8)
axis.set_xlabel("time, s")
axis.set_ylabel("torque of joint 2, N m")
axis.legend()
print("the durations should be close to 1.1593 and 1.0417 s")

assert all(result.feasible for result in results.values())
assert np.allclose([result.duration for result in results.values()], [1.1593, 1.0417], rtol=5e-3)
