"""Every solver works on the task made ready; its outcome is brought back to the task that was asked for."""

from __future__ import annotations

from dataclasses import replace

from ocp_traj.solvers.solver import Outcome, Request, Solver
from ocp_traj.task import TrajectoryTask
from ocp_traj.task.preparing import PreparedTask, prepare
from ocp_traj.transcription.nlp import Nlp


def run_prepared(solver: Solver, task: TrajectoryTask, request: Request) -> Outcome:
    """Run a solver on the task made ready and return its outcome as one of the task itself.

    Parameters
    ----------
    solver : Solver
    task : TrajectoryTask
    request : Request
        Its warm start is a motion of the task itself.

    Raises
    ------
    InputError
        The task is nothing the solver can work on.
    """
    ready = prepare(task)
    start = None if request.warm_start is None else ready.prepared(request.warm_start)
    outcome = solver.run(ready.task, replace(request, warm_start=start))
    return outcome if ready.changes_nothing else _restored(ready, outcome)


def _restored(ready: PreparedTask, outcome: Outcome) -> Outcome:
    solution = outcome.solution
    problem = solution.problem
    return replace(
        outcome,
        trajectory=None if outcome.trajectory is None else ready.restored(outcome.trajectory),
        solution=replace(
            solution,
            problem=problem.restoring(ready) if isinstance(problem, Nlp) else problem,
            message=ready.in_original_numbers(solution.message),
        ),
        diagnosis=ready.in_original_numbers(outcome.diagnosis),
    )
