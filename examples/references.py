"""
How far from the best? TOPP-RA, convex timing, lower bound
==========================================================

Three answers to "could it be faster?": the fastest timing of a fixed path through the waypoints by two
independent methods, and a bound that no motion whatever through these points can beat.
"""

import ocp_traj as ot
from ocp_traj.references import convex_reference, kinematic_bound, toppra_reference

task = ot.load_case("machines-2024-490", ["spline.family=cubic", "spline.virtual_knots=3"])
result = ot.solve(task)
print(f"our motion: {result.duration:.4f} s")

timings = {}
for path in ("uniform", "chord"):
    timings[path] = [reference(task, path).duration for reference in (toppra_reference, convex_reference)]
    print(f"{path} path: TOPP-RA {timings[path][0]:.4f} s, convex {timings[path][1]:.4f} s")

# %%
# Our own spline's path, driven as fast as it allows: nothing is left to gain on it.
own = toppra_reference(task, result.trajectory)
print(f"our own path: TOPP-RA {own.duration:.4f} s, should be close to {result.duration:.4f} s")

# %%
# The bound is certified where a proof was reached, and says so.
bound = kinematic_bound(task, time_limit=2.0)
print(f"no motion is shorter than {bound.lower:.4f} s; the best known one takes {bound.estimate:.4f} s")

assert abs(own.duration / result.duration - 1) < 1e-3
assert all(abs(toppra / convex - 1) < 1e-3 for toppra, convex in timings.values())
assert bound.lower <= bound.estimate <= result.duration + 1e-6 < min(timings["uniform"])
