"""Gradient solvers: CasADi's nlpsol plug-ins on the lifted form, continued, refined and made exact."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from metaheuristics import Status
from ocp_traj.arrays import Array
from ocp_traj.audit import audit
from ocp_traj.exceptions import InputError, TaskError, UnavailableError
from ocp_traj.limits import instant_limits
from ocp_traj.solvers.gradient.account import Account
from ocp_traj.solvers.gradient.diagnosis import certain_conflict, too_short
from ocp_traj.solvers.gradient.elastic import elastic_phase
from ocp_traj.solvers.gradient.plugins import (
    Stage,
    plugin_named,
    read_status,
    readable_reason,
    unavailable_reason,
)
from ocp_traj.solvers.gradient.refinement import broken_points, new_points
from ocp_traj.solvers.gradient.starts import other_starts
from ocp_traj.solvers.solver import Outcome, Request, Solver
from ocp_traj.spline import Family
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.condensed.condensed import CondensedNlp
from ocp_traj.transcription.guess import initial_guess, insert_knots
from ocp_traj.transcription.lifted.layout import Layout
from ocp_traj.transcription.lifted.lifted import ExtraPoints, LiftedNlp
from ocp_traj.transcription.nlp import Nlp, RowBlock

logger = logging.getLogger(__name__)

LOOSE = 1e-3
"""Tolerance of the stage with few knots: it only has to give a start."""

CONFLICT = 1e-5
"""Limits that must be broken by more than this part are in conflict; less is a solver's rounding."""

ROUGH_ROUNDS = 3
"""Rounds of added points that are solved to `LOOSE` only: the next one moves the motion anyway."""

RELAXATIONS = 3
"""Elastic phases at most, each with the points added since the one before."""

CONFIRMING = 150
"""Iterations of the starts that have to fail, too, before a conflict is told."""

MENDABLE_SCALE, MENDABLE_RATIO = 1.02, 1.0001
"""Uniform slowing, and excess over a limit, up to which a motion counts as found: `solve` mends as much."""

DOUBTS = 2
"""Starts that have to fail, too, before a conflict found is believed."""

ACCEPTABLE, KEPT = "Solved_To_Acceptable_Level", 1e-8
"""IPOPT's word for giving up near an answer, and the violation up to which that is one."""

CONDENSED_SAMPLES, MOST_SAMPLES = 16, 100
"""Samples a gap of the condensed form at first, and from when on they are not doubled any more."""

GAPS_ALONE = 5
"""From more gaps than this on the cost is scaled with their number, as a barrier's weight grows with it."""

NO_POINTS = ExtraPoints()

WIDE = 1e3
"""Durations may be this much shorter or longer than in the guess: the search box binds population methods only."""


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


@dataclass(frozen=True)
class Gradient(Solver):
    """An nlpsol plug-in.

    Parameters
    ----------
    plugin : str
        Name of the plug-in, for instance ``ipopt``.
    tolerance : float
        Convergence tolerance of the plug-in.
    iterations : int
        Iterations at most, a call.
    rounds : int
        How often points with broken limits are added and the problem is solved again, warm.
    samples : int
        Samples a gap of torques and other limited functions of an instant at first.
    attempts : int
        Starts tried at most until one leads to a solution.
    starts : int
        Starts that are solved in any case, the best answer is kept; more than 1 looks for better local optima.
    jobs : int
        Processes for `starts`.
    compiled : bool
        Use machine code for functions of an instant where there is a C compiler; it is kept on disk.
    """

    kind: ClassVar[str] = "gradient"

    plugin: str = "ipopt"
    tolerance: float = 1e-8
    iterations: int = 500
    rounds: int = 8
    samples: int = 4
    attempts: int = 5
    starts: int = 1
    jobs: int = 1
    compiled: bool = True

    def run(self, task: TrajectoryTask, request: Request) -> Outcome:
        """Solve a task: few knots first, then all, then the points between samples; explain a failure."""
        self.check_available()
        account = Account(request)
        conflict = certain_conflict(task)
        if conflict:
            return self._refuse(task, account, conflict)
        answer = self._attempt(task, request.warm_start, account, continued=request.warm_start is None)
        diagnosis = ""
        if not answer.solved:
            answer, diagnosis = self._recover(task, account, answer)
        if answer.solved and self.starts > 1:
            answer = self._best_of_starts(task, account, answer)
        solution = account.solution(
            answer.nlp, answer.x, answer.cost, answer.violation, answer.status, answer.message
        )
        return Outcome(answer.trajectory, solution, account.counts, diagnosis)

    def check_available(self) -> None:
        """Raise `UnavailableError` when the plug-in does not load, or does not solve a small problem."""
        reason = unavailable_reason(self.plugin)
        if reason:
            raise UnavailableError(f"solver {self.plugin!r} cannot be used: {reason}")

    def _refuse(self, task: TrajectoryTask, account: Account, conflict: str) -> Outcome:
        """Return the outcome of a task that cannot have a solution."""
        nlp = self._build(task, initial_guess(task), account)
        nothing = np.full(len(nlp.g_lower), np.inf)
        solution = account.solution(
            nlp, nlp.guess, np.inf, nothing, Status.INFEASIBLE, "No motion is possible."
        )
        return Outcome(None, solution, account.counts, conflict)

    # More than one start -------------------------------------------------------------------------------------

    def _recover(self, task: TrajectoryTask, account: Account, failed: Answer) -> tuple[Answer, str]:
        """Try again from elsewhere after a failure, or explain it; return an answer and the explanation.

        A motion with fewer virtual knots is a start, and the answer if that fails too: the task contains it.
        Otherwise the elastic phase either gives a feasible start or names what is in conflict; as it looks near
        its start only, more starts have to fail, too.
        """
        contained = self._with_fewer_knots(task, account, failed)
        if contained is not None:
            answer = self._attempt(task, contained.trajectory, account, continued=False)
            return (answer if answer.solved else contained), ""
        sentence = too_short(task, lambda longer, sampled: self._shortest(longer, sampled, account))
        if sentence:
            return replace(failed, status=Status.INFEASIBLE), sentence
        best, sentence = self._relax(task, account, failed)
        if best.solved:
            return best, ""
        starts, solver = self.attempts - 1, self
        if sentence:
            starts, solver = DOUBTS, replace(self, iterations=min(self.iterations, CONFIRMING))
        for guess in other_starts(task, np.random.default_rng(account.request.seed), starts):
            if account.exhausted():
                break
            answer = solver._attempt(task, guess, account, continued=False)
            best = min(best, answer, key=lambda each: each.rank)
            if best.solved:
                return best, ""
        stop = account.exhausted()
        if stop is not None:
            return replace(best, status=stop), ""
        return (replace(best, status=Status.INFEASIBLE) if sentence else best), sentence

    def _with_fewer_knots(self, task: TrajectoryTask, account: Account, failed: Answer) -> Answer | None:
        """Return the best motion with fewer virtual knots, its knots inserted; the status stays the failure's."""
        if not isinstance(failed.nlp, LiftedNlp) or failed.status is Status.INFEASIBLE:
            return None
        fewer = {0, *continuation(task.family, task.virtual_knots)} - {task.virtual_knots}
        for knots in sorted(fewer, reverse=True):
            if account.exhausted():
                break
            try:
                smaller = task.changed(virtual_knots=knots)
            except TaskError:  # too few knots for the boundary conditions
                continue
            answer = self._attempt(smaller, None, account, continued=knots > 0)
            if answer.solved:
                motion = fit_guess(task, answer.trajectory)
                nlp = self._build(task, motion, account)
                assert isinstance(nlp, LiftedNlp)
                message = (
                    f"{failed.message}; the motion is the best one found with {knots} virtual knots a gap, "
                    f"which the task with {task.virtual_knots} contains."
                )
                return replace(_first_point(nlp, message), trajectory=motion, status=failed.status)
        return None

    def _relax(self, task: TrajectoryTask, account: Account, failed: Answer) -> tuple[Answer, str]:
        """Start from motions of the elastic phase until one leads to a solution or a conflict has a name.

        An attempt may fail when points between samples are added; the elastic phase then takes those, too.
        """
        best = answer = failed
        for _ in range(RELAXATIONS):
            if account.exhausted() or not (isinstance(answer.nlp, LiftedNlp) and answer.nlp.derivatives):
                break
            least = elastic_phase(answer.nlp, np.asarray(answer.nlp.guess), account)
            if least is None:
                break
            if least.excess > CONFLICT:
                return best, least.sentence
            answer = self._attempt(task, least.trajectory, account, continued=False)
            best = min(best, answer, key=lambda each: each.rank)
            if best.solved:
                break
        return best, ""

    def _shortest(self, task: TrajectoryTask, sampled: bool, account: Account) -> float | None:
        solver = replace(self, rounds=0) if sampled else self
        answer = solver._attempt(task, None, account, continued=True)
        return answer.trajectory.duration if answer.solved else None

    def _best_of_starts(self, task: TrajectoryTask, account: Account, first: Answer) -> Answer:
        """Solve from more starts, in parallel if wanted, and return the best answer."""
        rng = np.random.default_rng(account.request.seed)
        guesses = list(other_starts(task, rng, self.starts - 1))
        if self.jobs > 1:
            from joblib import Parallel, delayed

            single = replace(self, starts=1, attempts=1, jobs=1)
            requests = [replace(account.request, warm_start=guess, progress=None) for guess in guesses]
            found = Parallel(n_jobs=self.jobs)(
                delayed(_trajectory_of)(single, task, each) for each in requests
            )
            guesses = [motion for motion in found if motion is not None]
        answers = [first]
        for guess in guesses:
            if account.exhausted():
                break
            answers.append(self._attempt(task, guess, account, continued=False))
        return min(answers, key=lambda answer: answer.rank)

    # One start -----------------------------------------------------------------------------------------------

    def _attempt(
        self, task: TrajectoryTask, guess: Trajectory | None, account: Account, *, continued: bool
    ) -> Answer:
        """Solve from one start: few knots first if wanted, then the task with points added until none is broken."""
        if continued:
            for knots in continuation(task.family, task.virtual_knots)[:-1]:
                guess = self._solve_few_knots(task, knots, guess, account)
        start = initial_guess(task) if guess is None else fit_guess(task, guess)
        rough = min(ROUGH_ROUNDS, self.rounds) if self._starts_roughly(task) else 0
        return self._refine(task, start, account, warm=guess is not None, rough=rough)

    def _refine(
        self, task: TrajectoryTask, start: Trajectory, account: Account, *, warm: bool, rough: int
    ) -> Answer:
        """Solve, add what is found broken and solve again; the first `rough` rounds to `LOOSE` only.

        When a round fails after loose ones, all is done again without those.
        """
        extra, samples, answer, loose = ExtraPoints(), 0, None, False
        nlp = self._build(task, start, account)
        for _ in range(self.rounds + 1):
            solver = replace(self, tolerance=max(LOOSE, self.tolerance)) if rough else self
            found = solver._call(nlp, account, warm=warm, before=answer)
            if not found.solved:
                if loose and not account.exhausted():  # a motion that is only nearly the best is no answer
                    return self._refine(task, start, account, warm=warm, rough=0)
                if answer is None or not _can_be_mended(task, answer.trajectory):
                    return found
                return replace(answer, message=found.message, status=found.status if loose else answer.status)
            answer, loose = found, rough > 0
            layout = nlp.layout if isinstance(nlp, LiftedNlp) else None
            moving = np.arange(task.n) if layout is None else layout.moving
            broken = broken_points(task, answer.trajectory, moving, compiled=self.compiled)
            fresh = broken if layout is None else new_points(extra, broken)
            if fresh and samples <= MOST_SAMPLES:
                if layout is None:  # the condensed form takes no points, so take more samples everywhere
                    samples = 2 * max(samples, CONDENSED_SAMPLES)
                extra, rough = extra.joined(fresh), max(0, rough - 1)
                nlp = self._build(task, answer.trajectory, account, extra, layout, samples)
            elif rough:
                rough = 0
            else:
                return answer
        assert answer is not None
        return answer

    def _starts_roughly(self, task: TrajectoryTask) -> bool:
        """Return whether the first rounds of added points are solved to `LOOSE` only."""
        follows = plugin_named(self.plugin).takes_multipliers and task.family.has_lifted_form
        return follows and bool(instant_limits(task))

    def _solve_few_knots(
        self, task: TrajectoryTask, knots: int, guess: Trajectory | None, account: Account
    ) -> Trajectory | None:
        """Return a motion with fewer virtual knots, None where there is none."""
        try:
            stage = task.changed(virtual_knots=knots)
        except TaskError:  # too few knots for the boundary conditions
            return guess
        start = initial_guess(stage) if guess is None else fit_guess(stage, guess)
        nlp = self._build(stage, start, account)
        loose = replace(self, tolerance=max(LOOSE, self.tolerance), iterations=min(100, self.iterations))
        answer = loose._call(nlp, account, warm=guess is not None, before=None)
        return answer.trajectory if answer.solved else guess

    def _build(
        self,
        task: TrajectoryTask,
        guess: Trajectory,
        account: Account,
        extra: ExtraPoints = NO_POINTS,
        layout: Layout | None = None,
        samples: int = 0,
    ) -> Nlp:
        """Return the lifted form, or the condensed one of families that have no other."""
        clock = time.perf_counter()
        nlp: Nlp
        if task.family.has_lifted_form:
            compiled = self.compiled and plugin_named(self.plugin).own_derivatives
            nlp = LiftedNlp(task, guess, samples or self.samples, extra, layout=layout, compiled=compiled)
        else:
            nlp = _condensed(task, guess, samples or max(self.samples, CONDENSED_SAMPLES))
        account.build_time += time.perf_counter() - clock
        return nlp

    def _call(self, nlp: Nlp, account: Account, *, warm: bool, before: Answer | None) -> Answer:
        """Call the plug-in; `before` is the answer of the same task with fewer points.

        Second derivatives of exact extrema do not exist where two of them meet. A call that ends there is made
        again with an approximate Hessian; one that goes to and fro there, with samples instead of extrema.
        """
        answer = self._call_once(nlp, account, warm=warm, before=before, exact=True)
        if not isinstance(nlp, CondensedNlp) or account.exhausted():
            return answer
        if answer.status is Status.FAILED:
            return self._call_once(nlp, account, warm=warm, before=before, exact=False)
        if answer.status is Status.BUDGET_EXHAUSTED:
            sampled = _condensed(nlp.task, answer.trajectory, MOST_SAMPLES, extrema="sampled")
            return self._call_once(sampled, account, warm=warm, before=before, exact=True)
        return answer

    def _call_once(
        self, nlp: Nlp, account: Account, *, warm: bool, before: Answer | None, exact: bool
    ) -> Answer:
        clock = time.perf_counter()
        plugin = plugin_named(self.plugin)
        dual = before is not None and plugin.takes_multipliers and isinstance(nlp, LiftedNlp)
        stage = Stage(
            self.tolerance,
            account.evaluations_left(self.iterations),
            account.seconds_left(),
            warm or before is not None,
            dual,
            max(1.0, (nlp.task.gaps - GAPS_ALONE) / 2) / max(abs(_cost(nlp)), 1e-300),
            exact,
        )
        quiet = {"print_time": False, "error_on_fail": False, "show_eval_warnings": False}
        options = {**quiet, **plugin.options(stage)}
        if plugin.own_derivatives:  # and no gradient of the Lagrangian: nobody asks for it
            options.update({"no_nlp_grad": True, **nlp.derivatives})
        solver = ca.nlpsol("solver", self.plugin, {"x": nlp.x, "f": nlp.f, "g": nlp.g}, options)
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
            return _first_point(nlp, readable_reason(str(error)))
        stats = solver.stats()
        account.record(stats, time.perf_counter() - clock)
        status, message = read_status(plugin, stats)
        return _read_answer(nlp, answer, status, message)


def _condensed(task: TrajectoryTask, guess: Trajectory, samples: int, extrema: str = "auto") -> CondensedNlp:
    """Return the condensed form in logarithms of the durations, started from a guess."""
    durations = np.asarray(guess.segment_durations)
    bounds = float(durations.min()) / WIDE, float(durations.max()) * WIDE
    encoding = "log-durations"
    return CondensedNlp(task, encoding=encoding, samples=samples, extrema=extrema, bounds=bounds, guess=guess)


def _trajectory_of(solver: Gradient, task: TrajectoryTask, request: Request) -> Trajectory | None:
    """Run in another process: return the motion only."""
    outcome = solver.run(task, request)
    return outcome.trajectory if outcome.solution.status is Status.CONVERGED else None


def _read_answer(nlp: Nlp, answer: dict[str, Any], status: Status, message: str) -> Answer:
    x, g, on_rows, on_bounds = (np.array(answer[name]).ravel() for name in ("x", "g", "lam_g", "lam_x"))
    cost = float(answer["f"])
    if not np.isfinite(x).all():
        x, status = np.asarray(nlp.guess), Status.FAILED
    violation = nlp.violations(g)
    if message == ACCEPTABLE and violation.max(initial=0.0) > KEPT:
        status = Status.STALLED  # where segments vanish, a little in the rows is much in the motion
    return Answer(nlp, x, nlp.decode(x), status, message, cost, violation, on_rows, on_bounds)


def _can_be_mended(task: TrajectoryTask, trajectory: Trajectory) -> bool:
    """Return whether a motion keeps its limits but for what a little slowing or a tighter solve takes away."""
    verdict = audit(task, trajectory)
    scale, worst = verdict.smallest_feasible_scale, verdict.worst
    slowing = scale is not None and scale <= MENDABLE_SCALE
    return verdict.feasible or slowing or (worst is not None and worst.ratio <= MENDABLE_RATIO)


def _first_point(nlp: Nlp, message: str) -> Answer:
    """Return the first point as an answer that failed."""
    x = np.asarray(nlp.guess)
    found = nlp.evaluate(x[None, :])
    nothing = np.zeros(len(nlp.g_lower)), np.zeros(len(x))
    cost, violation = float(found.cost[0]), found.violation[0]
    return Answer(nlp, x, nlp.decode(x), Status.FAILED, message, cost, violation, *nothing)


def _cost(nlp: Nlp) -> float:
    """Return the cost at the guess."""
    ready = nlp.derivatives.get("grad_f")
    if ready is not None:
        return float(ready(nlp.guess, [])[0])
    return float(nlp.evaluate(np.asarray(nlp.guess)[None, :]).cost[0])


def carry_multipliers(old: list[RowBlock], new: list[RowBlock], multipliers: Array) -> Array:
    """Return multipliers for a problem with more rows: blocks of one limit match in order, new rows get zero."""
    kept: dict[tuple[str, int], Array] = {}
    for key, rows in _blocks(old):
        kept[key] = multipliers[rows]
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


def continuation(family: Family, virtual_knots: int) -> list[int]:
    """Return the numbers of virtual knots to solve one after the other, the last one the number wanted.

    One knot leads a cubic to good optima; higher degrees with knots are solved from the motion without any.
    """
    first = family.first_virtual_knots
    stages = [virtual_knots]
    while stages[0] > 7:
        stages.insert(0, (stages[0] - 1) // 2)
    return [first, *stages] if stages[0] > first else stages


def fit_guess(task: TrajectoryTask, trajectory: Trajectory) -> Trajectory:
    """Return a motion of the task's family and knots that starts near a given one."""
    same = trajectory.family == task.family
    wanted = task.gaps * (task.virtual_knots + 1)
    if len(trajectory.waypoint_times) != task.gaps + 1:
        raise InputError(
            f"the motion to start from passes {len(trajectory.waypoint_times)} waypoints, expected {task.gaps + 1}"
        )
    if same and len(trajectory.breakpoints) - 1 == wanted:
        return trajectory
    if same and task.virtual_knots and len(trajectory.breakpoints) - 1 < wanted:
        return insert_knots(trajectory, task.virtual_knots)
    return initial_guess(task, trajectory.segment_durations)
