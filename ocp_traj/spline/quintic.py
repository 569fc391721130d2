"""Quintic interpolating splines: C4, end accelerations zero by default."""

from __future__ import annotations

from ocp_traj.spline.family import UniformFamily


class Quintic(UniformFamily):
    """Quintic interpolating splines: C4, end accelerations zero by default."""

    name = "quintic"
    degree = 5
    continuity = 4
