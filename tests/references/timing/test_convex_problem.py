"""The parts the convex timing is made of: redundant rows, scaling, compiling once."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.references.timing.convex_problem import TimingProblem, solve_numbers
from ocp_traj.references.timing.convex_reference import keep_rows, timing_numbers, typical_profile
from ocp_traj.references.timing.half_planes import clip_lines, touching
from ocp_traj.references.timing.path_limits import path_rows
from ocp_traj.references.timing.paths import geometric_path, sample_path
from ocp_traj.references.timing.timing import scale_rows, time_unit
from ocp_traj.task import Boundary, Limits, TrajectoryTask


def thin_rows(rng: np.random.Generator, least: float) -> tuple[np.ndarray, np.ndarray]:
    """Rows as in cells: most limit the difference of both coordinates; some are equal, some are empty."""
    slope = rng.normal(size=(200, 24, 1)) * np.array([30.0, -30.0])
    normals = slope + rng.normal(size=(200, 24, 2))
    normals[:, 20:22] = normals[:, :2]
    normals[:, 22:] = 0.0
    bounds = rng.uniform(least, 1.0, (200, 24))
    bounds[:, 20:22], bounds[:, 22:] = bounds[:, :2], 1.0
    return normals, bounds


@pytest.mark.parametrize("least", [-0.2, -0.01, 0.0, 0.1])
def test_rows_that_touch_are_those_of_the_test_of_all_pairs(least: float) -> None:
    normals, bounds = thin_rows(np.random.default_rng(0), least)
    edges, empty = touching(normals, bounds)
    sides = np.array([[-1.0, 0.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    size = np.linalg.norm(normals, axis=2)
    size[size == 0] = 1.0
    rows = np.concatenate([normals / size[:, :, None], np.broadcast_to(sides, (200, 4, 2))], axis=1)
    offsets = np.concatenate([bounds / size, np.broadcast_to([0, 0, 1e4, 1e4], (200, 4))], axis=1)
    start, end = clip_lines(rows, offsets)
    full = (end >= start - 1e-9) & (np.abs(rows).max(axis=2) > 0)
    assert np.array_equal(edges, full[:, :-4])
    assert np.array_equal(empty, ~full.any(axis=1))
    assert 0 < edges.sum() < 0.7 * edges.size and (empty.any() == (least < 0))


def timing_case(share: float, cells: int = 60) -> tuple:
    points = np.array([[0.0, 0, 0], [1, 2, -1], [3, 1, 0]])
    task = TrajectoryTask(points, Limits(velocity=share, acceleration=2 * share))
    grid = sample_path(geometric_path(task, "chord"), cells)
    rows = path_rows(task, grid)
    unit = time_unit(rows)
    rest = np.zeros(2)
    kept = keep_rows(grid, rows, scale_rows(rows, unit), typical_profile(grid, rest))
    return timing_numbers(grid, kept, rest), unit


def test_moving_rows_gives_what_cvxpy_compiles_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    import cvxpy as cp

    numbers, _ = timing_case(1.0)
    given = numbers.given()
    shapes = tuple((name, value.shape) for name, value in given.items())
    ours = TimingProblem(shapes).solve(given)
    monkeypatch.setattr("ocp_traj.references.timing.convex_problem.timing_solver", lambda: cp.CLARABEL)
    theirs = TimingProblem(shapes).solve(given)
    assert ours.status == theirs.status == "optimal"
    assert ours.objective == pytest.approx(theirs.objective, rel=1e-12)
    assert np.allclose(ours.y, theirs.y, rtol=0, atol=1e-12)
    assert np.allclose(ours.multipliers, theirs.multipliers, rtol=0, atol=1e-10)


def test_the_second_solve_with_other_limits_does_not_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    from cvxpy.reductions.solvers.solving_chain import SolvingChain

    compiled = []
    original = SolvingChain.apply
    monkeypatch.setattr(
        SolvingChain, "apply", lambda self, *args: compiled.append(1) or original(self, *args)
    )
    durations = []
    for share in (1.0, 4.0):
        numbers, unit = timing_case(share, cells=53)  # a number that no other test has compiled before
        problem = solve_numbers(numbers)
        durations.append(problem.objective * unit)
    assert len(compiled) == 1
    assert durations[0] > 1.5 * durations[1]


def test_the_typical_profile_vanishes_with_the_distance_to_rests_and_stays_positive() -> None:
    line = TrajectoryTask(np.array([[0.0], [1.0], [0.0]]), Limits(acceleration=1.0))
    grid = sample_path(geometric_path(line, "uniform"), 400)
    profile = typical_profile(grid, np.zeros(2))
    assert profile.min() > 0 and profile.max() == 1.0
    for place in (0, int(np.flatnonzero(grid.stops)[0]), -1):
        assert profile[place] < 0.1
    moving = TrajectoryTask(
        np.array([[0.0], [1.0]]), Limits(acceleration=1.0), boundary=Boundary(velocity=[[0.5], [0.5]])
    )
    grid = sample_path(geometric_path(moving, "uniform"), 40)
    assert np.array_equal(typical_profile(grid, np.full(2, 0.25)), np.ones(len(grid.s)))
