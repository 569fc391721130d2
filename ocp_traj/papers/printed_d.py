"""Paper D: the names of its methods and what it prints."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.papers.paper import Paper

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask

IMPROVED, PLAIN, REPAIRED = "PSO of D", "PSO", "PSO of D, repaired"
PUBLISHED = [0.311, 0.660, 1.676]
"""Section 4, seconds."""

UNOPTIMISED = [2.0, 2.0, 2.0]
PRINTED_POINT, MENDED_POINT = "63.179", "-63.179"


def misprinted(paper: Paper) -> TrajectoryTask:
    """Return the task with joint 3's third waypoint as printed."""
    rows = np.rad2deg(paper.task().waypoints).round(3)
    rows[2, 2] = float(PRINTED_POINT)
    return paper.task((f"waypoints.joints={rows.tolist()}",))
