"""Population methods on the condensed form: one adapter for every optimiser of `metaheuristics`."""

from __future__ import annotations

import time
from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np

from metaheuristics import (
    Optimizer,
    Solution,
    make_optimizer,
    minimize,
    minimize_restarting,
    registry,
    unavailable,
)
from ocp_traj.exceptions import InputError, UnavailableError, UnknownNameError
from ocp_traj.solvers.per_joint import solve_per_joint
from ocp_traj.solvers.solver import Outcome, Request, Solver
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription import initial_guess
from ocp_traj.transcription.condensed import CondensedNlp

DEFAULT_BUDGET = 20_000
"""Evaluations when the request names none."""


@dataclass(frozen=True)
class Population(Solver):
    """An optimiser of `metaheuristics` on the condensed form.

    Parameters
    ----------
    method : str
        Its short name in `metaheuristics.registry`.
    encoding : str
        ``"durations"``, ``"log-durations"`` or ``"scaled"``; see `CondensedNlp`.
    samples : int
        Samples a gap.
    extrema : str
        ``"auto"``, ``"exact"`` or ``"sampled"``.
    handling : str or None
        Constraint handling; None leaves it to the optimiser.
    start : str
        What the first population holds besides what the method draws: ``"nothing"``, ``"guess"`` (closed-form
        timing) or ``"ipopt"`` (IPOPT's answer; its evaluations are counted).
    restarts : bool
        Restart with a growing population when the search stalls.
    settings : tuple of (name, value)
        The optimiser's own settings.
    """

    kind: ClassVar[str] = "population"

    method: str = "pso"
    encoding: str = "durations"
    samples: int = 16
    extrema: str = "auto"
    handling: str | None = None
    start: str = "nothing"
    restarts: bool = False
    settings: tuple[tuple[str, Any], ...] = ()

    def __post_init__(self) -> None:
        if self.start not in ("nothing", "guess", "ipopt"):
            raise InputError(f"start {self.start!r} is unknown, expected 'nothing', 'guess' or 'ipopt'")
        self.optimizer()

    @classmethod
    def from_settings(cls, settings: dict[str, Any]) -> Population:
        """Return the solver; settings that are no field of this class go to the optimiser.

        ``preset="paper-b"`` takes the optimiser's published settings.
        """
        own = {entry.name for entry in fields(cls)} - {"settings"}
        mine = {key: value for key, value in settings.items() if key in own}
        other = tuple((key, value) for key, value in settings.items() if key not in own)
        return cls(**mine, settings=other)

    def check_available(self) -> None:
        """Raise `UnavailableError` when the optimiser needs a package that is not there."""
        if self.method in unavailable:
            raise UnavailableError(f"solver {self.method!r} cannot be loaded: {unavailable[self.method]}")

    def optimizer(self) -> Optimizer[Any]:
        """Return the optimiser with its settings."""
        self.check_available()
        settings = dict(self.settings)
        preset = settings.pop("preset", None)
        if preset is not None:
            settings = {**_preset(self.method, str(preset)), **settings}
        try:
            return make_optimizer(self.method, **settings)
        except (TypeError, ValueError) as error:
            raise UnknownNameError(f"solver {self.method!r}: {error}") from error

    def run(self, task: TrajectoryTask, request: Request) -> Outcome:
        """Search; see `Solver.run`."""
        if task.search.protocol == "per-joint":
            return solve_per_joint(task, request, self)
        begin = time.perf_counter()
        nlp = CondensedNlp(task, encoding=self.encoding, samples=self.samples, extrema=self.extrema)
        start, spent, counts = self._start(nlp, request)
        build_time = time.perf_counter() - begin
        solution = self.search(nlp, request, start, spent)
        solution = _with_costs(solution, build_time, spent)
        counts = {**counts, "evaluate": solution.evaluations}
        return Outcome(nlp.decode(solution.x), solution, counts)

    def search(self, nlp: CondensedNlp, request: Request, start: Any = None, spent: int = 0) -> Solution:
        """Search the box of a condensed problem."""
        budget = (request.budget or DEFAULT_BUDGET) - spent
        if budget < 1:
            raise InputError(
                f"a budget of {request.budget} is used up by the start, expected more than {spent}"
            )
        rng = np.random.default_rng(request.seed)
        common: dict[str, Any] = {
            "rng": rng,
            "budget": budget,
            "seconds": request.time_limit,
            "x0": start,
            "constraint_handling": self.handling,
            "callback": request.progress,
        }
        if self.restarts:
            return minimize_restarting(nlp, self.optimizer(), **common)
        return minimize(nlp, self.optimizer(), **common)

    def _start(self, nlp: CondensedNlp, request: Request) -> tuple[Any, int, dict[str, int]]:
        """Return the candidates for the first population, evaluations spent on them, and counts."""
        candidates = []
        spent, counts = 0, {}
        if request.warm_start is not None:
            candidates.append(self._encode(nlp, request.warm_start))
        if self.start == "guess":
            candidates.append(nlp.guess)
        elif self.start == "ipopt":
            from ocp_traj.solvers.gradient import Gradient

            outcome = Gradient().run(nlp.task, Request(request.seed, request.budget, request.time_limit))
            spent, counts = outcome.solution.evaluations, outcome.counts
            if outcome.trajectory is not None:
                candidates.append(self._encode(nlp, outcome.trajectory))
        return (np.stack(candidates) if candidates else None), spent, counts

    @staticmethod
    def _encode(nlp: CondensedNlp, trajectory: Trajectory) -> Any:
        same = trajectory.family == nlp.task.family and len(trajectory.breakpoints) == nlp.segments + 1
        motion = trajectory if same else initial_guess(nlp.task, trajectory.segment_durations)
        return np.clip(nlp.encode(motion), nlp.lower, nlp.upper)


def _preset(method: str, preset: str) -> dict[str, Any]:
    """Return the settings a paper prints: ``paper``, or ``paper-b`` where several papers use the method."""
    make = getattr(registry[method][0], "paper", None)
    word, _, key = preset.partition("-")
    try:
        if word != "paper" or make is None:
            raise ValueError("no such preset")
        return _changed_fields(make(key.upper()) if key else make())
    except (TypeError, ValueError) as error:
        raise UnknownNameError(f"solver {method!r} has no preset {preset!r}: {error}") from error


def _changed_fields(optimizer: Optimizer[Any]) -> dict[str, Any]:
    return {entry.name: getattr(optimizer, entry.name) for entry in fields(optimizer) if entry.init}


def _with_costs(solution: Solution, build_time: float, spent: int) -> Solution:
    from dataclasses import replace

    return replace(
        solution, build_time=solution.build_time + build_time, evaluations=solution.evaluations + spent
    )
