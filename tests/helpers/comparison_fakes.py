"""Runs that need no solver: quick and deterministic, or misbehaving in every way a native solver can."""

from __future__ import annotations

import ctypes
import hashlib
import os
import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from ocp_traj.comparison.runs.plan import CaseChoice

RUNNER = "helpers.comparison_fakes:run"


def identify(choice: CaseChoice) -> tuple[str, str]:
    """Label and digest of a case that exists only by name."""
    label = choice.case + "".join(choice.overrides)
    return label, hashlib.sha256(label.encode()).hexdigest()[:16]


def run(request: Mapping[str, Any]) -> dict[str, Any]:
    """Behave as the solver's name says."""
    name, _, parameter = request["solver"].partition(":")
    if name in _BEHAVIOURS:
        _BEHAVIOURS[name]()
    answer = _answer(request)
    if name == "nan":
        return answer | {
            "status": "failed",
            "objective": None,
            "claimed": False,
            "feasible": False,
            "trajectory": None,
        }
    if name == "liar":
        return answer | {
            "feasible": False,
            "worst": {"limit": "velocity", "joint": 2, "time": 0.5, "ratio": 1.4},
        }
    if name == "process":
        return answer | {"message": str(os.getpid())}
    if name == "sleep":
        time.sleep(float(parameter))
    if name == "work":
        _work(float(parameter))
    return answer


def _answer(request: Mapping[str, Any]) -> dict[str, Any]:
    rng = np.random.default_rng([request["seed"], len(request["solver"])])
    costs = 2.0 + np.sort(rng.exponential(size=20))[::-1]
    return {
        "status": "converged",
        "message": "said so",
        "claimed": True,
        "feasible": True,
        "objective": float(costs[-1]),
        "duration": float(costs[-1]),
        "dimension": 5,
        "evaluations": 200,
        "build_time": 0.01,
        "solve_time": 0.02,
        "worst": {"limit": "velocity", "joint": 1, "time": 0.5, "ratio": 1.0},
        "waypoint_error": 0.0,
        "history": {
            "evaluations": list(range(10, 201, 10)),
            "cost": costs.tolist(),
            "violation": [0.0] * 20,
            "seconds": np.linspace(0.001, 0.02, 20).tolist(),
        },
        "trajectory": {
            "schema": 1,
            "case": request["case_name"],
            "family": "cubic",
            "waypoint_times": [0.0, 1.0],
        },
    }


def _work(seconds: float) -> None:
    end = time.process_time() + seconds
    while time.process_time() < end:
        sum(range(1000))


def _loop() -> None:
    """Hold the interpreter in native code for ever: no Python signal handler ever runs."""
    ctypes.PyDLL(None).usleep(2_000_000_000)


def _segfault() -> None:
    ctypes.string_at(0)


def _hungry() -> None:
    blocks = []
    for _ in range(1000):
        blocks.append(np.ones(4_000_000))


def _raise() -> None:
    raise ZeroDivisionError("the solver's own bug")


def _refuse_memory() -> None:
    raise MemoryError


def _exit() -> None:
    os._exit(3)


_BEHAVIOURS = {
    "loop": _loop,
    "segfault": _segfault,
    "hungry": _hungry,
    "raise": _raise,
    "refused": _refuse_memory,
    "exit": _exit,
}
