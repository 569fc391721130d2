"""The same plan on the same machine gives the same table, bit by bit, and the table says what it was made with."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ocp_traj.case import load_case
from ocp_traj.comparison.report.report import write_report
from ocp_traj.comparison.runs.compare import compare
from ocp_traj.comparison.runs.plan import CaseChoice, Plan
from ocp_traj.comparison.runs.store import Store
from ocp_traj.solvers import solver_names
from ocp_traj.solving import solve

POPULATIONS = ("pso", "pso-constriction", "pso-d", "ssa", "ssa-debiased", "issa-a", "issa-b", "t-ssa", "adf-ssa",
               "tadf-ssa", "de", "random", "cmaes")  # fmt: skip
CASE = "fang-2020-task-1"


def table(folder: Path) -> list[tuple[Any, ...]]:
    """Every stored run without its times and memory, with the bytes of its motion."""
    with Store(folder) as store:
        return [
            (
                row.key,
                row.record.status,
                row.record.message,
                row.record.objective,
                row.record.worst,
                row.record.evaluations,
                row.record.history["evaluations"],
                row.record.history["cost"],
                row.record.history["violation"],
                row.trajectory_file and (folder / "trajectories" / row.trajectory_file).read_bytes(),
            )
            for row in store.rows()
        ]


def test_the_same_plan_gives_the_same_table_bit_by_bit_with_any_number_of_workers(tmp_path: Path) -> None:
    cases = (CaseChoice(CASE), CaseChoice("machines-2024-490", ("search.protocol=per-joint",)))
    plan = Plan(cases, ("pso", "issa-a", "ssa", "ipopt"), seeds=2, budgets=(300,), references=False)
    tables = []
    for name, jobs in (("one", 1), ("two", 2)):
        compare(plan, tmp_path / name, jobs=jobs)
        tables.append(table(tmp_path / name))
    assert len(tables[0]) == 16
    assert tables[0] == tables[1]
    assert any(row[-1] for row in tables[0])


def test_a_table_says_what_it_was_made_with(tmp_path: Path) -> None:
    plan = Plan((CaseChoice(CASE),), ("random",), seeds=1, seed=5, budgets=(20,), references=False)
    compare(plan, tmp_path, jobs=1)
    with Store(tmp_path) as store:
        ((stored, environment),) = store.plans()
    assert stored == plan
    assert {"ocp-traj", "numpy", "scipy", "casadi", "pin"} <= environment["versions"].keys()
    assert all(environment["versions"][name] for name in ("numpy", "scipy", "casadi", "pin"))
    assert environment["python"].startswith("3.")
    assert set(environment["threads"]["runs"].values()) == {"1"}
    text = write_report(tmp_path).markdown.read_text()
    assert environment["versions"]["casadi"] in text
    assert environment["python"] in text


@pytest.mark.parametrize("name", POPULATIONS)
def test_a_population_solver_repeats_itself_whatever_others_draw(name: str) -> None:
    """Global random states are neither read nor changed; another seed gives another run."""
    assert name in solver_names()
    task = load_case("machines-2024-490")
    first = solve(task, name, seed=3, budget=150)
    np.random.seed(1)  # noqa: NPY002
    random.seed(1)
    states = (str(np.random.get_state()), random.getstate())  # noqa: NPY002
    again = solve(task, name, seed=3, budget=150)
    assert states == (str(np.random.get_state()), random.getstate())  # noqa: NPY002
    other = solve(task, name, seed=4, budget=150)
    for part in ("evaluations", "cost", "violation"):
        one, two = (np.asarray(getattr(run.solution.history, part)) for run in (first, again))
        np.testing.assert_array_equal(one, two)
    np.testing.assert_array_equal(first.solution.x, again.solution.x)
    if first.trajectory is not None:
        np.testing.assert_array_equal(first.trajectory.coefficients, again.trajectory.coefficients)
    assert not np.array_equal(first.solution.x, other.solution.x)
