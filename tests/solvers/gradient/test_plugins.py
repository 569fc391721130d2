"""A plug-in is called usable only when it solved a sparse problem here; otherwise it says what it lacks."""

from __future__ import annotations

import casadi as ca
import pytest

from helpers.small_tasks import plain_task
from metaheuristics import Status
from ocp_traj.exceptions import UnavailableError
from ocp_traj.solvers import parse_solver, solver_table
from ocp_traj.solvers.gradient.gradient import Gradient
from ocp_traj.solvers.gradient.plugins import (
    PLUGINS,
    Plugin,
    plugin_named,
    read_status,
    readable_reason,
    unavailable_reason,
)
from ocp_traj.solving import solve

PAGE = """.../casadi_os.cpp:335: Assertion "handle!=nullptr" failed:
PluginInterface::load_plugin: Cannot load shared library 'libcasadi_{part}.so':
   (
    Searched directories: 1. CASADI_PLUGIN_SEARCH_PATH env var
   )
  Tried '/somewhere/casadi' :
    Error code: {missing}: cannot open shared object file: No such file or directory
  Tried '.' :
    Error code: ./libcasadi_{part}.so: cannot open shared object file: No such file or directory"""


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (
            PAGE.format(part="linsol_ma27", missing="libhsl.so"),
            "its part 'linsol ma27' needs libhsl.so, which is not on this computer",
        ),
        (
            PAGE.format(part="nlpsol_new", missing="./libcasadi_nlpsol_new.so"),
            "this CasADi has no part 'nlpsol new'",
        ),
        ("first\n  'neig' not defined for MumpsInterface \n", "'neig' not defined for MumpsInterface"),
    ],
)
def test_a_page_of_casadi_becomes_one_reason(message: str, reason: str) -> None:
    assert readable_reason(message) == reason


def test_every_plugin_listed_as_usable_solves_a_motion() -> None:
    usable = [row.name for row in solver_table() if row.kind == "gradient" and row.available]
    assert "ipopt" in usable
    for name in usable:
        result = solve(plain_task(), name, time_limit=60)
        assert result.status == "converged", result
        assert result.feasible, result


def test_every_plugin_listed_as_unusable_refuses_with_the_reason_in_the_list() -> None:
    for row in solver_table():
        if row.kind == "gradient" and not row.available:
            with pytest.raises(UnavailableError, match="cannot be used") as caught:
                solve(plain_task(), row.name)
            assert str(caught.value) == row.reason


@pytest.mark.skipif(ca.has_linsol("ma27"), reason="this CasADi has HSL")
def test_blocksqp_is_not_called_usable_without_its_linear_solver() -> None:
    assert "ma27" in unavailable_reason("blocksqp")


def test_a_plugin_that_does_not_solve_the_probe_is_not_called_usable(monkeypatch: pytest.MonkeyPatch) -> None:
    lazy = Plugin(lambda stage: {"ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.max_iter": 0})
    monkeypatch.setitem(PLUGINS, "ipopt", lazy)
    reason = unavailable_reason.__wrapped__("ipopt")
    assert reason == "it fails on a problem of 6 variables: Maximum_Iterations_Exceeded"


def test_a_plugin_that_stops_with_an_error_is_a_failure_not_a_crash(monkeypatch: pytest.MonkeyPatch) -> None:
    def options(stage):  # a subproblem solver without iterations, told to raise
        quiet = {"print_header": False, "print_iteration": False, "print_status": False}
        inner = {"max_iter": 0, "error_on_fail": True}
        return {
            "qpsol": "qrqp",
            "qpsol_options": {"print_iter": False, "print_header": False, **inner},
            **quiet,
        }

    monkeypatch.setitem(PLUGINS, "sqpmethod", Plugin(options))
    monkeypatch.setattr(Gradient, "check_available", lambda self: None)
    result = solve(plain_task(), Gradient(plugin="sqpmethod", attempts=1))
    assert result.status == "failed"
    assert "conic process failed" in result.message


@pytest.mark.parametrize(
    ("stats", "status"),
    [
        ({"success": True, "return_status": "Solve_Succeeded"}, Status.CONVERGED),
        ({"success": False, "return_status": "Infeasible_Problem_Detected"}, Status.INFEASIBLE),
        ({"success": False, "return_status": "Search_Direction_Becomes_Too_Small"}, Status.STALLED),
        ({"success": False, "return_status": "Maximum_Iterations_Exceeded"}, Status.BUDGET_EXHAUSTED),
        ({"success": False, "return_status": "Maximum_WallTime_Exceeded"}, Status.TIME_EXHAUSTED),
        ({"success": False, "return_status": "Invalid_Number_Detected"}, Status.FAILED),
        ({"return_status": 4, "unified_return_status": "SOLVER_RET_LIMITED"}, Status.BUDGET_EXHAUSTED),
    ],
)  # fmt: skip
def test_the_words_of_a_plugin_become_the_shared_status(stats: dict, status: Status) -> None:
    assert read_status(plugin_named("ipopt"), stats)[0] is status


def test_settings_of_a_plugin_reach_it() -> None:
    solver = parse_solver("ipopt[iterations=3,tolerance=1e-4]")
    assert isinstance(solver, Gradient)
    assert (solver.iterations, solver.tolerance) == (3, 1e-4)
