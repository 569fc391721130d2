"""Solve a task, audit the answer, and keep both: nothing is called feasible by its solver."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from metaheuristics import Status
from ocp_traj.audit import Verdict, audit
from ocp_traj.audit.costs import energy, objective_value
from ocp_traj.case import task_to_json
from ocp_traj.exceptions import InputError
from ocp_traj.files import finite
from ocp_traj.solvers import Outcome, Request, Solver, parse_solver
from ocp_traj.solvers.gradient.slow import slow_motion
from ocp_traj.solvers.mending import draw_in, is_oversight, slowed_into_limits, solve_tighter
from ocp_traj.solvers.outcomes import add_counts
from ocp_traj.solvers.prepared import run_prepared
from ocp_traj.solvers.registry import follow_protocol
from ocp_traj.solvers.solver import ProgressCallback
from ocp_traj.task.preparing import prepare
from ocp_traj.trajectory_files import to_json as trajectory_to_json
from ocp_traj.version import __version__

if TYPE_CHECKING:
    from metaheuristics import Solution
    from ocp_traj.arrays import Array
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

MENDING_ROUNDS = 4
"""Warm solves at most with limits drawn in, until the audit agrees."""


@dataclass(frozen=True, eq=False)
class SolveResult:
    """One solver's answer to one task, judged.

    Attributes
    ----------
    task : TrajectoryTask
    solver : str
        Name with parameters, as asked for.
    seed : int
    trajectory : Trajectory or None
        The motion, after the final uniform scaling; None when the solver has none.
    audit : Verdict or None
    solution : metaheuristics.Solution
        What the solver itself says.
    counts : dict
        Calls of the problem's functions.
    scaled_by : float
        The uniform slowing that made the motion keep its limits exactly, usually 1 + 1e-8; 1 when none was needed.
    diagnosis : str
        Why there is no feasible answer.
    """

    task: TrajectoryTask
    solver: str
    seed: int
    trajectory: Trajectory | None
    audit: Verdict | None
    solution: Solution
    counts: dict[str, int]
    scaled_by: float
    diagnosis: str = ""

    @property
    def feasible(self) -> bool:
        """The audit's verdict."""
        return self.audit is not None and self.audit.feasible

    @property
    def duration(self) -> float | None:
        """Duration of the motion, s."""
        return None if self.trajectory is None else self.trajectory.duration

    @cached_property
    def energy(self) -> float | None:
        """Integral of sum |tau qdot| dt, J; None without a robot that has inertia."""
        return None if self.trajectory is None else energy(self.task, self.trajectory)

    @cached_property
    def objective(self) -> float | None:
        """The task's weighted objective of the motion, by exact or adaptive integration."""
        return None if self.trajectory is None else objective_value(self.task, self.trajectory)

    @property
    def segment_durations(self) -> Array:
        """Duration of every gap between waypoints, (K - 1,), s."""
        return np.empty(0) if self.trajectory is None else self.trajectory.segment_durations

    @property
    def status(self) -> str:
        """The solver's own status, as in files."""
        return self.solution.status.key

    @property
    def message(self) -> str:
        """What the solver itself said, and why the answer is not feasible if it is not."""
        return f"{self.solution.message} {self.diagnosis}".strip()

    @property
    def encoding(self) -> str:
        """What the variables meant to the solver."""
        return str(getattr(self.solution.problem, "encoding", ""))

    @property
    def offsets(self) -> dict[str, Any] | None:
        """What offsets of virtual knots were measured ``from`` and the half-width of their ``box``; None without."""
        return getattr(getattr(self.solution.problem, "encoding", None), "measured_from", None)

    def to_json(self, references: dict[str, Any] | None = None) -> dict[str, Any]:
        """Return the result as `solve --json` writes it (docs/cli.md); every number finite or null."""
        verdict = self.audit.to_json() if self.audit is not None else None
        return {
            "schema": 1,
            "case": self.task.name,
            "solver": self.solver,
            "seed": self.seed,
            "status": self.status,
            "message": self.message,
            "feasible": self.feasible,
            "objective": finite(self.objective),
            "duration": finite(self.duration),
            "energy": finite(self.energy),
            "segment_durations": [float(h) for h in self.segment_durations],
            "worst": None if verdict is None else verdict["worst"],
            "collision": None if verdict is None else verdict["collision"],
            "evaluations": self.solution.evaluations,
            "counts": self.counts,
            "encoding": self.encoding,
            "offsets": self.offsets,
            "scaled_by": self.scaled_by,
            "build_time": self.solution.build_time,
            "solve_time": self.solution.solve_time,
            "references": references,
            "trajectory": None if self.trajectory is None else trajectory_to_json(self.trajectory),
            "task": task_to_json(self.task),
            "versions": versions(),
        }

    def prove(self) -> dict[str, Any]:
        """Return the proof that the motion keeps every limit at every instant; `proofs.write_proof` writes it.

        Raises
        ------
        NotProved
            There is no motion, or a limit that could not be proved; says which.
        """
        from ocp_traj.proofs import NotProved, prove

        if self.trajectory is None:
            raise NotProved("the solver has no motion")
        return prove(self.task, self.trajectory)

    def __str__(self) -> str:
        verdict = "feasible" if self.feasible else "NOT feasible"
        lines = [f"{self.task.name}, {self.solver} (seed {self.seed}): {self.status}, {verdict} by the audit"]
        if self.trajectory is not None:
            energy_text = "" if self.energy is None else f", energy {self.energy:.6g} J"
            lines.append(f"  duration {self.duration:.6g} s, objective {self.objective:.6g}{energy_text}")
        if self.audit is not None and self.audit.worst is not None:
            worst = self.audit.worst
            joint = f", joint {worst.joint + 1}" if worst.joint >= 0 else ""
            lines.append(
                f"  closest limit: {worst.limit}{joint} at {worst.time:.4g} s, ratio {worst.ratio:.9g}"
            )
        lines.append(
            f"  {self.solution.evaluations} evaluations, build {self.solution.build_time:.3g} s, "
            f"solve {self.solution.solve_time:.3g} s; {self.message}"
        )
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from html import escape

        return f"<pre>{escape(str(self))}</pre>"


def solve(
    task: TrajectoryTask,
    solver: str | Solver = "ipopt",
    *,
    seed: int = 0,
    budget: int | None = None,
    time_limit: float | None = None,
    progress: ProgressCallback | None = None,
    warm_start: Trajectory | None = None,
) -> SolveResult:
    """Solve a task with one solver and audit the answer.

    Parameters
    ----------
    task : TrajectoryTask
    solver : str or Solver
        A name from ``ocp-traj list solvers``, with parameters if wanted: ``"pso[population=50]"``.
    seed : int
        Source of all randomness.
    budget : int, optional
        Evaluations of x at most.
    time_limit : float, optional
        Seconds at most.
    progress : callable, optional
        Called now and then; a true answer stops the solver.
    warm_start : Trajectory, optional
        A motion to start from.

    Returns
    -------
    SolveResult

    Raises
    ------
    UnknownNameError, UnavailableError
        The solver does not exist or cannot be loaded.
    InputError
        The task is nothing the solver can work on.

    Examples
    --------
    >>> import ocp_traj as ot
    >>> result = ot.solve(ot.load_case("fang-2020-task-1"))
    >>> round(result.duration, 3), result.feasible, result.status
    (4.0, True, 'converged')
    """
    name = solver if isinstance(solver, str) else type(solver).__name__
    named: object = parse_solver(solver) if isinstance(solver, str) else solver
    if not isinstance(named, Solver):
        given = solver.__name__ if isinstance(solver, type) else name
        raise InputError(
            f"solver {given} given, expected a name of `ocp-traj list solvers` or an instance of a subclass of "
            "ocp_traj.solvers.Solver"
        )
    chosen = follow_protocol(named, task)
    request = Request(seed, budget, time_limit, progress, warm_start)
    result = judge(task, name, seed, run_prepared(chosen, task, request))
    if chosen.kind in ("gradient", "hybrid") and is_oversight(result.audit, result.solution.status):
        last = chosen if chosen.kind == "gradient" else parse_solver("ipopt")
        result = _mended(last, result, request)
    if chosen.kind in ("gradient", "hybrid") and not result.feasible:
        result = _slowed(result)
    return result if warm_start is None else _no_worse(result, warm_start)


def judge(task: TrajectoryTask, name: str, seed: int, outcome: Outcome) -> SolveResult:
    """Audit a solver's outcome; a motion over its limits by rounding or sampling is slowed into them first."""
    trajectory = outcome.trajectory
    if trajectory is None:
        return SolveResult(
            task, name, seed, None, None, outcome.solution, outcome.counts, 1.0, outcome.diagnosis
        )
    begin = time.perf_counter()
    trajectory, verdict, scaled_by = slowed_into_limits(task, trajectory)
    diagnosis = outcome.diagnosis
    if not verdict.feasible and not diagnosis and verdict.findings:
        diagnosis = verdict.findings[0]
    elapsed = time.perf_counter() - begin
    solution = replace(outcome.solution, solve_time=outcome.solution.solve_time + elapsed)
    return SolveResult(task, name, seed, trajectory, verdict, solution, outcome.counts, scaled_by, diagnosis)


def _mended(solver: Solver, result: SolveResult, request: Request) -> SolveResult:
    """Return a feasible answer of warm solves with broken limits drawn in, or the result where there is none.

    Each answer is judged against the task's own limits, and what it breaks is drawn in further.
    """
    task, last, runs = result.task, result, [result]
    fractions: dict[str, float] = {}
    for _ in range(MENDING_ROUNDS):
        rest = request.less(sum(run.solution.evaluations for run in runs), sum(run.solution.seconds for run in runs))
        if rest.exhausted() or not is_oversight(last.audit, last.solution.status):
            break
        assert last.audit is not None
        fractions = draw_in(last.audit, fractions)
        outcome = solve_tighter(solver, task, fractions, replace(rest, warm_start=last.trajectory))
        last = judge(task, result.solver, result.seed, outcome)
        runs.append(last)
        if last.feasible:
            solution = last.solution.paying_for([run.solution for run in runs])
            return replace(last, solution=solution, counts=add_counts(*(run.counts for run in runs)))
    return result


def _slowed(result: SolveResult) -> SolveResult:
    """Return the best feasible motion that can be made without solving: the answer's own slowed, or a closed form."""
    task, status = result.task, result.solution.status
    if status is Status.INFEASIBLE:
        return result
    scale = None if result.audit is None else result.audit.smallest_feasible_scale
    ready = prepare(task)
    slow = slow_motion(ready.task)
    motions = [None if slow is None else ready.restored(slow)]
    if result.trajectory is not None and scale is not None and 0.0 < scale < np.inf:
        motions.append(result.trajectory.scaled(scale))
    judged = [(motion, audit(task, motion)) for motion in motions if motion is not None]
    feasible = [(objective_value(task, motion), motion, verdict) for motion, verdict in judged if verdict.feasible]
    if not feasible:
        return result
    _, motion, verdict = min(feasible, key=lambda each: each[0])
    message = f"{result.solution.message} The motion is a slow one, made without solving; no better one was found."
    kept = Status.STALLED if status in (Status.CONVERGED, Status.FAILED) else status
    solution = replace(result.solution, message=message, status=kept)
    return replace(result, trajectory=motion, audit=verdict, solution=solution, scaled_by=1.0, diagnosis="")


def _no_worse(result: SolveResult, start: Trajectory) -> SolveResult:
    """Return the motion the solver was started from where it is feasible and the solver found nothing better."""
    task = result.task
    segments = prepare(task).task.gaps * (task.virtual_knots + 1)
    if start.family != task.family or len(start.breakpoints) != segments + 1:
        return result
    verdict = audit(task, start)
    value = objective_value(task, start)
    if not verdict.feasible or (
        result.feasible and result.objective is not None and result.objective <= value
    ):
        return result
    message = f"{result.solution.message} Nothing better than the motion started from was found; that one is returned."
    solution = replace(result.solution, message=message)
    return SolveResult(
        task, result.solver, result.seed, start, verdict, solution, result.counts, 1.0, result.diagnosis
    )


def versions() -> dict[str, str]:
    """Return the versions of this package and of those its numbers depend on."""
    from importlib.metadata import PackageNotFoundError, version

    found = {"ocp_traj": __version__}
    for package in ("casadi", "pin", "numpy", "scipy", "toppra", "cvxpy", "clarabel"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found
