"""Solved motions, rebuilt by SciPy from their knots alone."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, make_interp_spline

import ocp_traj as ot
from ocp_traj.solvers.gradient.gradient import Gradient
from ocp_traj.task import Boundary


@pytest.mark.parametrize("knots", [0, 1, 3])
def test_a_solved_cubic_is_scipys_cubic_spline_through_its_knots(knots: int) -> None:
    task = ot.load_case(
        "yu-2025-four-points", (f"spline.virtual_knots={knots}", "boundary.acceleration='free'")
    )
    motion = ot.solve(task, Gradient(compiled=False)).trajectory
    again = CubicSpline(motion.breakpoints, motion(motion.breakpoints), bc_type="clamped")
    t = np.linspace(0.0, motion.duration, 2001)
    for order in range(3):
        limit = np.abs(motion(t, order)).max()
        np.testing.assert_allclose(motion(t, order), again(t, order), atol=1e-8 * limit)


@pytest.mark.parametrize(("family", "degree"), [("quintic", 5), ("septic", 7)])
def test_a_solved_smooth_spline_is_scipys_with_zero_end_derivatives(family: str, degree: int) -> None:
    task = ot.load_case("zou-2024-eight-points", (f"spline.family={family!r}", "spline.virtual_knots=0"))
    task = task.changed(boundary=Boundary())
    motion = ot.solve(task, Gradient(compiled=False)).trajectory
    rest = [(order, np.zeros(task.n)) for order in range(1, degree // 2 + 1)]
    again = make_interp_spline(motion.breakpoints, motion(motion.breakpoints), k=degree, bc_type=(rest, rest))
    t = np.linspace(0.0, motion.duration, 2001)
    for order in range(4):
        limit = np.abs(motion(t, order)).max()
        np.testing.assert_allclose(motion(t, order), again(t, order), atol=1e-7 * limit)
