"""pymoo's optimisers; they take the constraint rows as they are, and NSGA-II gives the front of time and energy."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.soo.nonconvex.de import DE
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.algorithms.soo.nonconvex.pso import PSO
from pymoo.core.evaluator import Evaluator
from pymoo.core.problem import Problem as PymooProblem
from pymoo.core.termination import NoTermination
from pymoo.problems.static import StaticProblem

from metaheuristics import Solution, Status
from metaheuristics.nondominated import find_front
from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError
from ocp_traj.solvers.population.counting import BudgetSpent, Counted
from ocp_traj.solvers.population.explaining import explained
from ocp_traj.solvers.solver import DEFAULT_BUDGET, Outcome, Request
from ocp_traj.solvers.third_party.third_party import ThirdParty
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.condensed.condensed import CondensedNlp
from ocp_traj.transcription.condensed.encodings import find_encoding


@dataclass(frozen=True)
class Pymoo(ThirdParty):
    """A single-objective optimiser of pymoo with its own handling of constraints."""

    algorithm: ClassVar[Any]

    population: int = 50

    def optimise(self, problem: Counted, rng: np.random.Generator, start: Any) -> str:
        """Ask and tell until the problem ends it; see `ThirdParty.optimise`."""

        def judge(X: Array) -> tuple[Array, Array]:
            cost, violation = problem.evaluate(X).scores
            return np.minimum(cost, 1e300)[:, None], np.minimum(violation, 1e300)[:, None]

        algorithm = type(self).algorithm(pop_size=self.population)
        run(algorithm, problem, judge, 1, int(rng.integers(2**31)), start)
        return "no more candidates"


@dataclass(frozen=True)
class ParticleSwarmOfPymoo(Pymoo):
    """pymoo's particle swarm."""

    algorithm: ClassVar[Any] = PSO


@dataclass(frozen=True)
class GeneticAlgorithmOfPymoo(Pymoo):
    """pymoo's genetic algorithm."""

    algorithm: ClassVar[Any] = GA


@dataclass(frozen=True)
class DifferentialEvolutionOfPymoo(Pymoo):
    """pymoo's differential evolution."""

    algorithm: ClassVar[Any] = DE


def run(algorithm: Any, problem: Counted, judge: Any, objectives: int, seed: int, start: Any) -> Any:
    """Drive a pymoo algorithm by ask and tell; `judge` gives costs (p, objectives) and violations (p, 1)."""
    shape = PymooProblem(
        n_var=problem.dimension, n_obj=objectives, n_ieq_constr=1, xl=problem.lower, xu=problem.upper
    )
    if start is not None:
        algorithm.initialization.sampling = np.vstack([start, _fill(problem, algorithm.pop_size, seed)])[
            : algorithm.pop_size
        ]
    algorithm.setup(shape, termination=NoTermination(), seed=seed, verbose=False)
    while algorithm.has_next():
        asked = algorithm.ask()
        costs, violations = judge(asked.get("X"))
        Evaluator().eval(StaticProblem(shape, F=costs, G=violations), asked)
        algorithm.tell(infills=asked)
    return algorithm


def _fill(problem: Counted, count: int, seed: int) -> Array:
    return np.random.default_rng(seed).uniform(problem.lower, problem.upper, (count, problem.dimension))


@dataclass(frozen=True)
class TimeEnergyFront:
    """Motions of which none is both faster and more frugal than another, fastest first.

    Attributes
    ----------
    nlp : CondensedNlp
    durations : (N,) s
    energies : (N,) J, by the problem's quadrature
    x : (N, d)
    evaluations : int
    """

    nlp: CondensedNlp = field(repr=False)
    durations: Array
    energies: Array
    x: Array
    evaluations: int

    def trajectory(self, index: int) -> Trajectory:
        """Return one motion of the front."""
        return self.nlp.decode(self.x[index])


@dataclass(frozen=True)
class Nsga2OfPymoo(ThirdParty):
    """pymoo's NSGA-II on time against energy; `run` answers with the best of the front by the task's weights."""

    population: int = 100

    def front(self, task: TrajectoryTask, request: Request) -> TimeEnergyFront:
        """Return the front of duration and energy: of all feasible motions seen, those no other beats in both.

        Raises
        ------
        InputError
            The task has no robot with inertia, weighs anything but time and energy, or the encoding
            decides the speed itself, as ``"scaled"`` does.
        """
        return self._search_front(task, request)[0]

    def run(self, task: TrajectoryTask, request: Request) -> Outcome:
        """Search the front and return the motion the task's weights of time and energy prefer."""
        front, solution = self._search_front(task, request)
        counts = {"evaluate": front.evaluations, "front": len(front.durations)}
        if not len(front.durations):
            assert isinstance(solution.problem, CondensedNlp)
            solution, diagnosis = explained(solution.problem, solution)
            return Outcome(None, solution, counts, diagnosis or "NSGA-II has seen no motion that keeps every limit.")
        weights = task.objective.weights
        values = weights.get("time", 0.0) * front.durations + weights.get("energy", 0.0) * front.energies
        best = int(values.argmin())
        rows = solution.problem.evaluate(front.x[best][None]).violation[0]
        solution = replace(solution, x=front.x[best], cost=float(values[best]), violation=rows)
        return Outcome(front.trajectory(best), solution, counts)

    def optimise(self, problem: Counted, rng: np.random.Generator, start: Any) -> str:
        """Refuse: a joint alone has no energy."""
        raise InputError("NSGA-II trades time against energy, expected search.protocol 'shared'")

    def _search_front(self, task: TrajectoryTask, request: Request) -> tuple[TimeEnergyFront, Solution]:
        self._check(task)
        weighted = task
        if not task.objective.energy:
            weighted = replace(task, objective=replace(task.objective, energy=1.0))
        time_weight, energy_weight = weighted.objective.time, weighted.objective.energy
        nlp = self.problem(weighted)
        problem = Counted(nlp, request.budget or DEFAULT_BUDGET, request.time_limit, request.progress)
        seen: list[Array] = []

        def judge(X: Array) -> tuple[Array, Array]:
            cost, violation = problem.evaluate(X).scores
            duration = nlp.durations(X).sum(axis=1)
            energy = (cost - time_weight * duration) / energy_weight
            kept = (violation == 0) & np.isfinite(energy)
            seen.append(np.column_stack([duration, energy, X])[kept])
            costs = np.column_stack([duration, np.minimum(energy, 1e300)])
            return costs, np.minimum(violation, 1e300)[:, None]

        start, _, _ = self.start_candidates(nlp, request)
        seed = int(np.random.default_rng(request.seed).integers(2**31))
        try:
            run(NSGA2(pop_size=self.population), problem, judge, 2, seed, start)
            status, message = Status.STALLED, "Ended by itself."
        except BudgetSpent as end:
            status, message = end.status, str(end)
        rows = np.concatenate(seen) if seen else np.empty((0, 2 + nlp.dimension))
        front = rows[find_front(rows[:, 0], rows[:, 1])]
        made = TimeEnergyFront(nlp, front[:, 0], front[:, 1], front[:, 2:], problem.evaluations)
        return made, problem.make_solution(status, message)

    def _check(self, task: TrajectoryTask) -> None:
        if set(task.objective.weights) - {"time", "energy"} or task.objective.custom:
            raise InputError("NSGA-II trades time against energy, expected no other weights in objective")
        if not task.has_inertia:
            raise InputError("NSGA-II trades time against energy, expected a robot with inertia")
        if find_encoding(self.encoding).decides_speed:
            raise InputError(
                "NSGA-II decides the speed itself, expected encoding 'durations' or 'log-durations'"
            )
        if task.search.protocol == "per-joint":
            raise InputError("NSGA-II trades time against energy, expected search.protocol 'shared'")
