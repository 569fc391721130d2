"""What happens inside the child process: load the case, solve it, let the audit judge, pack the record."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ocp_traj.files import finite

HISTORY_POINTS = 256
"""At most this many points of a convergence history are kept."""

BOUND_SECONDS = 5.0
"""Time the proof of a case's kinematic bound may take."""

_TOLERANCE = 1e-6


def warm_up() -> None:
    """Import what every run needs, so that the first run is not slower than the others."""
    import ocp_traj.audit
    import ocp_traj.case
    import ocp_traj.solving  # noqa: F401


def solve_case(request: Mapping[str, Any]) -> dict[str, Any]:
    """Execute one run; see `ocp_traj.comparison.runs.record.RunRecord` for the answer."""
    from ocp_traj.case import load_case
    from ocp_traj.solving import solve

    task = load_case(request["case"], request["overrides"])
    result = solve(
        task,
        request["solver"],
        seed=request["seed"],
        budget=request["budget"],
        time_limit=request["time_limit"],
    )
    return pack_result(result)


def pack_result(result: Any) -> dict[str, Any]:
    """Return the record of an `ocp_traj.solving.SolveResult`."""
    from ocp_traj.case import task_to_json
    from ocp_traj.trajectory_files import to_json

    solution, verdict = result.solution, result.audit
    answer = {
        "status": solution.status.key,
        "message": result.message,
        "claimed": claims_success(solution),
        "feasible": verdict is not None and bool(verdict.feasible),
        "objective": finite(result.objective),
        "duration": finite(result.duration),
        "energy": finite(result.energy),
        "dimension": int(np.size(solution.x)) or None,
        "evaluations": int(solution.evaluations),
        "build_time": float(solution.build_time),
        "solve_time": float(solution.solve_time),
        "history": thin_history(solution.history),
    }
    if verdict is not None:
        answer |= {
            "worst": verdict.to_json()["worst"],
            "waypoint_error": float(verdict.waypoint_error),
            "smallest_feasible_scale": verdict.smallest_feasible_scale,
            "findings": list(verdict.findings),
        }
    if result.trajectory is not None:
        answer["trajectory"] = {**to_json(result.trajectory), "task": task_to_json(result.task)}
    if answer["feasible"] and answer["objective"] is None:
        answer |= {
            "feasible": False,
            "status": "failed",
            "message": f"objective is no number; {result.message}",
        }
    return finite(answer)


def claims_success(solution: Any) -> bool:
    """Whether a solver itself says that its answer keeps every constraint.

    ``converged`` is such a claim; so is a search that ran out of budget or time, or stalled, with a violation
    below 1e-6. ``infeasible`` and ``failed`` are the opposite.
    """
    status = solution.status.key
    if status in ("infeasible", "failed"):
        return False
    return status == "converged" or bool(solution.total_violation <= _TOLERANCE)


def thin_history(history: Any) -> dict[str, list[float]]:
    """Return at most `HISTORY_POINTS` entries: improvements of the best, and evenly in the logarithm."""
    count = len(history.cost)
    if count == 0:
        return {}
    keep = np.arange(count)
    if count > HISTORY_POINTS:
        changed = np.flatnonzero(np.diff(history.cost) != 0) + 1
        if changed.size > HISTORY_POINTS // 2:
            changed = changed[np.linspace(0, changed.size - 1, HISTORY_POINTS // 2).astype(int)]
        spaced = np.geomspace(1, count, HISTORY_POINTS // 2 - 2).astype(int) - 1
        keep = np.unique(np.concatenate([[0], changed, spaced, [count - 1]]))
    return {
        part: np.asarray(getattr(history, part), dtype=np.float64)[keep].tolist()
        for part in ("evaluations", "cost", "violation", "seconds")
    }


def find_reference(request: Mapping[str, Any]) -> dict[str, Any]:
    """Compute one reference of a case: its durations by part, none where it does not apply."""
    from ocp_traj.case import load_case
    from ocp_traj.references import ReferenceRequest
    from ocp_traj.references.registry import reference_named

    task = load_case(request["case"], request["overrides"])
    wanted = ReferenceRequest(task, time_limit=BOUND_SECONDS, brief=True)
    return finite(reference_named(request["reference"]).find(wanted).seconds)
