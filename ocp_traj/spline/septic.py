"""Septic interpolating splines (degree 7): C6, end accelerations and jerks zero by default (paper A)."""

from __future__ import annotations

from ocp_traj.spline.family import UniformFamily


class Septic(UniformFamily):
    """Septic interpolating splines (degree 7): C6, end accelerations and jerks zero by default (paper A)."""

    name = "septic"
    degree = 7
    continuity = 6
