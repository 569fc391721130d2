"""What the references cost and prove; printed with ``pytest tests/benchmarks/test_references.py -s -m ''``.

Times are printed, never asserted; durations and bounds are.
"""

from __future__ import annotations

import time

import numpy as np
import pytest

from ocp_traj.case import load_case
from ocp_traj.references import (
    certify,
    convex_reference,
    jerk_estimate,
    jerk_limited_reference,
    kinematic_bound,
    toppra_reference,
)
from ocp_traj.robot import load_robot
from ocp_traj.task import Limits, TrajectoryTask

pytestmark = pytest.mark.long

KINEMATIC = (
    "machines-2024-490",
    "fanuc-m10id8l",
    "fang-2020-task-1",
    "yu-2025-four-points",
    "zou-2024-eight-points",
)


@pytest.mark.parametrize("name", [*KINEMATIC, "puma560-eight-knots"])
def test_kinematic_bound(name: str) -> None:
    began = time.process_time()
    bound = kinematic_bound(load_case(name), time_limit=120.0)
    seconds = time.process_time() - began
    print(
        f"\n{name}: lower {bound.lower:.6f} estimate {bound.estimate:.6f} s, {bound.nodes} cells, {seconds:.1f} s CPU"
    )
    assert bound.lower <= bound.estimate
    if name == "machines-2024-490":
        assert bound.lower >= 1.469 and bound.estimate == pytest.approx(1.4839, abs=1e-4)
    if name == "fanuc-m10id8l":
        assert bound.estimate == pytest.approx(0.7212, abs=1e-4)


@pytest.mark.parametrize(("name", "expected"), [("machines-2024-490", 4.3104), ("fanuc-m10id8l", 1.2242)])
def test_certificate(name: str, expected: float) -> None:
    began = time.process_time()
    result = certify(load_case(name))
    seconds = time.process_time() - began
    print(f"\n{name}: {result.lower:.6f} to {result.upper:.6f} s, {result.nodes} cells, {seconds:.1f} s CPU")
    assert result.certified and result.upper == pytest.approx(expected, abs=2e-4)


@pytest.mark.parametrize(
    ("name", "known"),
    [("fang-2020-task-1", 4.0), ("yu-2025-four-points", 7.665), ("puma560-eight-knots", 16.038)],
)
def test_jerk_estimate(name: str, known: float) -> None:
    task = load_case(name)
    began = time.process_time()
    result = jerk_estimate(task)
    seconds = time.process_time() - began
    timed = jerk_limited_reference(task, "chord")
    print(
        f"\n{name}: estimate {result.estimate:.6f} s ({seconds:.1f} s CPU); chord path {timed.duration:.4f} s"
    )
    assert result.estimate <= known * (1 + 1e-4)


def test_convex_problem_of_1000_cells_and_seven_joints() -> None:
    robot = load_robot("panda")
    rng = np.random.default_rng(0)
    lower, upper = np.clip(robot.position_limits, -2.0, 2.0)
    points = lower + (upper - lower) * rng.random((5, 7))
    for word, share in (("first", 1.0), ("second", 0.95)):
        limits = Limits(
            acceleration=10.0 * share,
            velocity=share * robot.velocity_limits,
            torque=share * robot.torque_limits,
        )
        task = TrajectoryTask(points, limits, robot=robot)
        wall, cpu = time.perf_counter(), time.process_time()
        result = convex_reference(task, "chord", points=960)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        print(
            f"\n{word} solve, {len(result.s) - 1} cells: {wall:.2f} s wall, {cpu:.2f} s CPU, {result.duration:.6f} s"
        )
        fastest = toppra_reference(task, "chord", points=960)
        assert result.duration == pytest.approx(fastest.duration, rel=1e-3)
