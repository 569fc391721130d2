"""pyroboplan's cubics are ours without virtual knots and with free end accelerations: the optimum is the same."""

from __future__ import annotations

import pytest

import ocp_traj as ot
from helpers.peers.pyroboplan import solve_with_pyroboplan
from ocp_traj.solvers.gradient.gradient import Gradient

pytest.importorskip("pyroboplan")

CUBIC = (
    "spline.family='cubic'",
    "spline.virtual_knots=0",
    "boundary.acceleration='free'",
    "limits.jerk=inf",
)


@pytest.mark.parametrize("case", ["machines-2024-490", "yu-2025-four-points"])
def test_without_jerk_limits_both_find_the_same_motion(case: str) -> None:
    task = ot.load_case(case, CUBIC)
    answer = solve_with_pyroboplan(task)
    assert answer.trajectory is not None, answer.message
    ours = ot.solve(task, Gradient(compiled=False))
    assert ours.feasible and ours.duration == pytest.approx(answer.trajectory.duration, rel=1e-5)


def test_its_motion_with_jerk_limits_passes_our_audit_and_is_no_shorter_than_ours() -> None:
    task = ot.load_case("yu-2025-four-points", ("spline.virtual_knots=0", "boundary.acceleration='free'"))
    answer = solve_with_pyroboplan(task)
    assert answer.trajectory is not None, answer.message
    verdict = ot.audit(task, answer.trajectory)
    assert verdict.worst is not None and verdict.worst.ratio <= 1.0 + 1e-5
    ours = ot.solve(task, Gradient(compiled=False))
    assert ours.feasible and ours.duration <= answer.trajectory.duration * (1.0 + 1e-6)
