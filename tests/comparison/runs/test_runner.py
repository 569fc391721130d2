"""What a run sends back: the audit's verdict beside the solver's claim, and a history a page can bear."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ocp_traj.comparison.runs.record import RunRecord
from ocp_traj.comparison.runs.runner import (
    HISTORY_POINTS,
    claims_success,
    find_reference,
    pack_result,
    solve_case,
    thin_history,
)

CASE = """
schema = 1
name = "two-joints"
[waypoints]
joints = [[0.0, 0.0], [1.0, -0.5], [2.0, 0.3]]
[limits]
velocity = 1.0
acceleration = 2.0
[spline]
virtual_knots = 1
"""


@pytest.fixture(scope="module")
def request_for(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    path: Path = tmp_path_factory.mktemp("case") / "case.toml"
    path.write_text(CASE)
    return {
        "case": str(path),
        "overrides": [],
        "solver": "ipopt",
        "seed": 1,
        "budget": None,
        "time_limit": None,
    }


@pytest.fixture(scope="module")
def result(request_for: dict[str, Any]) -> Any:
    from ocp_traj.case import load_case
    from ocp_traj.solving import solve

    return solve(load_case(request_for["case"]), "ipopt")


def test_a_solved_case_comes_back_as_a_record(request_for: dict[str, Any]) -> None:
    record = RunRecord.from_json(solve_case(request_for))
    assert record.feasible and record.claimed and record.status == "converged"
    assert record.objective == record.duration and record.energy is None
    assert record.worst is not None and record.worst["ratio"] <= 1 + 1e-6
    assert record.trajectory is not None and record.trajectory["case"] == "two-joints"
    assert record.dimension and record.evaluations and record.build_time is not None


def test_a_solver_that_lies_is_told_apart(result: Any) -> None:
    """A converged solver with a motion twice too fast."""
    from ocp_traj.audit import audit

    faster = result.trajectory.scaled(0.5)
    lie = replace(result, trajectory=faster, audit=audit(result.task, faster))
    record = RunRecord.from_json(pack_result(lie))
    assert record.claimed and not record.feasible and not record.return_code_correct
    assert record.findings and record.smallest_feasible_scale == pytest.approx(2.0, rel=1e-3)


def test_an_answer_without_a_number_is_no_success(result: Any) -> None:
    fake = SimpleNamespace(
        **{
            name: getattr(result, name)
            for name in ("task", "solution", "audit", "duration", "energy", "trajectory", "message")
        },
        objective=float("nan"),
    )
    record = RunRecord.from_json(pack_result(fake))
    assert (record.feasible, record.status, record.objective) == (False, "failed", None)


@pytest.mark.parametrize(
    ("status", "violation", "claims"),
    [
        ("converged", 1.0, True),
        ("budget_exhausted", 0.0, True),
        ("budget_exhausted", 1e-3, False),
        ("stalled", 1e-7, True),
        ("infeasible", 0.0, False),
        ("failed", 0.0, False),
    ],
)
def test_what_counts_as_a_claim(status: str, violation: float, claims: bool) -> None:
    solution = SimpleNamespace(status=SimpleNamespace(key=status), total_violation=violation)
    assert claims_success(solution) is claims


def history(count: int) -> SimpleNamespace:
    cost = np.repeat(np.linspace(9, 1, max(count // 4, 1)), 4)[:count]
    steps = np.arange(1.0, count + 1)
    return SimpleNamespace(cost=cost, evaluations=10 * steps, violation=0 * steps, seconds=0.1 * steps)


@pytest.mark.parametrize("count", [0, 1, HISTORY_POINTS, 20_000])
def test_a_history_is_thinned_and_keeps_its_ends(count: int) -> None:
    thin = thin_history(history(count))
    if count == 0:
        assert thin == {}
        return
    assert len(thin["cost"]) <= HISTORY_POINTS
    assert (thin["evaluations"][0], thin["evaluations"][-1]) == (10, 10 * count)
    assert (np.diff(thin["evaluations"]) > 0).all() and len({len(part) for part in thin.values()}) == 1


def test_references_come_in_two_parts(request_for: dict[str, Any]) -> None:
    paths, bound = (
        find_reference({**request_for, "reference": name}) for name in ("toppra", "kinematic_bound")
    )
    assert set(paths) == {"uniform", "chord"} and set(bound) == {"lower", "estimate"}
    assert bound["lower"] <= bound["estimate"] * (1 + 1e-6) <= min(paths.values()) * (1 + 1e-3)
