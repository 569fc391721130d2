"""The protocol of papers B and D: every joint alone, then the largest duration per segment.

The synchronised motion is in general not feasible, since a polynomial stretched in one segment overshoots in
another: the audit says so.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from metaheuristics import History, Solution, Status
from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError
from ocp_traj.quantities import DERIVATIVES, RATES
from ocp_traj.references.bounds.certify import FAR_SECONDS
from ocp_traj.solvers.population.condensed import CondensedSolver
from ocp_traj.solvers.solver import DEFAULT_BUDGET, Outcome, Request, Solver
from ocp_traj.task import Boundary, Limits, Objective, TrajectoryTask
from ocp_traj.transcription.condensed.condensed import CondensedNlp
from ocp_traj.transcription.curve import trajectory_from_durations


@dataclass(frozen=True)
class PerJoint(Solver):
    """A solver of the condensed form, run on every moving joint alone; the motions are synchronised.

    Parameters
    ----------
    solver : CondensedSolver
        Gets an equal share of budget and time per moving joint.
    """

    kind: ClassVar[str] = "population"

    solver: CondensedSolver

    def check_available(self) -> None:
        """Raise `UnavailableError` when the solver within is not there."""
        self.solver.check_available()

    def run(self, task: TrajectoryTask, request: Request) -> Outcome:
        """Search joint by joint and synchronise; see `Solver.run`."""
        return join_joints(task, search_joints(task, request, self.solver), self.solver)


def joint_task(task: TrajectoryTask, joint: int) -> TrajectoryTask:
    """Return the kinematic task of one joint alone.

    Where the joint has equal waypoints and others move, they stay two instants: the gap's duration gets a bound.
    """
    rests = (np.diff(task.waypoints[:, joint]) == 0) & (np.diff(task.waypoints, axis=0) != 0).any(axis=1)
    gap_durations = np.array(task.objective.gap_durations)
    gap_durations[rests, 1] = np.minimum(gap_durations[rests, 1], FAR_SECONDS)
    limits: dict[str, Any] = {name: task.limits.get(name)[:, :, [joint]] for name in DERIVATIVES}
    boundary: dict[str, Any] = {}
    for name in RATES:
        given = getattr(task.boundary, name)
        boundary[name] = None if given is None else given[:, [joint]]
    return TrajectoryTask(
        waypoints=task.waypoints[:, [joint]],
        limits=Limits(**limits),
        family=task.family,
        boundary=Boundary(**boundary),
        objective=Objective(time=1.0, duration=task.objective.duration, gap_durations=gap_durations),
        search=replace(task.search, protocol="shared"),
        name=f"{task.name}, joint {joint + 1}",
    )


def moving_gaps(task: TrajectoryTask, durations: Array) -> Any:
    """Return in which gaps each joint's own curve moves, (n, K - 1) of bool, from its durations (n, K - 1), s.

    A joint may move between equal waypoints: it passes one of them with a velocity.
    """
    moves = np.zeros(durations.shape, dtype=bool)
    for joint in np.flatnonzero(np.ptp(task.waypoints, axis=0) > 0).tolist():
        curve = trajectory_from_durations(joint_task(task, joint), durations[joint])
        steps = durations[joint][:, None] ** np.arange(curve.degree + 1)
        travel = np.abs(np.asarray(curve.coefficients)[:, 0] * steps)[:, 1:].max(axis=1)
        moves[joint] = travel > 1e-9 * travel.max()
    return moves


def synchronise(task: TrajectoryTask, durations: Array) -> Array:
    """Return the largest duration per gap over the joints that move in it, (K - 1,), from (n, K - 1).

    A joint that rests in a gap says nothing about its duration; a gap in which no joint moves takes the smallest.
    """
    largest = np.where(moving_gaps(task, durations), durations, -np.inf).max(axis=0)
    return np.where(np.isfinite(largest), largest, durations.min(axis=0))


def search_joints(task: TrajectoryTask, request: Request, solver: CondensedSolver) -> dict[int, Solution]:
    """Run a population method on every moving joint alone, each with an equal share of the budget.

    Returns
    -------
    dict
        Solution by joint, from 0; the problem of each is a `CondensedNlp`.
    """
    if task.virtual_knots or set(task.objective.weights) != {"time"} or task.objective.custom:
        raise InputError(
            "the per-joint protocol minimises the time of motions without virtual knots, expected search.protocol "
            "'shared' for anything else"
        )
    moving = np.flatnonzero(np.ptp(task.waypoints, axis=0) > 0)
    budget = DEFAULT_BUDGET if request.budget is None else request.budget
    if budget < len(moving):
        raise InputError(
            f"a budget of {budget} cannot be shared, expected at least 1 a moving joint ({len(moving)})"
        )
    share = budget // max(1, len(moving))
    seconds = None if request.time_limit is None else request.time_limit / max(1, len(moving))
    solutions = {}
    for joint in moving.tolist():
        alone = solver.problem(joint_task(task, joint))
        seed = int(np.random.SeedSequence([request.seed, joint]).generate_state(1)[0])
        part = replace(request, seed=seed, budget=share, time_limit=seconds)
        solutions[joint] = solver.search(alone, part)
    return solutions


def join_joints(task: TrajectoryTask, parts: dict[int, Solution], solver: CondensedSolver) -> Outcome:
    """Return the synchronised motion of joints optimised alone."""
    durations = np.full((task.n, task.gaps), float(np.asarray(task.search.duration)[0]))
    for joint, part in parts.items():
        assert isinstance(part.problem, CondensedNlp)
        durations[joint] = np.diff(part.problem.decode(part.x).breakpoints)
    shared = synchronise(task, durations)
    nlp = CondensedNlp(task, samples=solver.samples, extrema=solver.extrema)
    solution = _joined(nlp, shared, list(parts.values()))
    return Outcome(trajectory_from_durations(task, shared), solution, {"evaluate": solution.evaluations})


def _joined(nlp: CondensedNlp, durations: Array, parts: list[Solution]) -> Solution:
    """Return one solution for all joints; its history has one entry, the synchronised motion."""
    evaluation = nlp.evaluate(durations[None, :])
    evaluations = sum(part.evaluations for part in parts)
    seconds = sum(part.solve_time for part in parts)
    history = History.of(
        evaluation.cost,
        evaluations=[evaluations],
        dimension=nlp.dimension,
        violation=evaluation.total_violation,
        seconds=[seconds],
        x=durations[None, :],
    )
    ended = parts[0].status if parts else Status.FAILED
    if ended is Status.INFEASIBLE:  # nothing found proves nothing
        ended = Status.STALLED
    joints = ", ".join(f"{part.problem.name.rsplit(' ', 1)[1]}: {part.cost:.5g} s" for part in parts)
    return Solution(
        problem=nlp,
        x=durations,
        cost=float(evaluation.cost[0]),
        violation=evaluation.violation[0],
        status=ended,
        message=f"Joints apart, synchronised by the largest duration per segment (each joint alone: {joints}).",
        history=history,
    ).paying_for(parts)
