"""
Waypoint tolerances
===================

Where a point need not be met exactly, a box around it shortens the motion. The tolerance is the half-width of
the box, one for all joints or one each; here the two ends stay exact.
"""

import matplotlib.pyplot as plt
import numpy as np

import ocp_traj as ot

exact = ot.load_case("yu-2025-four-points")
tolerances = np.deg2rad([0.0, 1.0, 3.0, 6.0, 10.0])
durations = []
for tolerance in tolerances:
    box = np.full(exact.waypoints.shape, tolerance)
    box[[0, -1]] = 0.0
    result = ot.solve(exact.changed(tolerance=box))
    assert result.feasible
    durations.append(result.duration)
    print(f"within {np.rad2deg(tolerance):4.1f} deg: {result.duration:.4f} s")

# %%
figure, axis = plt.subplots(layout="constrained", figsize=(6, 3.5))
axis.plot(np.rad2deg(tolerances), durations, "o-")
axis.set_xlabel("tolerance at the inner waypoints, deg")
axis.set_ylabel("duration, s")
print("the first should be close to 7.6752 s, the last to 7.1803 s")

np.testing.assert_allclose([durations[0], durations[-1]], [7.6752, 7.1803], rtol=1e-3)
assert durations == sorted(durations, reverse=True)
