"""
Paper D: the printed durations before the judge
===============================================

Paper D prints three durations and no limits. With FANUC's own velocities (accelerations are a stand-in) they are
feasible, but only if the sign of one printed angle is mended.
"""

import numpy as np

import ocp_traj as ot
from ocp_traj.transcription import trajectory_from_durations

durations = [0.311, 0.660, 1.676]
mended = ot.load_case("fanuc-m10id8l")
points = np.rad2deg(mended.waypoints).round(3)
points[2, 2] = 63.179
printed = ot.load_case("fanuc-m10id8l", overrides=[f"waypoints.joints={points.tolist()}"])
for words, task in (("mended", mended), ("as printed", printed)):
    verdict = ot.audit(task, trajectory_from_durations(task, durations))
    print(
        f"{words}: feasible {verdict.feasible}, largest ratio {verdict.worst.ratio:.4f} ({verdict.worst.limit})"
    )

assert ot.audit(mended, trajectory_from_durations(mended, durations)).feasible
assert not ot.audit(printed, trajectory_from_durations(printed, durations)).feasible
