"""What is slow to load is loaded when it is used: neither an import nor a solve by IPOPT pays for what others need."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

HEAVY = ("scipy.stats", "scipy.optimize", "matplotlib", "pandas", "toppra", "cvxpy")
SOLVE = "import ocp_traj as ot; assert ot.solve(ot.load_case({case!r}), {solver!r}, budget=300).feasible"


def loaded_after(code: str, names: tuple[str, ...] = HEAVY) -> list[str]:
    """Return which modules a fresh interpreter has loaded after running some code."""
    code += f"; import sys, json; print(json.dumps([name for name in {names} if name in sys.modules]))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return list(json.loads(run.stdout.splitlines()[-1]))


@pytest.mark.parametrize(
    "code", ["import ocp_traj", "import metaheuristics", "import ocp_traj.solving", "import ocp_traj.pareto"]
)
def test_an_import_loads_nothing_slow(code: str) -> None:
    assert loaded_after(code) == []


def test_the_metaheuristics_load_numpy_only() -> None:
    assert loaded_after("import metaheuristics", ("scipy", "casadi", "ocp_traj")) == []


@pytest.mark.parametrize("solver", ["ipopt", "cmaes[encoding=scaled]"])
@pytest.mark.parametrize("case", ["yu-2025-four-points", "fang-2020-task-1"])
def test_a_solve_of_a_kinematic_case_loads_nothing_slow(case: str, solver: str) -> None:
    assert loaded_after(SOLVE.format(case=case, solver=solver)) == []


def test_what_a_solver_needs_is_loaded_when_it_runs() -> None:
    code = SOLVE.format(case="machines-2024-490", solver="scipy-de[encoding=scaled]")
    assert "scipy.optimize" in loaded_after(code)
