"""Gradient solvers: CasADi's nlpsol plug-ins on the lifted form, continued, refined and made exact."""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass, field
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from metaheuristics import History, Solution, Status
from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError, UnavailableError
from ocp_traj.nlp import Nlp
from ocp_traj.solvers.refinement import broken_points
from ocp_traj.solvers.solver import Outcome, Request, Solver
from ocp_traj.spline import get_family
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription import CondensedNlp, ExtraPoints, LiftedNlp, initial_guess, insert_knots

logger = logging.getLogger(__name__)

STATUSES = {
    "Solve_Succeeded": Status.CONVERGED,
    "Solved_To_Acceptable_Level": Status.CONVERGED,
    "Feasible_Point_Found": Status.CONVERGED,
    "Infeasible_Problem_Detected": Status.INFEASIBLE,
    "Search_Direction_Becomes_Too_Small": Status.STALLED,
    "Maximum_Iterations_Exceeded": Status.BUDGET_EXHAUSTED,
    "Maximum_CpuTime_Exceeded": Status.TIME_EXHAUSTED,
    "Maximum_WallTime_Exceeded": Status.TIME_EXHAUSTED,
}
"""IPOPT's return status in the words of the shared interface; anything else is a failure."""


WIDEST_LOGARITHM = 10.0
"""A duration of the condensed form may differ from the guess by this factor's exponential at most."""


@dataclass
class _Account:
    """Calls, seconds and iterations of all stages of one run."""

    counts: dict[str, int] = field(default_factory=dict)
    evaluations: int = 0
    build_time: float = 0.0
    solve_time: float = 0.0
    cost: list[float] = field(default_factory=list)
    violation: list[float] = field(default_factory=list)
    at: list[int] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)


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
        Iterations at most, a stage.
    rounds : int
        How often points with broken limits are added and the problem is solved again, warm.
    samples : int
        Samples a gap of torques and other functions of an instant at first; 0 chooses 4 for limits and 16 where
        a cost is integrated over them.
    """

    kind: ClassVar[str] = "gradient"

    plugin: str = "ipopt"
    tolerance: float = 1e-8
    iterations: int = 1000
    rounds: int = 5
    samples: int = 0

    def run(self, task: TrajectoryTask, request: Request) -> Outcome:
        """Solve a task: few knots first, then all, then the points between samples."""
        self.check_available()
        account = _Account()
        clock = time.perf_counter()
        if not get_family(task.family).takes_virtual_knots:
            return self._run_condensed(task, request, account, clock)
        trajectory, status, message, nlp, x = self._solve_stages(task, request, account, clock)
        solution = _make_solution(nlp, x, status, message, account)
        return Outcome(trajectory, solution, account.counts)

    def _run_condensed(
        self, task: TrajectoryTask, request: Request, account: _Account, clock: float
    ) -> Outcome:
        """Solve in logarithms of durations with closed-form extrema; the search box binds population methods only."""
        nlp = CondensedNlp(task, encoding="log-durations", samples=self.samples or 16)
        guess = initial_guess(task) if request.warm_start is None else fit_guess(task, request.warm_start)
        start = nlp.encode(guess)
        account.build_time += time.perf_counter() - clock
        box = (start, start - WIDEST_LOGARITHM, start + WIDEST_LOGARITHM)
        x, status, message = self._solve(nlp, request, account, clock, request.warm_start is not None, box)
        return Outcome(nlp.decode(x), _make_solution(nlp, x, status, message, account), account.counts)

    def check_available(self) -> None:
        """Raise `UnavailableError` when the plug-in does not load."""
        if not ca.has_nlpsol(self.plugin):
            raise UnavailableError(f"solver {self.plugin!r} cannot be loaded: CasADi has no such plug-in here")

    def _solve_stages(
        self, task: TrajectoryTask, request: Request, account: _Account, clock: float
    ) -> tuple[Trajectory, Status, str, Nlp, Array]:
        guess: Trajectory | None = request.warm_start
        for knots in continuation(task.virtual_knots):
            stage = task if knots == task.virtual_knots else task.changed(virtual_knots=knots)
            start = initial_guess(stage) if guess is None else fit_guess(stage, guess)
            extra = ExtraPoints()
            warm = guess is not None
            for _ in range(self.rounds + 1):
                nlp = self._build(stage, start, extra, account)
                x, status, message = self._solve(nlp, request, account, clock, warm)
                trajectory = nlp.decode(x)
                broken = broken_points(stage, trajectory, nlp.layout.moving)
                if status is not Status.CONVERGED or not broken or stage is not task:
                    break
                extra, start, warm = extra.joined(broken), trajectory, True
            guess = trajectory
            if status is not Status.CONVERGED and stage is not task:
                guess = None
        return trajectory, status, message, nlp, x

    def _build(self, task: TrajectoryTask, guess: Trajectory, extra: ExtraPoints, account: _Account) -> LiftedNlp:
        clock = time.perf_counter()
        samples = self.samples or (16 if set(task.objective.weights) - {"time"} else 4)
        nlp = LiftedNlp(task, guess, samples, extra)
        account.build_time += time.perf_counter() - clock
        return nlp

    def _solve(
        self,
        nlp: Nlp,
        request: Request,
        account: _Account,
        clock: float,
        warm: bool,
        box: tuple[Array, Array, Array] | None = None,
    ) -> tuple[Array, Status, str]:
        """Solve from the problem's own guess and bounds, or from `box`: start, lower, upper."""
        begin = time.perf_counter()
        guess, lower, upper = (nlp.guess, nlp.lower, nlp.upper) if box is None else box
        options = self._options(nlp, request, account, clock, warm)
        scale = 1.0 / max(abs(_cost_at(nlp, guess)), 1e-300)
        options["ipopt.obj_scaling_factor"] = scale
        solver = ca.nlpsol("solver", self.plugin, {"x": nlp.x, "f": nlp.f, "g": nlp.g}, options)
        account.build_time += time.perf_counter() - begin
        begin = time.perf_counter()
        answer = solver(x0=guess, lbx=lower, ubx=upper, lbg=nlp.g_lower, ubg=nlp.g_upper)
        elapsed = time.perf_counter() - begin
        _record(account, solver.stats(), begin - clock, elapsed)
        message = str(solver.stats()["return_status"])
        return np.array(answer["x"]).ravel(), STATUSES.get(message, Status.FAILED), message

    def _options(
        self, nlp: Nlp, request: Request, account: _Account, clock: float, warm: bool
    ) -> dict[str, Any]:
        iterations = self.iterations
        if request.budget is not None:
            iterations = max(0, min(iterations, request.budget - account.evaluations - 1))
        options: dict[str, Any] = {
            "print_time": False,
            "error_on_fail": False,
            "ipopt.print_level": 0,
            "ipopt.sb": "yes",
            "ipopt.honor_original_bounds": "yes",  # a waypoint's box is kept to 1e-8, IPOPT relaxes bounds by as much
            "ipopt.mu_strategy": "monotone",
            "ipopt.tol": self.tolerance,
            "ipopt.max_iter": iterations,
            **nlp.derivatives,
        }
        if request.time_limit is not None:
            left = request.time_limit - (time.perf_counter() - clock)
            options["ipopt.max_wall_time"] = max(left, 1e-3)
        if warm:
            options["ipopt.mu_init"] = 1e-4
        return options


def continuation(virtual_knots: int) -> list[int]:
    """Return the numbers of virtual knots to solve one after the other: few first, exact halving after that."""
    stages = [virtual_knots]
    while stages[0] > 3:
        stages.insert(0, (stages[0] - 1) // 2)
    return stages


def fit_guess(task: TrajectoryTask, trajectory: Trajectory) -> Trajectory:
    """Return a motion of the task's family and knots that starts near a given one."""
    same = trajectory.family == task.family
    wanted = task.gaps * (task.virtual_knots + 1)
    if same and len(trajectory.breakpoints) - 1 == wanted:
        return trajectory
    if same and task.virtual_knots and len(trajectory.breakpoints) - 1 < wanted:
        return insert_knots(trajectory, task.virtual_knots)
    if len(trajectory.waypoint_times) != task.gaps + 1:
        raise InputError(
            f"the motion to start from passes {len(trajectory.waypoint_times)} waypoints, expected {task.gaps + 1}"
        )
    return initial_guess(task, trajectory.segment_durations)


def _cost_at(nlp: Nlp, x: Array) -> float:
    return float(ca.Function("cost", [nlp.x], [nlp.f])(x))


def _record(account: _Account, stats: dict[str, Any], begin: float, elapsed: float) -> None:
    """Add one nlpsol call's counts and history."""
    counts = {name.removeprefix("n_call_"): int(value) for name, value in stats.items() if name.startswith("n_call_")}
    for name, value in counts.items():
        if name.startswith("nlp_"):
            account.counts[name] = account.counts.get(name, 0) + value
    spent = max(counts.get("nlp_f", 0), counts.get("nlp_g", 0), 1)
    iterations = stats.get("iterations", {})
    cost = list(iterations.get("obj", ()))
    share = np.linspace(0, 1, len(cost)) if len(cost) > 1 else np.ones(len(cost))
    account.cost += cost
    account.violation += list(iterations.get("inf_pr", ()))
    account.at += [account.evaluations + round(fraction * spent) for fraction in share]
    account.seconds += [begin + fraction * elapsed for fraction in share]
    account.evaluations += spent
    account.solve_time += elapsed


def _make_solution(nlp: Nlp, x: Array, status: Status, message: str, account: _Account) -> Solution:
    evaluation = nlp.evaluate(x[None, :])
    count = len(account.cost)
    history = History(
        np.array(account.at, dtype=np.intp),
        np.array(account.cost),
        np.array(account.violation),
        np.array(account.seconds),
        np.full((count, len(x)), np.nan),
        np.full(count, np.nan),
    )
    return Solution(
        nlp,
        x,
        float(evaluation.cost[0]),
        evaluation.violation[0],
        status,
        message,
        account.evaluations,
        account.build_time,
        account.solve_time,
        history,
    )


