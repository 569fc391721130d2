"""The numbers of the judge: what a motion may exceed, miss and jump by.

None of them depends on the length or the degree of a piece. The jumps of a motion are added up: one that is cut
into a million pieces may jump no more in all than one of a single piece.
"""

from __future__ import annotations

RATIO_TOLERANCE = 1e-6
"""A motion is feasible when every ratio is at most 1 plus this."""

WAYPOINT_TOLERANCE = 1e-8
"""A waypoint's box may be missed by this, rad or m."""

BOUNDARY_TOLERANCE = 1e-8
"""A boundary condition may be missed by this fraction of the limit, or of the motion's largest value."""

DURATION_TOLERANCE = 1e-9
"""A bound on a duration may be missed by this fraction of it."""

POSITION_JUMPS = 1e-9
"""All jumps of a joint's position together, rad or m."""

VELOCITY_JUMPS = 1e-8
"""All jumps of a joint's velocity together, as a fraction of the limit (of the motion's largest value)."""

ACCELERATION_JUMPS = 1e-6
"""All jumps of a joint's acceleration together, as a fraction of the limit (of the motion's largest value)."""

JUMPS = (POSITION_JUMPS, VELOCITY_JUMPS, ACCELERATION_JUMPS)
"""The same by order of derivative."""
