"""The least set of limits that must give way, where a solver found no motion that keeps them all.

Every limit gets a slack and the sum of the slacks, each as a fraction of its limit, is minimised. What is left over
at the minimum names the limits, joints and gaps in conflict; if nothing is left over, its motion is a feasible start.
Where IPOPT finds no minimum, the durations are held at those of a slow motion, which leaves an easy problem.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.costs import instant_costs
from ocp_traj.limits import DERIVATIVE_LIMITS
from ocp_traj.solvers.gradient.account import Account
from ocp_traj.solvers.gradient.settings import Tuning
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.lifted.lifted import LiftedNlp
from ocp_traj.transcription.nlp import RowBlock

HARD_ROWS = ("continuity", "boundary jerk")
"""Rows that define the motion, not a limit."""


@dataclass(frozen=True, eq=False)
class LeastViolation:
    """The motion that breaks limits least.

    Attributes
    ----------
    trajectory : Trajectory
    excess : float
        Largest slack, as a fraction of its limit.
    sentence : str
        The limits that give way, the largest first.
    """

    trajectory: Trajectory
    excess: float
    sentence: str


def elastic_phase(nlp: LiftedNlp, x: Array, account: Account, tuning: Tuning) -> LeastViolation | None:
    """Return the motion with the least sum of broken limits near a point, None when IPOPT finds none.

    Parameters
    ----------
    nlp : LiftedNlp
    x : (d,) first point; each slack starts as large as its limit is broken there
    account : Account
        Pays for it.
    tuning : Tuning
    """
    clock = time.perf_counter()
    rows, bounds = soft_rows(nlp), soft_bounds(nlp)
    problem, options = elastic_problem(nlp, rows, bounds, tuning)
    soft = len(rows) + len(bounds)
    limits = {
        "lbx": np.concatenate([nlp.lower, np.zeros(2 * soft)]),
        "ubx": np.concatenate([nlp.upper, np.full(2 * soft, np.inf)]),
        "lbg": np.concatenate([nlp.g_lower, nlp.lower[bounds]]),
        "ubg": np.concatenate([nlp.g_upper, nlp.upper[bounds]]),
    }
    limits["lbx"][bounds], limits["ubx"][bounds] = -np.inf, np.inf
    start = np.concatenate([x, _broken(nlp, x, rows, bounds)])
    account.build_time += time.perf_counter() - clock
    found = _minimise({**options, "ipopt.mu_strategy": "adaptive"}, problem, start, limits, account, tuning)
    if found is not None:
        return _read(nlp, rows, bounds, found, tuning, "in the motion that breaks limits least")
    if account.exhausted():
        return None
    start[: len(x)] = _slow_down(nlp, x, tuning.elastic_slowing)
    still = slice(0, nlp.layout.segments)
    limits["lbx"][still] = limits["ubx"][still] = start[still]
    found = _minimise(options, problem, start, limits, account, tuning)
    return None if found is None else _read(nlp, rows, bounds, found, tuning, "even in a slow motion")


def _slow_down(nlp: LiftedNlp, x: Array, slowing: float) -> Array:
    """Return the variables of the same motion `slowing` times as long, or as long as the task allows."""
    motion = nlp.decode(x)
    longest = float(np.asarray(nlp.task.objective.duration)[1])
    slower = np.array(x)
    slower[: nlp.layout.size] = nlp.layout.encode(motion.scaled(min(slowing, longest / motion.duration)))
    return slower


def _read(
    nlp: LiftedNlp, rows: Any, bounds: Any, found: Array, tuning: Tuning, where: str
) -> LeastViolation:
    size, soft = len(nlp.guess), len(rows) + len(bounds)
    slack = found[size : size + soft] + found[size + soft :]
    sentence = _sentence(nlp, rows, bounds, np.where(slack > tuning.smallest_slack, slack, 0.0), where)
    return LeastViolation(nlp.decode(found[:size]), float(slack.max(initial=0.0)), sentence)


def _minimise(
    options: dict[str, Any],
    problem: dict[str, Any],
    start: Array,
    limits: dict[str, Array],
    account: Account,
    tuning: Tuning,
) -> Array | None:
    """Return IPOPT's answer where it is a minimum and its rows hold, None elsewhere."""
    clock = time.perf_counter()
    seconds = account.left.time_limit
    if seconds is not None:
        options["ipopt.max_wall_time"] = max(seconds, 1e-3)
    options["ipopt.max_iter"] = account.evaluations_left(tuning.elastic_iterations)
    solver = ca.nlpsol("elastic", "ipopt", problem, options)
    account.build_time += time.perf_counter() - clock
    clock = time.perf_counter()
    answer = solver(x0=start, **limits)
    stats = solver.stats()
    account.record(stats, time.perf_counter() - clock)
    found, g = np.array(answer["x"]).ravel(), np.array(answer["g"]).ravel()
    rest = np.maximum(g - limits["ubg"], limits["lbg"] - g).max(initial=0.0)
    # where IPOPT stopped early its slacks are no minimum: they would name conflicts that are none
    return found if stats["success"] and np.isfinite(found).all() and rest <= tuning.elastic_consistency else None


def _broken(nlp: LiftedNlp, x: Array, rows: Any, bounds: Any) -> Array:
    """Return by how much every soft row and bound is over its upper limit, then below its lower one, (2 soft,)."""
    g = np.array(nlp.derivatives["jac_g"](x, [])[0]).ravel()
    value = np.concatenate([g[rows], x[bounds]])
    upper = np.concatenate([nlp.g_upper[rows], nlp.upper[bounds]])
    lower = np.concatenate([nlp.g_lower[rows], nlp.lower[bounds]])
    return np.maximum(np.concatenate([value - upper, lower - value]), 0.0)


def soft_rows(nlp: LiftedNlp) -> Any:
    """Return the rows that are limits: neither the motion nor a kinked cost."""
    hard_rows = {*HARD_ROWS, *(cost.name for cost in instant_costs(nlp.task) if cost.shape != "sum")}
    hard = [np.full(len(block), block.limit in hard_rows) for block in nlp.rows]
    return np.flatnonzero(~np.concatenate([*hard, np.empty(0, dtype=bool)]))


def soft_bounds(nlp: LiftedNlp) -> Any:
    """Return the knot states whose bounds are limits, not given values."""
    layout = nlp.layout
    index = np.arange(layout.segments, layout.size)
    free = (np.isfinite(nlp.lower) | np.isfinite(nlp.upper))[index] & (nlp.lower < nlp.upper)[index]
    return index[free]


def elastic_problem(
    nlp: LiftedNlp, rows: Any, bounds: Any, tuning: Tuning
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return min sum(s) with g(x) - plus + minus in its bounds, soft bounds of x as rows, and derivatives."""
    size, count, soft = len(nlp.guess), len(nlp.g_lower), len(rows) + len(bounds)
    z, p = ca.MX.sym("z", size + 2 * soft), ca.MX.sym("p", 0)
    x = z[:size]
    place = np.concatenate([rows, count + np.arange(len(bounds))]).astype(int)
    select = ca.DM(ca.Sparsity.triplet(count + len(bounds), soft, place.tolist(), list(range(soft))), 1.0)
    picked = ca.DM(ca.Sparsity.triplet(len(bounds), size, list(range(len(bounds))), bounds.tolist()), 1.0)
    value, jacobian = nlp.derivatives["jac_g"](x, p)
    rows_of_g = ca.vertcat(value, ca.mtimes(picked, x))
    g = rows_of_g - ca.mtimes(select, z[size : size + soft]) + ca.mtimes(select, z[size + soft :])
    full = ca.horzcat(ca.vertcat(jacobian, picked), ca.MX(-select), ca.MX(select))
    weights = np.concatenate([np.zeros(size), np.ones(2 * soft)])
    weights[: nlp.layout.segments] = tuning.elastic_time_weight / nlp.layout.segments
    cost = ca.DM(weights)
    f = ca.dot(cost, z)
    factor, multipliers = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", count + len(bounds))
    curvature = nlp.derivatives["hess_lag"](x, p, 0.0, multipliers[:count])
    hessian = ca.diagcat(curvature, ca.MX(2 * soft, 2 * soft))
    derivatives = {
        "grad_f": ca.Function("nlp_grad_f", [z, p], [f, ca.MX(cost)], ["x", "p"], ["f", "grad:f:x"]),
        "jac_g": ca.Function("nlp_jac_g", [z, p], [g, full], ["x", "p"], ["g", "jac:g:x"]),
        "hess_lag": ca.Function(
            "nlp_hess_l",
            [z, p, factor, multipliers],
            [hessian],
            ["x", "p", "lam:f", "lam:g"],
            ["triu:hess:gamma:x:x"],
        ),
    }
    options = {
        "print_time": False,
        "error_on_fail": False,
        "no_nlp_grad": True,
        "ipopt.print_level": 0,
        "ipopt.sb": "yes",
        "ipopt.tol": tuning.elastic_tolerance,
        **derivatives,
    }
    return {"x": z, "f": f, "g": g}, options


def _sentence(nlp: LiftedNlp, rows: Any, bounds: Any, slack: Array, motion: str) -> str:
    """Name the largest slack of every limit that must give way, the largest first."""
    labels = [_row_label(nlp.rows, int(row)) for row in rows]
    labels += [_state_label(nlp, int(index)) for index in bounds]
    worst: dict[str, tuple[float, str]] = {}
    for (limit, where), amount in zip(labels, slack):
        if amount > worst.get(limit, (0.0, ""))[0]:
            worst[limit] = (float(amount), where)
    parts = sorted(worst.items(), key=lambda item: -item[1][0])
    words = [
        f"{limit.replace('_', ' ')}: {where}: {100 * amount:.3g} % over its limit {motion}"
        for limit, (amount, where) in parts
    ]
    return "; ".join(words) + (f"{_held(nlp.task)}." if parts else "")


def _held(task: TrajectoryTask) -> str:
    """Say where the torque limits are furthest from holding the arm still."""
    if not task.limited("torque"):
        return ""
    assert task.robot is not None
    still = np.zeros_like(task.waypoints)
    torque = task.robot.torque(task.waypoints, still, still)
    limits = task.limits.get("torque")[np.minimum(np.arange(len(torque)), task.gaps - 1)]
    over = np.maximum(torque - limits[:, 1], limits[:, 0] - torque)
    size = np.where(np.isfinite(limits), np.abs(limits), 0.0).max(axis=1)
    waypoint, joint = np.unravel_index(np.argmax(over / np.where(size > 0, size, 1.0)), over.shape)
    if over[waypoint, joint] <= 0:
        return ""
    return (
        f"; the torque limit of joint {joint + 1} does not hold the arm at waypoint {waypoint + 1}, where gravity "
        f"alone needs {torque[waypoint, joint]:.6g} N m"
    )


def _row_label(blocks: list[RowBlock], row: int) -> tuple[str, str]:
    for block in blocks:
        if row < len(block):
            if block.limit == "duration":
                return block.limit, "in total" if len(
                    block
                ) == 1 and row == 0 else f"gap {block.gap[row] + 1}"
            joint = f"joint {block.joint[row] + 1}, " if block.joint[row] >= 0 else ""
            return block.limit, f"{joint}gap {block.gap[row] + 1}, {100 * block.fraction[row]:.0f} % into it"
        row -= len(block)
    raise IndexError(row)


def _state_label(nlp: LiftedNlp, index: int) -> tuple[str, str]:
    layout = nlp.layout
    knot, rest = divmod(index - layout.segments, len(layout.moving) * layout.degree)
    joint, order = divmod(rest, layout.degree)
    names = {limit.order: limit.name for limit in DERIVATIVE_LIMITS}
    gap = min(knot, layout.segments - 1) // layout.per_gap
    share = (knot - gap * layout.per_gap) / layout.per_gap
    where = f"joint {layout.moving[joint] + 1}, gap {gap + 1}, {100 * share:.0f} % into it"
    return names[order], where
