"""Functions compiled from C and functions run in NumPy give what the interpreter gives."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from ocp_traj.codegen.array_program import ArrayProgram
from ocp_traj.codegen.compiled import cache_folder, compile_function, find_compiler
from ocp_traj.codegen.compiled_program import CompiledProgram
from ocp_traj.exceptions import InputError, UnavailableError
from ocp_traj.robot import load_robot
from ocp_traj.robot.inverse_dynamics import newton_euler
from ocp_traj.robot.regrouping import regrouped, split_rotation

needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler on this machine")


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("OCP_TRAJ_CACHE", str(tmp_path))
    return tmp_path / "compiled"


def small_function() -> ca.Function:
    x, y = ca.SX.sym("x", 2), ca.SX.sym("y", 2)
    out = ca.vertcat(ca.sin(x[0]) * y[1] + 3.0, ca.sqrt(ca.fabs(x[1])) / (1 + y[0] ** 2), 7.0)
    return ca.Function("small", [x, y], [out, x - y], ["x", "y"], ["f", "difference"])


def points(count: int) -> tuple[np.ndarray, np.ndarray]:
    x, y = np.random.default_rng(0).standard_normal((2, count, 2))
    return x, y


@needs_compiler
def test_a_compiled_function_equals_the_interpreter() -> None:
    function = load_robot("ur5").symbolic.inverse_dynamics
    compiled = compile_function(function)
    assert compiled.class_name() == "External"
    assert compiled.name_in() == function.name_in()
    for state in np.random.default_rng(1).standard_normal((50, 3, 6)):
        np.testing.assert_array_equal(np.array(compiled(*state)), np.array(function(*state)))


@needs_compiler
def test_compiled_derivatives_reach_second_order() -> None:
    function = small_function()
    compiled = compile_function(function, derivatives=2)
    x, y = ca.MX.sym("x", 2), ca.MX.sym("y", 2)
    hessians = [
        ca.Function("H", [x, y], [ca.hessian(ca.sumsqr(f(x, y)[0]), x)[0]]) for f in (function, compiled)
    ]
    for row in np.random.default_rng(2).uniform(0.5, 1.0, (5, 2, 2)):
        np.testing.assert_allclose(
            np.array(hessians[1](*row)), np.array(hessians[0](*row)), rtol=1e-12, atol=1e-14
        )


@needs_compiler
def test_the_cache_is_private_and_used_again(own_cache: Path) -> None:
    compile_function(small_function())
    assert own_cache.stat().st_mode & 0o777 == 0o700
    libraries = {path: path.stat().st_mtime_ns for path in own_cache.glob("*.so")}
    assert len(libraries) == 1
    compile_function(small_function())
    assert {path: path.stat().st_mtime_ns for path in own_cache.glob("*.so")} == libraries


@needs_compiler
def test_a_tampered_library_is_compiled_anew_and_never_loaded(own_cache: Path) -> None:
    compile_function(small_function())
    (record,) = own_cache.glob("*.json")
    library = own_cache / json.loads(record.read_text())["library"]
    library.unlink()  # a library in use must not be overwritten in place
    library.write_bytes(b"not a library")
    again = compile_function(small_function())
    assert again.class_name() == "External"
    assert library.read_bytes() != b"not a library"


@needs_compiler
def test_an_unreadable_record_is_replaced(own_cache: Path) -> None:
    compile_function(small_function())
    (record,) = own_cache.glob("*.json")
    record.write_text("{")
    compile_function(small_function())
    assert "sha256" in json.loads(record.read_text())


@needs_compiler
def test_processes_that_compile_the_same_at_once_all_succeed(own_cache: Path) -> None:
    code = (
        "import casadi as ca; from ocp_traj.codegen.compiled import compile_function; x = ca.SX.sym('x', 3);"
        "f = compile_function(ca.Function('shared', [x], [ca.sin(x) * ca.sum1(x)]));"
        "print(f.class_name(), float(ca.sum1(f([1, 2, 3]))))"
    )
    running = [
        subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) for _ in range(4)
    ]
    answers = {process.communicate()[0] for process in running}
    assert len(answers) == 1
    assert answers.pop().startswith("External ")
    assert len(list(own_cache.glob("*.json"))) == 1
    assert not [path for path in own_cache.iterdir() if path.is_dir()]  # no scratch folder is left behind


def test_an_open_cache_folder_is_refused(own_cache: Path) -> None:
    own_cache.mkdir(parents=True)
    os.chmod(own_cache, 0o755)
    with pytest.raises(UnavailableError, match="mode 755, expected 700"):
        cache_folder()
    assert compile_function(small_function()).class_name() == "SXFunction"


def test_a_cache_folder_that_cannot_be_made_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("OCP_TRAJ_CACHE", str(tmp_path / "file"))
    with pytest.raises(UnavailableError, match="cannot be used"):
        cache_folder()


def test_without_a_compiler_the_interpreter_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OCP_TRAJ_NO_COMPILER", "1")
    function = small_function()
    assert compile_function(function) is function
    with pytest.raises(UnavailableError, match="no C compiler"):
        CompiledProgram(function)


@needs_compiler
def test_a_failing_compiler_falls_back_to_the_interpreter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    broken = tmp_path / "broken-cc"
    broken.write_text('#!/bin/sh\n[ "$1" = --version ] && echo broken 1.0 && exit 0\necho no >&2\nexit 3\n')
    broken.chmod(0o755)
    monkeypatch.setenv("CC", str(broken))
    function = small_function()
    assert compile_function(function) is function
    assert "failed with status 3" in caplog.text


def test_an_unknown_derivative_order_is_refused() -> None:
    with pytest.raises(InputError, match="derivatives is 3, expected 0, 1 or 2"):
        compile_function(small_function(), derivatives=3)


@pytest.mark.parametrize("kind", ["numpy", pytest.param("compiled", marks=needs_compiler)])
@pytest.mark.parametrize("count", [0, 1, 7, 4097])
def test_batch_programs_equal_the_interpreter_bit_by_bit(kind: str, count: int) -> None:
    function = small_function()
    program = ArrayProgram(function) if kind == "numpy" else CompiledProgram(function)
    x, y = points(count)
    found = program(x, y)
    for index, shape in enumerate([(count, 3), (count, 2)]):
        assert found[index].shape == shape
        if count:
            np.testing.assert_array_equal(found[index], np.array(function(x.T, y.T)[index]).T)


@pytest.mark.parametrize("kind", ["numpy", pytest.param("compiled", marks=needs_compiler)])
@pytest.mark.parametrize("count", [1, 5000])
def test_points_in_columns_give_the_same_as_points_in_rows(kind: str, count: int) -> None:
    function = small_function()
    program = ArrayProgram(function) if kind == "numpy" else CompiledProgram(function)
    x, y = points(count)
    expected = program(x, y)
    inputs = [np.ascontiguousarray(x.T), np.ascontiguousarray(y.T)]
    wide = np.full((3, count + 4), -1.0)  # rows may be parts of longer ones
    outputs = [wide[:, :count], np.empty((2, count))]
    program.run_columns(inputs, outputs)
    np.testing.assert_array_equal(outputs[0].T, expected[0])
    np.testing.assert_array_equal(outputs[1].T, expected[1])
    assert np.all(wide[:, count:] == -1.0)


@needs_compiler
def test_columns_of_other_numbers_than_doubles_are_refused() -> None:
    program = CompiledProgram(small_function())
    x, y = points(3)
    with pytest.raises(InputError, match="not contiguous doubles"):
        program.run_columns([x.T, y.T], [np.empty((3, 3)), np.empty((2, 3))])


@pytest.mark.parametrize("kind", ["numpy", pytest.param("compiled", marks=needs_compiler)])
def test_batch_programs_refuse_wrong_shapes(kind: str) -> None:
    program = ArrayProgram(small_function()) if kind == "numpy" else CompiledProgram(small_function())
    with pytest.raises(InputError, match=r"expected \(N, 2\), \(N, 2\)"):
        program(np.zeros((3, 2)), np.zeros((2, 2)))


def test_array_program_refuses_an_operation_numpy_has_not() -> None:
    x = ca.SX.sym("x")
    with pytest.raises(InputError, match="not supported"):
        ArrayProgram(ca.Function("f", [x], [ca.erf(x)]))


def test_array_program_refuses_matrices() -> None:
    x = ca.SX.sym("x", 2, 2)
    with pytest.raises(InputError, match="matrix input"):
        ArrayProgram(ca.Function("f", [x], [ca.sum1(x).T]))


@pytest.mark.parametrize("operation", ["tan", "exp", "tanh", "floor", "ceil", "acos", "asin", "atan", "sign"])
def test_array_program_knows_unary_operations(operation: str) -> None:
    x = ca.SX.sym("x")
    function = ca.Function("f", [x], [getattr(ca, operation)(x)])
    values = np.linspace(-0.9, 0.9, 11)[:, None]
    np.testing.assert_allclose(ArrayProgram(function)(values)[0], np.array(function(values.T)).T, rtol=1e-15)


@pytest.mark.parametrize("operation", ["fmin", "fmax", "atan2", "hypot", "power", "lt", "le", "eq", "ne"])
def test_array_program_knows_binary_operations(operation: str) -> None:
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    function = ca.Function("f", [x, y], [getattr(ca, operation)(x, y)])
    values = np.random.default_rng(3).integers(1, 4, (2, 20, 1)).astype(float)
    expected = np.array(function(values[0].T, values[1].T)).T
    np.testing.assert_allclose(ArrayProgram(function)(*values)[0], expected, rtol=1e-15)


def test_a_robot_gives_the_same_torque_with_and_without_a_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    q, v, a = np.random.default_rng(4).standard_normal((3, 100, 6))
    first = replace(load_robot("ur5")).batch.torque(q, v, a)
    monkeypatch.setenv("OCP_TRAJ_NO_COMPILER", "1")
    second = replace(load_robot("ur5")).batch.torque(q, v, a)
    np.testing.assert_array_equal(first, second)
    columns = np.empty((6, 100))
    load_robot("ur5").batch.torque_columns(*(np.ascontiguousarray(array.T) for array in (q, v, a)), out=columns)
    np.testing.assert_array_equal(columns.T, first)


@needs_compiler
@pytest.mark.parametrize(
    "operation",
    ["tan", "exp", "log", "tanh", "floor", "ceil", "acos", "asin", "atan", "sign", "fabs", "sqrt", "cos"],
)
def test_compiled_program_knows_unary_operations(operation: str) -> None:
    x = ca.SX.sym("x")
    function = ca.Function("f", [x], [getattr(ca, operation)(x) - 0.5 * getattr(ca, operation)(-x)])
    values = np.linspace(-0.9, 0.9, 11)[:, None]
    expected = np.array(function(values.T)).T
    np.testing.assert_array_equal(CompiledProgram(function)(values)[0], expected)


@needs_compiler
@pytest.mark.parametrize("operation", ["fmin", "fmax", "atan2", "hypot", "power", "lt", "le", "eq", "ne"])
def test_compiled_program_knows_binary_operations(operation: str) -> None:
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    function = ca.Function("f", [x, y], [getattr(ca, operation)(x, y)])
    values = [column[:, None] for column in np.random.default_rng(0).integers(1, 4, (2, 11)).astype(float)]
    expected = np.array(function(*(column.T for column in values))).T
    np.testing.assert_array_equal(CompiledProgram(function)(*values)[0], expected)


def test_what_lies_on_a_joint_axis_may_belong_to_the_link_before() -> None:
    """Regrouped links have nothing on their axes, and their function far fewer operations."""
    robot = load_robot("ur5")
    links = regrouped(robot.links)
    assert all(link.mass == 0.0 and link.first_moment[2] == 0.0 for link in links)
    assert all(link.second_moment[2, 2] == 0.0 for link in links)
    symbols = [ca.SX.sym(name, 6) for name in "qva"]
    plain = ca.Function(
        "plain", symbols, [ca.cse(newton_euler(robot.links, np.array([0, 0, -9.81]), *symbols))]
    )
    assert robot.symbolic.inverse_dynamics.n_instructions() < 0.8 * plain.n_instructions()
    for state in np.random.default_rng(3).standard_normal((20, 3, 6)):
        np.testing.assert_allclose(
            np.array(robot.symbolic.inverse_dynamics(*state)), np.array(plain(*state)), atol=1e-13, rtol=0
        )


def test_a_turn_about_the_axis_is_split_off_a_rotation() -> None:
    tilt = np.array([[1.0, 0.0, 0.0], [0.0, 0.6, -0.8], [0.0, 0.8, 0.6]])
    for angle in (0.3, -2.0, np.pi / 2 - 1e-11):
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        for rotation in (tilt @ turn, turn):
            plain, found = split_rotation(rotation)
            assert np.count_nonzero(plain) < np.count_nonzero(rotation)
            c, s = np.cos(found), np.sin(found)
            back = plain @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
            np.testing.assert_allclose(back, rotation, atol=1e-15)
    exchange = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    np.testing.assert_array_equal(split_rotation(exchange)[0], exchange)
    assert split_rotation(exchange)[1] == 0.0


@needs_compiler
def test_dynamics_that_do_not_compile_run_in_numpy_and_say_so(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    from ocp_traj.codegen import compiled_program

    def refuse(_: ca.Function) -> None:
        raise UnavailableError("the compiler crashed")

    q, v, a = np.random.default_rng(5).standard_normal((3, 20, 6))
    expected = replace(load_robot("ur5")).batch.torque(q, v, a)
    monkeypatch.setattr(compiled_program, "CompiledProgram", refuse)
    robot = replace(load_robot("ur5"))
    np.testing.assert_array_equal(robot.batch.torque(q, v, a), expected)
    assert f"inverse dynamics of {robot.name} run in NumPy, not compiled: the compiler crashed" in caplog.text
