"""
Auditing a published result
===========================

Paper D prints its durations: 0.311, 0.660 and 1.676 s, 2.647 s in all, 56 % below 6 s. Its limits are not
printed, so this case has FANUC's velocities and a stand-in for the accelerations (full speed in 0.25 s). Does
the printed motion keep them, and how much faster could it be run?
"""

import ocp_traj as ot

task = ot.load_case("fanuc-m10id8l")
published = ot.trajectory_from_durations(task, [0.311, 0.660, 1.676])
verdict = ot.audit(task, published)
print(verdict)
print(
    f"run uniformly, it could take {published.duration * verdict.smallest_feasible_scale:.4f} s, should be 2.5518 s"
)

# %%
# The best durations for the same polynomials and limits:
best = ot.solve(task)
print(best)
print("the duration should be close to 1.2243 s")

assert abs(published.duration * verdict.smallest_feasible_scale - 2.5518) < 1e-4
assert best.feasible and abs(best.duration - 1.2242) < 1e-3
