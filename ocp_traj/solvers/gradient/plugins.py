"""CasADi's nlpsol plug-ins: what each is told, and what its answers mean."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import casadi as ca

from metaheuristics import Status


@dataclass(frozen=True)
class Stage:
    """What is asked of one call of a plug-in.

    Attributes
    ----------
    tolerance : float
    iterations : int
    seconds : float or None
        Left at most.
    warm : bool
        The first point is near the answer.
    dual : bool
        Multipliers come with it.
    cost_scale : float
        One over the size of the cost, more for many gaps.
    exact : bool
        Use the exact Hessian, else an approximation by gradients.
    """

    tolerance: float
    iterations: int
    seconds: float | None
    warm: bool
    dual: bool
    cost_scale: float
    exact: bool = True


@dataclass(frozen=True)
class Plugin:
    """How one plug-in is used.

    Attributes
    ----------
    options : callable
        From a `Stage` to the plug-in's own options.
    statuses : dict
        The plug-in's return status in the words of the shared interface; anything else is a failure.
    own_derivatives : bool
        It takes ready derivative functions; for others CasADi differentiates the problem again.
    takes_multipliers : bool
        A warm start with multipliers pays.
    linear_solver : str
        CasADi's linear solver without which it fails on every problem of size; empty where it brings its own.
    """

    options: Callable[[Stage], dict[str, Any]]
    statuses: dict[str, Status] = field(default_factory=dict)
    own_derivatives: bool = False
    takes_multipliers: bool = False
    linear_solver: str = ""


def _ipopt(stage: Stage) -> dict[str, Any]:
    options: dict[str, Any] = {
        "print_level": 0,
        "sb": "yes",
        "honor_original_bounds": "yes",  # a waypoint's box is kept to 1e-8, IPOPT relaxes bounds by as much
        "mu_strategy": "monotone",
        "mu_init": 1e-2,
        "tol": stage.tolerance,
        "max_iter": stage.iterations,
        "obj_scaling_factor": stage.cost_scale,
    }
    if stage.seconds is not None:
        options["max_wall_time"] = max(stage.seconds, 1e-3)
    if not stage.exact:
        options["hessian_approximation"] = "limited-memory"
    if stage.warm:
        options["mu_init"] = 1e-4
    if stage.dual:
        near = ("bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac", "mult_bound_push")
        options.update({f"warm_start_{name}": 1e-6 for name in near})
        options.update({"warm_start_init_point": "yes", "mu_init": 1e-6})
    return {f"ipopt.{name}": value for name, value in options.items()}


def _fatrop(stage: Stage) -> dict[str, Any]:
    return {
        "structure_detection": "none",
        "fatrop.print_level": 0,
        "fatrop.tol": stage.tolerance,
        "fatrop.max_iter": stage.iterations,
    }


def _uno(stage: Stage) -> dict[str, Any]:
    options: dict[str, Any] = {
        "uno.preset": "ipopt",
        "uno.logger": "SILENT",
        "uno.max_iterations": stage.iterations,
    }
    if stage.seconds is not None:
        options["uno.time_limit"] = max(stage.seconds, 1e-3)
    return options


def _sleqp(stage: Stage) -> dict[str, Any]:
    return {"print_level": 0, "max_iter": stage.iterations}


def _blocksqp(stage: Stage) -> dict[str, Any]:
    quiet = {"print_header": False, "print_iteration": False, "print_maxit_reached": False}
    return {"max_iter": stage.iterations, **quiet}


def _sqpmethod(stage: Stage) -> dict[str, Any]:
    quiet = {"print_header": False, "print_iteration": False, "print_status": False}
    return {
        "qpsol": "piqp",
        "qpsol_options": {"error_on_fail": False},
        "convexify_strategy": "regularize",
        "elastic_mode": True,
        "max_iter": stage.iterations,
        **quiet,
    }


def _no_options(stage: Stage) -> dict[str, Any]:
    return {}


IPOPT_STATUSES = {
    "Solve_Succeeded": Status.CONVERGED,
    "Solved_To_Acceptable_Level": Status.CONVERGED,
    "Feasible_Point_Found": Status.CONVERGED,
    "Infeasible_Problem_Detected": Status.INFEASIBLE,
    "Search_Direction_Becomes_Too_Small": Status.STALLED,
    "Maximum_Iterations_Exceeded": Status.BUDGET_EXHAUSTED,
    "Maximum_CpuTime_Exceeded": Status.TIME_EXHAUSTED,
    "Maximum_WallTime_Exceeded": Status.TIME_EXHAUSTED,
}

UNIFIED_STATUSES = {
    "SOLVER_RET_SUCCESS": Status.CONVERGED,
    "SOLVER_RET_LIMITED": Status.BUDGET_EXHAUSTED,
    "SOLVER_RET_INFEASIBLE": Status.INFEASIBLE,
}
"""CasADi's own summary, for plug-ins whose words are not listed."""

PLUGINS: dict[str, Plugin] = {
    "ipopt": Plugin(_ipopt, IPOPT_STATUSES, own_derivatives=True, takes_multipliers=True),
    "uno": Plugin(_uno),
    "fatrop": Plugin(_fatrop),
    "sleqp": Plugin(_sleqp),
    "sqpmethod": Plugin(_sqpmethod),
    "blocksqp": Plugin(_blocksqp, linear_solver="ma27"),
}
OTHER = Plugin(_no_options)
"""Any plug-in that is not listed: its own defaults."""


def plugin_named(name: str) -> Plugin:
    """Return how a plug-in is used."""
    return PLUGINS.get(name, OTHER)


def read_status(plugin: Plugin, stats: dict[str, Any]) -> tuple[Status, str]:
    """Return a call's status and the plug-in's own word for it."""
    word, unified = stats.get("return_status"), stats.get("unified_return_status")
    message = str(unified if word is None or isinstance(word, (int, float)) else word)
    if stats.get("success"):
        return Status.CONVERGED, message
    found = plugin.statuses.get(message, UNIFIED_STATUSES.get(str(unified), Status.FAILED))
    return found, message


# What a plug-in can do here ----------------------------------------------------------------------------------

PROBE_SIZE = 6
PROBE_ITERATIONS = 100


@cache
def unavailable_reason(name: str) -> str:
    """Return why a plug-in cannot be used, an empty sentence when it can: it has to load and to solve a problem.

    Loading is not enough, as some plug-ins look for their linear solver only when they meet a sparse problem.
    """
    plugin = plugin_named(name)
    try:
        if not ca.has_nlpsol(name):
            ca.load_nlpsol(name)  # fails, and says why
        if plugin.linear_solver and not ca.has_linsol(plugin.linear_solver):
            ca.load_linsol(plugin.linear_solver)
        stats = _solve_probe(name, plugin)
    except RuntimeError as error:
        return readable_reason(str(error))
    if stats.get("success"):
        return ""
    return f"it fails on a problem of {PROBE_SIZE} variables: {read_status(plugin, stats)[1]}"


def _solve_probe(name: str, plugin: Plugin) -> dict[str, Any]:
    """Solve min |x|^2 + x_1 subject to x_(k+1) = x_k^2 + 0.1, a chain as in a motion, and return the statistics."""
    x = ca.MX.sym("x", PROBE_SIZE)
    problem = {"x": x, "f": ca.sumsqr(x) + x[0], "g": x[1:] - x[:-1] ** 2}
    stage = Stage(1e-6, PROBE_ITERATIONS, None, False, False, 1.0)
    options = {"print_time": False, "error_on_fail": False, **plugin.options(stage)}
    solver = ca.nlpsol("probe", name, problem, options)
    solver(x0=0.1, lbx=-10.0, ubx=10.0, lbg=0.1, ubg=0.1)
    return solver.stats()


def readable_reason(message: str) -> str:
    """Return the one fact a person needs from CasADi's pages on a library that does not load."""
    wanted = re.search(r"Cannot load shared library '(?:lib)?([^']*?)(?:\.so)?'", message)
    missing = [name for name in re.findall(r"Error code: (\S+?): ", message) if not name.startswith("./")]
    if wanted is None:
        return message.strip().splitlines()[-1].strip()
    part = wanted.group(1).replace("casadi_", "").replace("_", " ")
    if missing:
        return f"its part {part!r} needs {missing[0]}, which is not on this computer"
    return f"this CasADi has no part {part!r}"
