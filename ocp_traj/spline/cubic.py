"""Cubic splines: C2, piecewise constant jerk (paper C; clamped, end accelerations free by default)."""

from __future__ import annotations

from ocp_traj.spline.family import UniformFamily


class Cubic(UniformFamily):
    """Cubic splines: C2, piecewise constant jerk (paper C; clamped, end accelerations free by default)."""

    name = "cubic"
    degree = 3
    continuity = 2
