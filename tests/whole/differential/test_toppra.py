"""toppra is optimal on a path: never shorter than any motion can be, and its own motion on ours is never longer."""

from __future__ import annotations

import numpy as np
import pytest

import ocp_traj as ot
from helpers.peers.drake import path_parameters
from helpers.peers.toppra import solve_with_toppra
from helpers.public_examples import toppra_kinematics
from ocp_traj.references import kinematic_bound, toppra_reference
from ocp_traj.solvers.gradient.gradient import Gradient


def test_nobody_is_shorter_than_the_certified_bound_on_toppras_example() -> None:
    task = toppra_kinematics()
    bound = kinematic_bound(task, time_limit=2.0, starts=1)
    timed = solve_with_toppra(task, np.linspace(0.0, 1.0, 5), cells_per_gap=200)
    ours = ot.solve(task, Gradient(compiled=False))
    assert ours.feasible and bound.lower is not None
    assert bound.lower <= ours.duration < 0.9 * timed.duration


def test_toppras_excess_over_its_limits_falls_with_the_square_of_its_grid() -> None:
    """Limits hold at the ends of its cells; our audit sees between them."""
    task = toppra_kinematics()
    excess = []
    for cells in (25, 100, 400):
        answer = solve_with_toppra(task, np.linspace(0.0, 1.0, 5), cells_per_gap=cells)
        verdict = ot.audit(task, answer.trajectory)
        assert verdict.waypoint_error < 1e-8 and set(verdict.limits) == {"velocity", "acceleration"}
        excess.append(verdict.limits["acceleration"].ratio - 1.0)
    assert excess[0] < 2e-3 and excess[1] < excess[0] / 8.0 and excess[2] < excess[1] / 8.0


@pytest.mark.parametrize("name", ["uniform", "chord"])
@pytest.mark.parametrize("case", ["machines-2024-490", "yu-2025-four-points"])
def test_toppra_called_directly_agrees_with_our_reference(case: str, name: str) -> None:
    task = ot.load_case(case)
    direct = solve_with_toppra(task, path_parameters(task, name), cells_per_gap=400)
    assert toppra_reference(task, name).duration == pytest.approx(direct.duration, rel=1e-3)


def test_the_path_of_our_motion_cannot_be_driven_faster() -> None:
    """Nearly bang-bang: toppra's timing of that path falls towards ours as its grid gets finer, and stays above."""
    task = ot.load_case("machines-2024-490", ("spline.family='cubic'", "spline.virtual_knots=7"))
    ours = ot.solve(task, Gradient(compiled=False))
    grids = (500, 2000, 4000)
    above = [
        toppra_reference(task, ours.trajectory, points=points).duration - ours.duration for points in grids
    ]
    assert above[0] > above[1] > above[2] > -5e-4 * ours.duration
    assert above[2] < 1.5e-3 * ours.duration
