"""Certificates prove nothing that is false: bounds of random cells against exact totals inside them."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.arrays import Array
from ocp_traj.references import certify
from ocp_traj.references.bounds.certify import SplineBounds, exact_total
from ocp_traj.task import Limits, TrajectoryTask

UNREACHED = 1e9


def corner_cells(rng: np.random.Generator, count: int, gaps: int) -> tuple[Array, Array, Array]:
    """Return proportions on the simplex, and cells of which they are a corner in all coordinates but one.

    The centres of the cells are not on the simplex.
    """
    points = 0.06 + (1 - 0.06 * gaps) * rng.dirichlet(np.ones(gaps), count)
    width = 10 ** rng.uniform(-4, -1.2, (count, 1)) * rng.uniform(0.3, 1.0, (count, gaps))
    share = rng.integers(0, 2, (count, gaps)).astype(float)
    inner = rng.integers(0, gaps, count)
    share[np.arange(count), inner] = rng.random(count)
    lows = np.maximum(points - share * width, 0.5 * points)
    return points, lows, np.maximum(points + (1 - share) * width, points)


def task_of(family: str, seed: int) -> TrajectoryTask:
    points = np.random.default_rng(seed).normal(size=(4, 2))
    jerk = 8.0 if family != "3-5-3" else np.inf
    limits = Limits(velocity=1.0, acceleration=1.5, jerk=jerk)
    return TrajectoryTask(points, limits, family=family, virtual_knots=0)


def assert_bounds_hold(task: TrajectoryTask, seed: int, count: int) -> None:
    spline = SplineBounds(task)
    points, lows, highs = corner_cells(np.random.default_rng(seed), count, task.gaps)
    bounds = spline.bound(lows, highs, np.zeros(count), UNREACHED)
    assert (bounds > 0).mean() > 0.5
    sampled, _ = spline.totals(points)  # 65 instants a piece: never above the exact total
    suspects = np.flatnonzero(bounds > sampled)
    for index in suspects:
        assert bounds[index] <= exact_total(task, spline, points[index]) * (1 + 1e-12)


@pytest.mark.parametrize("family", ["cubic", "quintic", "3-5-3"])
def test_no_exact_total_is_below_the_bound_of_its_cell(family: str) -> None:
    for seed in range(3):
        assert_bounds_hold(task_of(family, seed), seed, 1500)


def test_no_exact_total_of_a_case_is_below_the_bound_of_its_cell(
    machines: TrajectoryTask, fanuc: TrajectoryTask
) -> None:
    assert_bounds_hold(machines, 7, 3000)
    assert_bounds_hold(fanuc, 8, 3000)


def test_the_cell_whose_centre_lies_off_the_simplex_keeps_its_best_motion(machines: TrajectoryTask) -> None:
    low = np.array([[0.36658148, 0.34923666, 0.28180922]])
    high = np.array([[0.36780636, 0.35046153, 0.28295699]])
    spline = SplineBounds(machines)
    rng = np.random.default_rng(0)
    inside = low + rng.random((4000, 3)) * (high - low)
    inside[:, 2] = 1.0 - inside[:, 0] - inside[:, 1]
    inside = inside[(inside[:, 2] >= low[0, 2]) & (inside[:, 2] <= high[0, 2])]
    best = inside[spline.totals(inside)[0].argmin()]
    total = exact_total(machines, spline, best)
    assert total == pytest.approx(4.798891, abs=1e-3)
    assert spline.bound(low, high, np.zeros(1), UNREACHED)[0] <= total


@pytest.mark.parametrize("excess", [1e-3, 1e-2])
def test_a_target_above_the_optimum_is_not_reached(fanuc: TrajectoryTask, excess: float) -> None:
    result = certify(fanuc, gap=-excess, largest_nodes=3000)
    assert not result.certified
    assert result.lower is not None and result.upper is not None and result.lower <= result.upper
