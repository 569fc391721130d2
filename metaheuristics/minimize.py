"""The one loop: ask, evaluate, tell, record, stop."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from metaheuristics.arrays import FloatArray, read_only
from metaheuristics.checkpoint import Checkpoint, Snapshot, load, make_digest, save
from metaheuristics.evaluation import Evaluation
from metaheuristics.optimizer import Optimizer
from metaheuristics.ordering import Ordering, find_ordering
from metaheuristics.problem import Problem
from metaheuristics.recorder import Recorder, measure_spread
from metaheuristics.solution import Solution, Status
from metaheuristics.stopping import Limits, Progress, Verdict

Callback = Callable[[Progress], object]
Evaluate = Callable[[FloatArray], Evaluation]
MapFunction = Callable[[Evaluate, Iterable[FloatArray]], Iterable[Evaluation]]


def minimize(
    problem: Problem,
    optimizer: Optimizer[Any],
    *,
    rng: np.random.Generator,
    budget: int | None = None,
    generations: int | None = None,
    seconds: float | None = None,
    target: float | None = None,
    stall: int | None = None,
    x0: npt.ArrayLike | None = None,
    constraint_handling: Ordering | str | None = None,
    callback: Callback | None = None,
    checkpoint: Checkpoint | str | Path | None = None,
    batch_size: int | None = None,
    map_batches: MapFunction = map,
) -> Solution:
    """Search the box of a problem for its least cost with a population method.

    Parameters
    ----------
    problem
        What to minimise; its box must be finite.
    optimizer
        The method with its settings.
    rng
        Source of all randomness: the same state gives the same run, bit by bit.
    budget, generations, seconds, target, stall
        The limits; see `Limits`. At least one of budget, generations, seconds and stall is needed.
    x0
        (d,) or (k, d) known candidates for the initial population.
    constraint_handling
        An `Ordering` or its name (``"feasible-first"``, ``"epsilon"``, ``"static-penalty"``,
        ``"adaptive-penalty"``, ``"nondominated"``); the method's own by default.
    callback
        Called with a `Progress` after every generation; a true answer stops the run.
    checkpoint
        File to write the run to now and then, and to go on from if it exists.
    batch_size
        Largest number of candidates evaluated in one call; whole batches by default.
    map_batches
        Maps the evaluation over the batches, for instance the ``map`` of a pool of workers.

    Returns
    -------
    Solution
        The best candidate evaluated, judged feasible-first under any constraint handling.

    Raises
    ------
    ValueError
        If a limit, x0, the box or the checkpoint does not fit.

    Examples
    --------
    >>> import numpy as np
    >>> from metaheuristics import ParticleSwarm, Problem, minimize
    >>> problem = Problem.from_function(lambda X: ((X - 1.0) ** 2).sum(axis=1), [-5.0] * 3, [5.0] * 3)
    >>> best = minimize(problem, ParticleSwarm(population=30), budget=6000, rng=np.random.default_rng(0))
    >>> best.x.round(3).tolist(), best.evaluations
    ([1.0, 1.0, 1.0], 6000)
    """
    limits = Limits(budget, generations, seconds, target, stall)
    rule = optimizer.default_ordering if constraint_handling is None else constraint_handling
    evaluate = make_evaluator(problem, batch_size, map_batches)
    if checkpoint is not None and not isinstance(checkpoint, Checkpoint):
        checkpoint = Checkpoint(checkpoint)
    run = Run(problem, optimizer, evaluate, rng, limits, find_ordering(rule), x0, checkpoint)
    return run.make_solution(run.search(callback))


def make_evaluator(problem: Problem, batch_size: int | None, map_batches: MapFunction) -> Evaluate:
    """Return the evaluation of a batch, cut into parts of at most `batch_size` candidates.

    Raises
    ------
    ValueError
        If the batch size is below 1.
    """
    if batch_size is None:
        return problem.evaluate
    if batch_size < 1:
        raise ValueError(f"The batch size is {batch_size}, expected at least 1.")
    size = batch_size

    def evaluate(X: FloatArray) -> Evaluation:
        parts = list(map_batches(problem.evaluate, [X[i : i + size] for i in range(0, X.shape[0], size)]))
        return Evaluation(
            np.concatenate([part.cost for part in parts]), np.concatenate([part.violation for part in parts])
        )

    return evaluate


class Run:
    """One run of the loop, with everything that changes while it goes on."""

    def __init__(
        self,
        problem: Problem,
        optimizer: Optimizer[Any],
        evaluate: Evaluate,
        rng: np.random.Generator,
        limits: Limits,
        ordering: Ordering,
        x0: npt.ArrayLike | None,
        checkpoint: Checkpoint | None,
    ) -> None:
        begin = time.perf_counter()
        total = limits.total_generations(optimizer.initial_evaluations, optimizer.evaluations_per_generation)
        self.problem, self.optimizer, self.evaluate = problem, optimizer, evaluate
        self.rng, self.limits, self.checkpoint = rng, limits, checkpoint
        self.state = optimizer.start(
            problem.lower, problem.upper, rng, total_generations=total, ordering=ordering, x0=x0
        )
        self.recorder = Recorder(read_only(self.state.positions[0]))
        width = self.state.frame.width
        self.inverse_width = np.divide(1.0, width, out=np.zeros_like(width), where=width > 0.0)
        self.digest = make_digest(problem, optimizer, ordering)
        self.start_time = time.perf_counter()
        self.build_time = self.start_time - begin
        if checkpoint is not None and checkpoint.path.exists():
            snapshot = load(checkpoint.path, self.state, rng, self.digest)
            self.state, self.recorder = snapshot.state, snapshot.recorder
            self.start_time -= snapshot.seconds

    def search(self, callback: Callback | None) -> Verdict:
        """Run until a limit strikes or the callback says so, and return why the run ended."""
        complete = bool(self.recorder.entries) and self.state.phase == 0
        verdict = self._judge(complete)
        while verdict is None:
            X, asked = self.optimizer.ask(self.state, self.rng)
            budget = self.limits.budget
            left = X.shape[0] if budget is None else budget - self.recorder.evaluations
            if left < X.shape[0]:
                # The budget covers only the first rows; the run ends with them, so nobody needs to be told.
                self.recorder.update(X[:left], self.evaluate(X[:left]))
                self._record()
                return Status.BUDGET_EXHAUSTED, f"Used the {budget} evaluations allowed."
            evaluation = self.evaluate(X)
            self.recorder.update(X, evaluation)
            self.state = self.optimizer.tell(asked, X, evaluation)
            complete = self.state.phase == 0
            if complete:
                self._close_generation()
            verdict = self._judge(complete)
            if complete and callback is not None and callback(self._make_progress()) and verdict is None:
                verdict = (
                    Status.BUDGET_EXHAUSTED,
                    f"Stopped by the callback in generation {self.state.generation}.",
                )
        self._save()
        if not complete:
            self._record()
        return verdict

    def _judge(self, at_generation_end: bool) -> Verdict | None:
        recorder = self.recorder
        verdict = self.limits.judge(
            recorder.evaluations, time.perf_counter() - self.start_time, recorder.cost, recorder.violation
        )
        if verdict is None and at_generation_end:
            return self.limits.judge_generation(self.state.generation, recorder.stalled)
        return verdict

    def _record(self) -> None:
        spread = measure_spread(self.state.positions, self.inverse_width)
        self.recorder.close_generation(time.perf_counter() - self.start_time, spread)

    def _close_generation(self) -> None:
        self._record()
        if self.checkpoint is not None and self.state.generation % self.checkpoint.every == 0:
            self._save()

    def _save(self) -> None:
        if self.checkpoint is not None:
            snapshot = Snapshot(self.state, self.recorder, time.perf_counter() - self.start_time)
            save(self.checkpoint.path, snapshot, self.rng, self.digest)

    def _make_progress(self) -> Progress:
        recorder = self.recorder
        return Progress(
            self.state.generation,
            recorder.evaluations,
            recorder.entries[-1][3],
            recorder.x,
            recorder.cost,
            recorder.violation,
            recorder.entries[-1][4],
            read_only(self.state.positions),
        )

    def make_solution(self, verdict: Verdict) -> Solution:
        """Return the best candidate with the reason of the end."""
        seconds = time.perf_counter() - self.start_time
        return self.recorder.make_solution(
            self.problem, *verdict, build_time=self.build_time, solve_time=seconds
        )
