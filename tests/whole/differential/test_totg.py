"""MoveIt's retimer on MoveIt's own tests: its printed durations, its rows within the limits, no bound beaten."""

from __future__ import annotations

import numpy as np
import pytest

import ocp_traj as ot
from helpers.peers.answer import symmetric_limit
from helpers.peers.totg import timed_rows
from helpers.public_examples import moveit_test1, moveit_test3
from ocp_traj.references import kinematic_bound
from ocp_traj.solvers.gradient.gradient import Gradient

PRINTED_TEST1, PRINTED_TEST3 = 40.080256821829849, 1919.5597888812974
"""Durations MoveIt's tests expect, s."""


def test_moveits_two_point_duration_is_the_proved_optimum_and_ours_comes_near() -> None:
    task = moveit_test1()
    bound = kinematic_bound(task)
    optimum = 2.0 / np.sqrt(0.00249)  # half the millimetre speeding up, half braking
    assert bound.lower is not None and bound.lower <= optimum <= PRINTED_TEST1
    assert bound.estimate == pytest.approx(optimum, rel=1e-8)
    ours = ot.solve(task, Gradient(compiled=False))
    assert ours.feasible and bound.estimate * (1 - 1e-6) <= ours.duration <= bound.estimate * 1.002


def test_we_pass_the_points_exactly_in_less_time_than_moveit_needs_to_round_them() -> None:
    task = moveit_test3()
    bound = kinematic_bound(task, time_limit=2.0, starts=1)
    ours = ot.solve(task, Gradient(compiled=False))
    assert ours.feasible and ours.audit.waypoint_error <= 1e-8
    assert bound.lower is not None and bound.lower <= ours.duration < 0.94 * PRINTED_TEST3


def test_the_wheel_computes_what_moveits_tests_print() -> None:
    pytest.importorskip("tesseract_robotics")
    for task, printed in ((moveit_test1(), PRINTED_TEST1), (moveit_test3(), PRINTED_TEST3)):
        rows = timed_rows(task, 100.0)
        assert rows is not None and rows.t[-1] == pytest.approx(printed, rel=1e-5)


@pytest.mark.parametrize("case", ["yu-2025-four-points", "puma560-eight-knots", "machines-2024-490"])
def test_its_rows_keep_the_limits_but_a_rounded_path_is_still_slower(case: str) -> None:
    pytest.importorskip("tesseract_robotics")
    task = ot.load_case(case, ("spline.family='cubic'", "spline.virtual_knots=7", "limits.jerk=inf"))
    task = task.changed(boundary=type(task.boundary)())
    rows = timed_rows(task, 0.1, points_per_gap=20)
    assert rows is not None
    for name, values in (("velocity", rows.v), ("acceleration", rows.a)):
        assert (np.abs(values) / symmetric_limit(task, name)).max() <= 1.0 + 1e-6
    ours = ot.solve(task, Gradient(compiled=False))
    assert ours.feasible and ours.duration < rows.t[-1]
