"""Drake keeps its limits by the convex-hull property of B-splines: our audit has to agree, and no bound be beaten."""

from __future__ import annotations

import pytest

import ocp_traj as ot
from helpers.peers.drake import solve_with_drake
from ocp_traj.references import kinematic_bound
from ocp_traj.solvers.gradient.gradient import Gradient

pytest.importorskip("pydrake")

SNOPT = 2e-5
"""SNOPT stops at a scaled violation of 1e-6 of its own rows; seen as shares of a limit it is up to this."""


@pytest.mark.parametrize("choice", ["uniform", "chord"])
@pytest.mark.parametrize("case", ["yu-2025-four-points", "fang-2020-task-1"])
def test_drake_keeps_the_limits_and_is_no_shorter_than_ours(case: str, choice: str) -> None:
    task = ot.load_case(case)
    answer = solve_with_drake(task, choice, 24)
    assert answer.trajectory is not None, answer.message
    verdict = ot.audit(task, answer.trajectory)
    assert verdict.waypoint_error < 1e-5 and verdict.worst is not None
    assert 1.0 - 1e-6 <= verdict.worst.ratio <= 1.0 + SNOPT  # minimum time: some limit is reached
    ours = ot.solve(task.changed(virtual_knots=7), Gradient(compiled=False))
    assert ours.feasible and ours.duration <= answer.trajectory.duration * (1.0 + 1e-6)


def test_drake_is_never_below_the_certified_bound() -> None:
    task = ot.load_case("machines-2024-490", ("spline.family='cubic'", "spline.virtual_knots=3"))
    bound = kinematic_bound(task, time_limit=2.0, starts=1)
    ours = ot.solve(task, Gradient(compiled=False))
    for choice in ("uniform", ours.trajectory.waypoint_times):
        answer = solve_with_drake(task, choice, 24, name="")
        assert answer.trajectory is not None, answer.message
        assert bound.lower is not None and answer.trajectory.duration >= bound.lower * (1.0 - SNOPT)
