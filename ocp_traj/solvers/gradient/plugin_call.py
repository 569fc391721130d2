"""One call of an nlpsol plug-in: from a numerical problem to an answer."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from metaheuristics import Status
from ocp_traj.arrays import Array
from ocp_traj.solvers.gradient.account import Account
from ocp_traj.solvers.gradient.plugins import Stage, plugin_named, read_status, readable_reason
from ocp_traj.solvers.gradient.settings import GradientSettings, Tuning
from ocp_traj.solvers.pace import NO_TIME, derivatives_in_time
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.condensed.condensed import CondensedNlp
from ocp_traj.transcription.lifted.lifted import LiftedNlp
from ocp_traj.transcription.nlp import Nlp, RowBlock

ACCEPTABLE = "Solved_To_Acceptable_Level"
"""IPOPT's word for giving up near an answer."""

STEEPEST_COST = 100.0
"""Gradient of the cost above which IPOPT scales the cost down to it (its option nlp_scaling_max_gradient)."""


@dataclass(frozen=True, eq=False)
class Answer:
    """One call of the plug-in, or the last one of several.

    Attributes
    ----------
    nlp : Nlp
    x : (d,)
    trajectory : Trajectory
    status, message
    cost : float
    violation : (m,)
    row_multipliers, bound_multipliers : (m,), (d,)
    """

    nlp: Nlp
    x: Array
    trajectory: Trajectory
    status: Status
    message: str
    cost: float
    violation: Array
    row_multipliers: Array
    bound_multipliers: Array

    @property
    def solved(self) -> bool:
        """Converged to a motion."""
        return self.status is Status.CONVERGED

    @property
    def rank(self) -> tuple[bool, float, float]:
        """What makes one answer better than another, smaller first."""
        excess = float(self.violation.max(initial=0.0))
        return not self.solved, 0.0 if self.solved else excess, self.cost


def call_plugin(
    nlp: Nlp, settings: GradientSettings, account: Account, *, warm: bool, before: Answer | None = None
) -> Answer:
    """Call the plug-in; `before` is the answer of the same task with fewer points.

    Second derivatives of exact extrema do not exist where two of them meet. A call that ends there is made
    again with an approximate Hessian; one that goes to and fro there, with samples instead of extrema.
    """
    answer = _call_once(nlp, settings, account, warm=warm, before=before)
    if not isinstance(nlp, CondensedNlp) or account.exhausted():
        return answer
    if answer.status is Status.FAILED:
        return _call_once(nlp, settings, account, warm=warm, before=before, exact=False)
    if answer.status is Status.BUDGET_EXHAUSTED:
        samples = settings.tuning.most_samples
        sampled = condensed_from(nlp.task, answer.trajectory, settings, samples, extrema="sampled")
        return _call_once(sampled, settings, account, warm=warm, before=before)
    return answer


def condensed_from(
    task: TrajectoryTask, guess: Trajectory, settings: GradientSettings, samples: int, extrema: str = "auto"
) -> CondensedNlp:
    """Return the condensed form in logarithms of the durations, started from a guess."""
    durations, wide = np.asarray(guess.segment_durations), settings.tuning.duration_range
    bounds = float(durations.min()) / wide, float(durations.max()) * wide
    encoding = "log-durations"
    return CondensedNlp(task, encoding=encoding, samples=samples, extrema=extrema, bounds=bounds, guess=guess)


def _call_once(
    nlp: Nlp,
    settings: GradientSettings,
    account: Account,
    *,
    warm: bool,
    before: Answer | None,
    exact: bool = True,
) -> Answer:
    clock = time.perf_counter()
    order, seconds = derivatives_in_time(nlp, account.left.time_limit)
    if not order:
        account.build_time += time.perf_counter() - clock
        account.evaluations += 1
        return replace(first_point(nlp, NO_TIME), status=Status.TIME_EXHAUSTED)
    plugin = plugin_named(settings.plugin)
    dual = before is not None and plugin.takes_multipliers and isinstance(nlp, LiftedNlp)
    first = before.x if dual and before is not None else np.asarray(nlp.guess)
    long = nlp.task.gaps > settings.tuning.long_path
    stage = Stage(
        max(settings.tolerance, settings.tuning.long_path_tolerance) if long else settings.tolerance,
        account.evaluations_left(settings.iterations),
        seconds,
        warm or before is not None,
        dual,
        _cost_scale(nlp, first, settings.tuning),
        exact and order > 1,
    )
    quiet = {"print_time": False, "error_on_fail": False, "show_eval_warnings": False}
    options = {**quiet, **plugin.options(stage)}
    if plugin.own_derivatives:  # and no gradient of the Lagrangian: nobody asks for it
        options.update({"no_nlp_grad": True, **nlp.derivatives})
    solver = ca.nlpsol("solver", settings.plugin, {"x": nlp.x, "f": nlp.f, "g": nlp.g}, options)
    account.build_time += time.perf_counter() - clock
    given: dict[str, Any] = {"x0": nlp.guess}
    if dual and before is not None:
        multipliers = carry_multipliers(before.nlp.rows, nlp.rows, before.row_multipliers)
        given = {"x0": before.x, "lam_x0": before.bound_multipliers, "lam_g0": multipliers}
    clock = time.perf_counter()
    try:
        answer = solver(**given, lbx=nlp.lower, ubx=nlp.upper, lbg=nlp.g_lower, ubg=nlp.g_upper)
    except RuntimeError as error:  # what a plug-in makes of a subproblem it cannot solve
        account.record({}, time.perf_counter() - clock)  # it keeps no statistics of such a call
        return first_point(nlp, readable_reason(str(error)))
    stats = solver.stats()
    account.record(stats, time.perf_counter() - clock)
    found = _read_answer(nlp, answer, *read_status(plugin, stats))
    if found.message == ACCEPTABLE and found.violation.max(initial=0.0) > settings.tuning.acceptable_violation:
        return replace(found, status=Status.STALLED)  # where segments vanish, a little in a row is much in the motion
    return found


def _read_answer(nlp: Nlp, answer: dict[str, Any], status: Status, message: str) -> Answer:
    x, g, on_rows, on_bounds = (np.array(answer[name]).ravel() for name in ("x", "g", "lam_g", "lam_x"))
    if not np.isfinite(x).all():
        x, status = np.asarray(nlp.guess), Status.FAILED
    cost, violation = float(answer["f"]), nlp.violations(g)
    return Answer(nlp, x, nlp.decode(x), status, message, cost, violation, on_rows, on_bounds)


def first_point(nlp: Nlp, message: str) -> Answer:
    """Return the first point as an answer that failed."""
    x = np.asarray(nlp.guess)
    found = nlp.evaluate(x[None, :])
    nothing = np.zeros(len(nlp.g_lower)), np.zeros(len(x))
    cost, violation = float(found.cost[0]), found.violation[0]
    return Answer(nlp, x, nlp.decode(x), Status.FAILED, message, cost, violation, *nothing)


def _cost_scale(nlp: Nlp, first: Array, tuning: Tuning) -> float:
    """Return one over the size of the cost at the guess, more for many gaps.

    IPOPT scales a steep cost by its gradient at the first point besides; that is undone, so that the size of a
    weight decides nothing.
    """
    ready = nlp.derivatives.get("grad_f")
    if ready is None:
        cost, steepness = float(nlp.evaluate(np.asarray(nlp.guess)[None, :]).cost[0]), 0.0
    else:
        cost = float(ready(nlp.guess, [])[0])
        steepness = float(np.abs(np.array(ready(first, [])[1])).max(initial=0.0))
    gaps = max(1.0, (nlp.task.gaps - tuning.unscaled_gaps) / 2)
    return gaps * max(1.0, steepness / STEEPEST_COST) / max(abs(cost), 1e-300)


def carry_multipliers(old: list[RowBlock], new: list[RowBlock], multipliers: Array) -> Array:
    """Return multipliers for a problem with more rows: blocks of one limit match in order, new rows get zero."""
    kept = {key: multipliers[rows] for key, rows in _blocks(old)}
    result = np.zeros(sum(map(len, new)))
    for key, rows in _blocks(new):
        values = kept.get(key, np.empty(0))[: rows.stop - rows.start]
        result[rows.start : rows.start + len(values)] = values
    return result


def _blocks(rows: list[RowBlock]) -> Iterator[tuple[tuple[str, int], slice]]:
    seen: dict[str, int] = {}
    start = 0
    for block in rows:
        count = seen.get(block.limit, 0)
        seen[block.limit] = count + 1
        yield (block.limit, count), slice(start, start + len(block))
        start += len(block)
