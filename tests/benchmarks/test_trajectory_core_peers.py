"""Durations and CPU time beside peers on public kinematic cases; nothing here asserts a time.

Run ``pytest tests/benchmarks/test_trajectory_core_peers.py --benchmark-timer=time.process_time
--benchmark-json=FILE``, then ``python docs/benchmarks/tables.py FILE``. Peers that are not installed are skipped.
Every curve a peer returns is judged by our audit against the same limits; the verdict is recorded, whatever it is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

import ocp_traj as ot
from helpers.peers.answer import PeerAnswer
from helpers.peers.drake import path_parameters, solve_with_drake
from helpers.peers.pyroboplan import solve_with_pyroboplan
from helpers.peers.ruckig import solve_with_ruckig
from helpers.peers.toppra import solve_with_toppra
from helpers.peers.totg import solve_with_totg
from ocp_traj.solvers.gradient.gradient import Gradient
from ocp_traj.task import Boundary, TrajectoryTask

CASES = ("yu-2025-four-points", "puma560-eight-knots", "machines-2024-490", "fang-2020-task-1")
LIMITED_JERK = ("yu-2025-four-points", "puma560-eight-knots", "fang-2020-task-1")
NEEDS = {
    "drake": "pydrake",
    "pyroboplan": "pyroboplan",
    "totg": "tesseract_robotics",
    "ruckig": "ruckig",
    "toppra": "toppra",
}


def solve_here(task: TrajectoryTask, virtual_knots: int) -> PeerAnswer:
    result = ot.solve(task.changed(virtual_knots=virtual_knots), Gradient(compiled=False))
    assert result.feasible
    return PeerAnswer("ocp-traj", f"cubic, {virtual_knots} virtual knots", result.trajectory, 0.0)


METHODS: dict[str, Callable[[TrajectoryTask], PeerAnswer]] = {
    "ocp-traj-0": lambda task: solve_here(task, 0),
    "ocp-traj-3": lambda task: solve_here(task, 3),
    "ocp-traj-7": lambda task: solve_here(task, 7),
    "drake-uniform-16": lambda task: solve_with_drake(task, "uniform", 16),
    "drake-uniform-32": lambda task: solve_with_drake(task, "uniform", 32),
    "drake-uniform-64": lambda task: solve_with_drake(task, "uniform", 64),
    "drake-chord-32": lambda task: solve_with_drake(task, "chord", 32),
    "drake-chord-64": lambda task: solve_with_drake(task, "chord", 64),
    "pyroboplan": lambda task: solve_with_pyroboplan(task, knots=3 if task.gaps == 1 else None),
    "ruckig": solve_with_ruckig,
    "toppra-uniform": lambda task: solve_with_toppra(task, path_parameters(task, "uniform"), name="uniform"),
    "toppra-chord": lambda task: solve_with_toppra(task, path_parameters(task, "chord"), name="chord"),
    "totg-0.1": lambda task: solve_with_totg(task, path_tolerance=0.1),
    "totg-0.001": lambda task: solve_with_totg(task, path_tolerance=0.001),
}
NO_JERK_ONLY = ("toppra", "totg")
"""Peers that do not look at jerk."""


def task_of(name: str, jerk: bool) -> TrajectoryTask:
    """Return the case with its jerk limits and zero end accelerations, or without jerk limits and free ends."""
    task = ot.load_case(name, ("spline.family='cubic'", "spline.virtual_knots=3"))
    if jerk:
        return task.changed(boundary=Boundary(acceleration=0.0))
    return task.changed(limits=replace(task.limits, jerk=float("inf")), boundary=Boundary())


def measure(benchmark: BenchmarkFixture, method: str, task: TrajectoryTask, rounds: int = 3) -> PeerAnswer:
    kind = method.split("-")[0]
    if kind in NEEDS:
        pytest.importorskip(NEEDS[kind])
    answer: PeerAnswer = benchmark.pedantic(METHODS[method], args=(task,), rounds=rounds, warmup_rounds=1)
    _note(benchmark, answer, task)
    return answer


def _note(benchmark: BenchmarkFixture, answer: PeerAnswer, task: TrajectoryTask) -> None:
    benchmark.extra_info.update(
        case=task.name,
        jerk=task.limited("jerk"),
        peer=answer.peer,
        setting=answer.setting,
        duration=answer.duration,
        message=answer.message,
    )
    if answer.trajectory is None:
        return
    verdict = ot.audit(task, answer.trajectory)
    worst = verdict.worst
    benchmark.extra_info.update(feasible=verdict.feasible, findings=list(verdict.findings))
    if worst is not None:
        benchmark.extra_info.update(worst_limit=worst.limit, worst_ratio=worst.ratio)


SMOOTH_ENDS = [m for m in METHODS if m.startswith(("ocp-traj-3", "ocp-traj-7", "drake"))]


@pytest.mark.parametrize("method", SMOOTH_ENDS)
@pytest.mark.parametrize("name", LIMITED_JERK)
def test_with_jerk_limits(benchmark: BenchmarkFixture, name: str, method: str) -> None:
    if name == "fang-2020-task-1" and method.startswith("drake-chord"):
        pytest.skip("uniform and chord are the same for two waypoints")
    answer = measure(benchmark, method, task_of(name, jerk=True))
    if method.startswith("ocp-traj"):
        assert answer.duration is not None


@pytest.mark.parametrize("method", ["ocp-traj-0", "ocp-traj-7", "pyroboplan"])
@pytest.mark.parametrize("name", LIMITED_JERK)
def test_with_jerk_limits_and_free_ends(benchmark: BenchmarkFixture, name: str, method: str) -> None:
    """pyroboplan's knots are the waypoints, so zero end accelerations are impossible for it."""
    task = task_of(name, jerk=True).changed(boundary=Boundary(acceleration=None), name=f"{name}-free-ends")
    answer = measure(benchmark, method, task)
    if method.startswith("ocp-traj"):
        assert answer.duration is not None


def test_two_points_with_ruckig(benchmark: BenchmarkFixture) -> None:
    answer = measure(benchmark, "ruckig", task_of("fang-2020-task-1", jerk=True), rounds=50)
    assert answer.duration == pytest.approx(4.0, abs=1e-6)


@pytest.mark.parametrize("method", [m for m in METHODS if m != "ruckig"])
@pytest.mark.parametrize("name", CASES)
def test_without_jerk_limits(benchmark: BenchmarkFixture, name: str, method: str) -> None:
    if name == "fang-2020-task-1" and method.startswith("drake-chord"):
        pytest.skip("uniform and chord are the same for two waypoints")
    answer = measure(benchmark, method, task_of(name, jerk=False))
    if method.startswith("ocp-traj"):
        assert answer.duration is not None


@pytest.mark.parametrize("name", ["yu-2025-four-points", "puma560-eight-knots"])
def test_drake_with_the_waypoint_times_we_found(benchmark: BenchmarkFixture, name: str) -> None:
    """The times are found outside the clock."""
    pytest.importorskip("pydrake")
    task = task_of(name, jerk=True)
    times = ot.solve(task.changed(virtual_knots=7), Gradient(compiled=False)).trajectory.waypoint_times
    answer = benchmark.pedantic(
        lambda: solve_with_drake(task, times, 64, name="our waypoint times"), rounds=3, warmup_rounds=1
    )
    _note(benchmark, answer, task)
    ours = solve_here(task, 7)
    assert answer.duration is None or answer.duration >= ours.duration * (1.0 - 1e-3)
