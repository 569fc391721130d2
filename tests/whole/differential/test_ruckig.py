"""Ruckig proves its two-point optimum: ours may not beat it, must come near it, and its motions must pass our audit."""

from __future__ import annotations

import numpy as np
import pytest

import ocp_traj as ot
from helpers.peers.ruckig import random_two_point_task, solve_with_ruckig
from ocp_traj.solvers.gradient.gradient import Gradient
from ocp_traj.task import TrajectoryTask

pytest.importorskip("ruckig")

KNOTS = 31
"""Virtual knots: the slowest joint needs 6, but every joint has its own phases and knots are shared."""

SHORTER, LONGER = 1e-6, 5e-3
"""How much shorter than the optimum rounding may make us, and how much longer we may be, relative."""


def compare(task: TrajectoryTask) -> float:
    """Return how much longer our motion is than the proved optimum, relative."""
    optimum = solve_with_ruckig(task)
    assert optimum.trajectory is not None, optimum.message
    verdict = ot.audit(task, optimum.trajectory)
    assert verdict.feasible, verdict.findings
    result = ot.solve(task, Gradient(compiled=False))
    assert result.feasible, result.message
    return result.duration / optimum.trajectory.duration - 1.0


def gaps(seed: int, count: int, *, moving: bool, knots: int = KNOTS) -> np.ndarray:
    rng = np.random.default_rng(seed)
    tasks = [random_two_point_task(rng, 1 + k % 7, moving=moving, virtual_knots=knots) for k in range(count)]
    return np.array([compare(task) for task in tasks])


@pytest.mark.parametrize("moving", [False, True], ids=["at rest", "ends that move"])
def test_random_two_point_motions_match_the_proved_optimum(moving: bool) -> None:
    above = gaps(0 if not moving else 1, 7, moving=moving)
    assert above.min() >= -SHORTER and above.max() <= LONGER


@pytest.mark.parametrize(
    ("moving", "count"),
    [
        pytest.param(False, 50, marks=pytest.mark.slow, id="some at rest"),
        pytest.param(True, 20, marks=pytest.mark.slow, id="some with ends that move"),
        pytest.param(False, 500, marks=pytest.mark.long, id="at rest"),
        pytest.param(True, 200, marks=pytest.mark.long, id="ends that move"),
    ],
)
def test_hundreds_of_two_point_motions_match_the_proved_optimum(moving: bool, count: int) -> None:
    above = gaps(0 if not moving else 1, count, moving=moving)
    quantiles = np.quantile(above, [0.0, 0.5, 0.9, 0.99, 1.0])
    print(f"\n{count} problems, above Ruckig's optimum: least, median, 90 %, 99 %, most: {quantiles}")
    print(f"more than 0.01 % above: {(above > 1e-4).sum()}, more than 0.1 %: {(above > 1e-3).sum()}")
    assert above.min() >= -SHORTER and above.max() <= LONGER


@pytest.mark.slow
def test_more_knots_bring_more_problems_to_the_optimum() -> None:
    """Joints with phases of their own share the knots."""
    above = {knots: gaps(0, 42, moving=False, knots=knots) for knots in (7, 15, KNOTS)}
    missed = [int((values > LONGER).sum()) for values in above.values()]
    print(
        f"\nmore than 0.5 % above, by knots: {dict(zip(above, missed))}; most: {[v.max() for v in above.values()]}"
    )
    assert missed[0] > missed[1] > missed[2] == 0


def test_ruckigs_motion_breaks_a_limit_that_is_made_a_little_tighter() -> None:
    task = random_two_point_task(np.random.default_rng(3), 3, virtual_knots=KNOTS)
    motion = solve_with_ruckig(task).trajectory
    assert motion is not None
    assert not ot.audit(task, motion.scaled(1.0 - 1e-5)).feasible
    assert ot.audit(task, motion.scaled(1.0 + 1e-5)).feasible
