"""Why a task has no solution: conflicts that are certain, and the least set of limits that must give way.

The elastic phase gives every limit a slack and minimises the sum of the slacks, each in parts of its limit. What is
left over at the minimum names the limits, joints and gaps in conflict; if nothing is left over, its motion is a
feasible start.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.constraints import DERIVATIVE_LIMITS
from ocp_traj.nlp import RowBlock
from ocp_traj.solvers.account import Account
from ocp_traj.task import Objective, TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.lifted import LiftedNlp

HARD_ROWS = ("continuity", "boundary jerk", "energy", "energy_without_regeneration")
"""Rows that define the motion or a cost, not a limit."""

ITERATIONS = 150
CONSISTENT = 1e-6
"""Rows of the elastic phase must hold this well for its slacks to mean anything."""

TIME_WEIGHT = 1e-4
"""Cost of the duration, in units of the guess's, beside the slacks: without it a slow motion may run away."""

NOTHING = 1e-9
"""Slacks below this, in parts of the limit, are rounding."""

_UNITS = {"velocity": "rad/s", "acceleration": "rad/s^2", "jerk": "rad/s^3"}


# Conflicts that are certain ----------------------------------------------------------------------------------


def certain_conflict(task: TrajectoryTask) -> str:
    """Return a sentence when no motion whatever can solve the task, else an empty one."""
    return _zero_limit(task) or _boundary_outside(task) or _gravity_torque(task) or _too_fast(task)


def _zero_limit(task: TrajectoryTask) -> str:
    slack = np.asarray(task.tolerance)
    least = np.abs(np.diff(task.waypoints, axis=0)) - slack[1:] - slack[:-1]
    signed = np.diff(task.waypoints, axis=0)
    for name in ("velocity", "acceleration", "jerk"):
        limits = task.limits.get(name)
        for gap, joint in np.argwhere(least > 0):
            lower, upper = limits[gap, :, joint]
            stuck = lower == 0 == upper and (name == "velocity" or _starts_still(task, gap, joint))
            wrong_way = name == "velocity" and (upper == 0 if signed[gap, joint] > 0 else lower == 0)
            if stuck or wrong_way:
                return (
                    f"{name}: joint {joint + 1}, gap {gap + 1}: the limit is 0, but the joint must move by "
                    f"{signed[gap, joint]:.6g}."
                )
    return ""


def _starts_still(task: TrajectoryTask, gap: int, joint: int) -> bool:
    """Return whether a joint enters or leaves a gap at rest, so that it cannot move without acceleration."""
    velocity = np.asarray(task.boundary.velocity)
    acceleration = task.boundary.acceleration
    still = [velocity[side, joint] == 0 for side in (0, 1)]
    if acceleration is not None:
        still = [flag and np.asarray(acceleration)[side, joint] == 0 for side, flag in enumerate(still)]
    return bool((gap == 0 and still[0]) or (gap == task.gaps - 1 and still[1]))


def _boundary_outside(task: TrajectoryTask) -> str:
    for name in ("velocity", "acceleration", "jerk"):
        given = getattr(task.boundary, name)
        if given is None:
            continue
        for side, gap, word in ((0, 0, "start"), (1, task.gaps - 1, "end")):
            lower, upper = task.limits.get(name)[gap]
            value = np.asarray(given)[side]
            outside = np.flatnonzero((value > upper * (1 + 1e-12)) | (value < lower * (1 + 1e-12)))
            if len(outside):
                joint = int(outside[0])
                return (
                    f"{name}: joint {joint + 1}, gap {gap + 1}: {value[joint]:.6g} {_UNITS[name]} is asked for at "
                    f"the {word}, outside the limits {lower[joint]:.6g} to {upper[joint]:.6g}."
                )
    return ""


def _gravity_torque(task: TrajectoryTask) -> str:
    """Look at the ends: with velocity and acceleration given there, so is the torque."""
    if not task.limited("torque") or task.boundary.acceleration is None or np.any(task.tolerance):
        return ""
    assert task.robot is not None
    ends = task.waypoints[[0, -1]]
    torque = task.robot.torque(ends, task.boundary.velocity, task.boundary.acceleration)
    for side, gap, number in ((0, 0, 1), (1, task.gaps - 1, len(task.waypoints))):
        lower, upper = task.limits.get("torque")[gap]
        over = np.maximum(torque[side] - upper, lower - torque[side])
        joint = int(np.argmax(over))
        if over[joint] > 1e-9 * max(abs(torque[side, joint]), 1e-300):
            return (
                f"torque: joint {joint + 1}, gap {gap + 1}: {torque[side, joint]:.6g} N m are needed at waypoint "
                f"{number}, outside the limits {lower[joint]:.6g} to {upper[joint]:.6g}."
            )
    return ""


def _too_fast(task: TrajectoryTask) -> str:
    """Compare the durations allowed with the travel at full speed."""
    slack = np.asarray(task.tolerance)
    travel = np.diff(task.waypoints, axis=0)
    least = np.maximum(np.abs(travel) - slack[1:] - slack[:-1], 0.0)
    limit = task.limits.get("velocity")
    speed = np.where(travel > 0, limit[:, 1], -limit[:, 0])
    needed = np.divide(least, speed, out=np.zeros_like(least), where=(least > 0) & (speed > 0))
    gaps, total = needed.max(axis=1), np.asarray(task.objective.duration)[1]
    for gap, most in enumerate(np.asarray(task.objective.gap_durations)[:, 1]):
        if gaps[gap] > most * (1 + 1e-9):
            joint = int(np.argmax(needed[gap]))
            return (
                f"duration: gap {gap + 1}: at most {most:.6g} s are allowed, but joint {joint + 1} needs "
                f"{gaps[gap]:.6g} s at its velocity limit."
            )
    if gaps.sum() > total * (1 + 1e-9):
        return (
            f"duration: at most {total:.6g} s are allowed in total, but the velocity limits alone need "
            f"{gaps.sum():.6g} s."
        )
    return ""


def too_short(task: TrajectoryTask, shortest: Callable[[TrajectoryTask], float | None]) -> str:
    """Return a sentence when the total duration is bounded and the shortest motion found is longer.

    Parameters
    ----------
    shortest : callable
        Solves a task and returns the duration, None where it found none.
    """
    high = float(np.asarray(task.objective.duration)[1])
    if not np.isfinite(high):
        return ""
    fastest = Objective(time=1.0, gap_durations=task.objective.gap_durations)
    found = shortest(task.changed(objective=fastest))
    if found is None or found <= high * (1 + 1e-9):
        return ""
    return f"duration: at most {high:.6g} s are allowed, the shortest motion found takes {found:.6g} s."


# The elastic phase -------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class LeastViolation:
    """The motion that breaks limits least.

    Attributes
    ----------
    trajectory : Trajectory
    excess : float
        Largest slack, in parts of its limit.
    sentence : str
        The limits that give way, the largest first.
    """

    trajectory: Trajectory
    excess: float
    sentence: str


def elastic_phase(nlp: LiftedNlp, x: Array, account: Account) -> LeastViolation | None:
    """Return the motion with the least sum of broken limits near a point, None when IPOPT finds none.

    Parameters
    ----------
    nlp : LiftedNlp
    x : (d,) first point
    account : Account
        Pays for it.
    """
    clock = time.perf_counter()
    rows, bounds = _soft_rows(nlp), _soft_bounds(nlp)
    problem, options = _elastic_problem(nlp, rows, bounds)
    size, soft = len(x), len(rows) + len(bounds)
    seconds = account.seconds_left()
    if seconds is not None:
        options["ipopt.max_wall_time"] = max(seconds, 1e-3)
    options["ipopt.max_iter"] = account.evaluations_left(ITERATIONS)
    lower = np.concatenate([nlp.lower, np.zeros(2 * soft)])
    upper = np.concatenate([nlp.upper, np.full(2 * soft, np.inf)])
    lower[bounds], upper[bounds] = -np.inf, np.inf
    g_lower = np.concatenate([nlp.g_lower, nlp.lower[bounds]])
    g_upper = np.concatenate([nlp.g_upper, nlp.upper[bounds]])
    solver = ca.nlpsol("elastic", "ipopt", problem, options)
    account.build_time += time.perf_counter() - clock
    clock = time.perf_counter()
    start = np.concatenate([x, np.full(2 * soft, 1e-2)])
    answer = solver(x0=start, lbx=lower, ubx=upper, lbg=g_lower, ubg=g_upper)
    account.record(solver.stats(), time.perf_counter() - clock)
    found = np.array(answer["x"]).ravel()
    rest = np.maximum(np.array(answer["g"]).ravel() - g_upper, g_lower - np.array(answer["g"]).ravel())
    if not np.isfinite(found).all() or rest.max(initial=0.0) > CONSISTENT:
        return None
    slack = found[size : size + soft] + found[size + soft :]
    sentence = _sentence(nlp, rows, bounds, slack)
    return LeastViolation(nlp.decode(found[:size]), float(slack.max(initial=0.0)), sentence)


def _soft_rows(nlp: LiftedNlp) -> Any:
    """Return the rows that are limits."""
    hard = [np.full(len(block), block.limit in HARD_ROWS) for block in nlp.rows]
    return np.flatnonzero(~np.concatenate([*hard, np.empty(0, dtype=bool)]))


def _soft_bounds(nlp: LiftedNlp) -> Any:
    """Return the knot states whose bounds are limits, not given values."""
    layout = nlp.layout
    index = np.arange(layout.segments, layout.size)
    free = (np.isfinite(nlp.lower) | np.isfinite(nlp.upper))[index] & (nlp.lower < nlp.upper)[index]
    return index[free]


def _elastic_problem(nlp: LiftedNlp, rows: Any, bounds: Any) -> tuple[dict[str, Any], dict[str, Any]]:
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
    weights[: nlp.layout.segments] = TIME_WEIGHT / nlp.layout.segments
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
        "ipopt.tol": 1e-7,
        "ipopt.barrier_tol_factor": 100.0,
        **derivatives,
    }
    return {"x": z, "f": f, "g": g}, options


def _sentence(nlp: LiftedNlp, rows: Any, bounds: Any, slack: Array) -> str:
    """Name the largest slack of every limit that must give way, the largest first."""
    labels = [_row_label(nlp.rows, int(row)) for row in rows]
    labels += [_state_label(nlp, int(index)) for index in bounds]
    worst: dict[str, tuple[float, str]] = {}
    for (limit, where), amount in zip(labels, slack):
        if amount > max(NOTHING, worst.get(limit, (0.0, ""))[0]):
            worst[limit] = (float(amount), where)
    parts = sorted(worst.items(), key=lambda item: -item[1][0])
    return "; ".join(
        f"{limit.replace('_', ' ')}: {where}: {100 * amount:.3g} % over its limit in the motion that breaks limits "
        "least"
        for limit, (amount, where) in parts
    ) + (f"{_held(nlp.task)}." if parts else "")


def _held(task: TrajectoryTask) -> str:
    """Say where the torque limits do not even hold the arm still."""
    if not task.limited("torque"):
        return ""
    assert task.robot is not None
    still = np.zeros_like(task.waypoints)
    torque = task.robot.torque(task.waypoints, still, still)
    for index in range(len(task.waypoints)):
        lower, upper = task.limits.get("torque")[min(index, task.gaps - 1)]
        over = np.maximum(torque[index] - upper, lower - torque[index])
        joint = int(np.argmax(over))
        if over[joint] > 0:
            return (
                f"; the torque limit of joint {joint + 1} does not hold the arm at waypoint {index + 1}, where gravity "
                f"alone needs {torque[index, joint]:.6g} N m"
            )
    return ""


def _row_label(blocks: list[RowBlock], row: int) -> tuple[str, str]:
    for block in blocks:
        if row < len(block):
            if block.limit == "duration":
                return block.limit, "in total" if len(block) == 1 and row == 0 else f"gap {block.gap[row] + 1}"
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
