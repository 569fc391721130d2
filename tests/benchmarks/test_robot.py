"""Speed of the robot layer; run with ``pytest tests/benchmarks/test_robot.py``. Nothing here asserts a time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from ocp_traj.codegen.array_program import ArrayProgram
from ocp_traj.codegen.compiled import compile_function, find_compiler
from ocp_traj.codegen.compiled_program import CompiledProgram
from ocp_traj.robot import Robot, load_robot
from ocp_traj.robot.inverse_kinematics import inverse_kinematics_of, poses_to_matrices
from ocp_traj.robot.inverse_kinematics.domain_timing import measure_domain_timing

POINTS = 20_000
HELIX_START = np.array([1.731, -2.032, 2.096, -0.065, -1.410, 1.571])
HELIX_WEIGHTS = np.array([6.0, 5.0, 4.0, 3.0, 2.0, 1.0])


def states(count: int) -> np.ndarray:
    return np.random.default_rng(0).standard_normal((3, count, 6))


def helix(count: int) -> np.ndarray:
    angle = np.linspace(0.0, 2.0 * np.pi, count)
    rows = np.tile([0.0, 0.0, 0.0, 0.5, -0.5, 0.5, 0.5], (count, 1))
    rows[:, 0], rows[:, 1] = -0.2 + 0.06 * np.cos(angle), 0.1 + 0.06 * np.sin(angle)
    rows[:, 2] = 0.35 + 0.01 * angle / (2.0 * np.pi)
    return poses_to_matrices(rows)


def helix_robot() -> Robot:
    return load_robot("ur5").with_changes(tool="tool0", base="base_link")


def test_building_the_inverse_dynamics(benchmark: BenchmarkFixture) -> None:
    robot = load_robot("ur5")
    function = benchmark(lambda: replace(robot).symbolic.inverse_dynamics)
    benchmark.extra_info["instructions"] = function.n_instructions()
    assert function.n_instructions() < 600


@pytest.mark.parametrize("kind", ["numpy", "compiled"])
def test_inverse_dynamics_of_a_population(benchmark: BenchmarkFixture, kind: str) -> None:
    if kind == "compiled" and find_compiler() is None:
        pytest.skip("no C compiler on this machine")
    function = load_robot("ur5").symbolic.inverse_dynamics
    program = ArrayProgram(function) if kind == "numpy" else CompiledProgram(function)
    q, v, a = states(POINTS)
    (tau,) = benchmark(program, q, v, a)
    benchmark.extra_info["microseconds a point"] = 1e6 * benchmark.stats["median"] / POINTS
    assert tau.shape == (POINTS, 6)


@pytest.mark.parametrize("kind", ["interpreted", "compiled"])
@pytest.mark.parametrize("what", ["function", "jacobian"])
def test_one_inverse_dynamics_call_without_conversion(
    benchmark: BenchmarkFixture, kind: str, what: str
) -> None:
    if kind == "compiled" and find_compiler() is None:
        pytest.skip("no C compiler on this machine")
    function = load_robot("ur5").symbolic.inverse_dynamics
    if kind == "compiled":
        function = compile_function(function, derivatives=1)
    if what == "jacobian":
        function = function.jacobian()
    buffer, call = function.buffer()
    inputs = [np.zeros(function.nnz_in(index)) for index in range(function.n_in())]
    outputs = [np.zeros(function.nnz_out(index)) for index in range(function.n_out())]
    for index, array in enumerate(inputs):
        if array.size:
            array[:] = 0.3
            buffer.set_arg(index, memoryview(array))
    for index, array in enumerate(outputs):
        buffer.set_res(index, memoryview(array))
    benchmark(call)
    assert buffer.ret() == 0


def test_all_branches_of_1000_poses(benchmark: BenchmarkFixture) -> None:
    inverse = inverse_kinematics_of(helix_robot())
    found = benchmark(inverse.branches, helix(1000))  # type: ignore[attr-defined]
    assert found.q.shape == (1000, 8, 6)


@pytest.mark.parametrize("form", ["python", "vectorised"])
@pytest.mark.parametrize("count", [9, 100, 1000])
def test_time_saved_by_unique_domains(benchmark: BenchmarkFixture, form: str, count: int) -> None:
    """Paper C reports 39.76 % (2.6149 ms against 1.5752 ms a path, number of points not printed)."""
    timing = benchmark.pedantic(
        measure_domain_timing,
        args=(helix_robot(), helix(count), HELIX_START, HELIX_WEIGHTS, form),  # type: ignore[arg-type]
        kwargs={"repeats": 50},
        rounds=1,
    )
    benchmark.extra_info["eight branches, ms"] = 1e3 * float(np.median(timing.eight_branches))
    benchmark.extra_info["one domain, ms"] = 1e3 * float(np.median(timing.one_domain))
    benchmark.extra_info["saved"] = timing.saving
    assert timing.saving < 1.0
