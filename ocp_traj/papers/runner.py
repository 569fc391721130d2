"""What a worker does with one run of a paper: it solves, and keeps what tables ask for beside the record."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.comparison.runs.runner import pack_result, warm_up
from ocp_traj.files import finite

if TYPE_CHECKING:
    from metaheuristics import History, Solution
    from ocp_traj.solving import SolveResult
    from ocp_traj.task import TrajectoryTask

RUNNER = f"{__name__}:solve_experiment"
"""As a plan names it."""

CONVERGED_WITHIN = 1e-3
"""Distance from a run's final best at which it counts as converged, relative."""

DENSE_ENTRIES = 40
"""First entries of a joint's history, which are all kept."""

THINNED_ENTRIES = 120
"""Most entries kept of the whole history, beside the dense ones."""

__all__ = ["RUNNER", "solve_experiment", "warm_up"]


def solve_experiment(request: Mapping[str, Any]) -> dict[str, Any]:
    """Execute one run; see `ocp_traj.comparison.runs.record.RunRecord` for the answer.

    Its ``details`` are ``segments`` (gap durations, s), ``processor`` (s, judging included), ``generations`` (until
    converged) and ``parts``: with the per-joint protocol, every joint's own search.
    """
    from ocp_traj.case import load_case

    task = load_case(request["case"], request["overrides"])
    began = time.process_time()
    result, parts = _solve(task, request)
    spent = time.process_time() - began
    answer = pack_result(result)
    answer["details"] = {
        "segments": [float(h) for h in result.segment_durations],
        "processor": spent,
        "generations": result.solution.history.generations_to_within(CONVERGED_WITHIN),
        "parts": [
            {
                "joint": joint + 1,
                "cost": float(part.cost) if part.feasible else None,
                "evaluations": part.evaluations,
                "generations": part.history.generations_to_within(CONVERGED_WITHIN),
                "history": _thin(part.history),
            }
            for joint, part in parts.items()
        ],
    }
    return finite(answer)


def _solve(task: TrajectoryTask, request: Mapping[str, Any]) -> tuple[SolveResult, dict[int, Solution]]:
    """Solve; with the per-joint protocol also return each joint's own solution."""
    from ocp_traj.solvers import Request, parse_solver
    from ocp_traj.solvers.per_joint import join_joints, search_joints
    from ocp_traj.solvers.population.population import Population
    from ocp_traj.solving import judge, solve

    name, seed, budget = request["solver"], request["seed"], request["budget"]
    solver = parse_solver(name)
    if task.search.protocol == "per-joint" and isinstance(solver, Population):
        parts = search_joints(task, Request(seed, budget), solver)
        return judge(task, name, seed, join_joints(task, parts, solver)), parts
    return solve(task, name, seed=seed, budget=budget), {}


def _thin(history: History) -> dict[str, Any]:
    """Return a history with its best candidates, thinned after its first entries, for JSON."""
    last = max(len(history) - 1, 0)
    spaced = np.linspace(0, last, THINNED_ENTRIES).astype(int)
    kept = np.unique(np.concatenate([np.arange(min(DENSE_ENTRIES, last + 1)), spaced]))[: len(history)]
    return {
        "generation": kept.tolist(),
        "cost": history.cost[kept].tolist(),
        "violation": history.violation[kept].tolist(),
        "x": np.round(history.x[kept], 6).tolist(),
    }
