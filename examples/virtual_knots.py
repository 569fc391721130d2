"""
Virtual knots: down to the bound
================================

With knots at the waypoints only, a spline is far from time-optimal. Free knots inside every gap give it the
freedom to accelerate and brake at the limits: the duration falls to that of the shortest motion whatever
through these points (bang-bang, 1.4839 s).
"""

import matplotlib.pyplot as plt

import ocp_traj as ot

knots = [0, 1, 2, 3, 5, 7]
durations = []
for count in knots:
    task = ot.load_case("machines-2024-490", ["spline.family=cubic", f"spline.virtual_knots={count}"])
    result = ot.solve(task)
    assert result.feasible
    durations.append(result.duration)
    print(f"{count} virtual knots: {result.duration:.4f} s in {result.solution.solve_time:.3f} s of solving")

# %%
figure, axis = plt.subplots(layout="constrained", figsize=(6, 3.5))
axis.plot(knots, durations, "o-", label="cubic spline")
axis.axhline(1.4839, color="black", linewidth=0.8, label="shortest motion with these limits")
axis.set_xlabel("virtual knots in every gap")
axis.set_ylabel("duration, s")
axis.legend()
print("the first should be close to 1.9081 s, the last to 1.4839 s")

assert abs(durations[0] - 1.9081) < 1e-3 and durations[-1] < 1.4850
