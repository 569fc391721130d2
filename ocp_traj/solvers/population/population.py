"""Population methods on the condensed form: one adapter for every optimiser of `metaheuristics`."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar

import numpy as np

from metaheuristics import (
    Optimizer,
    Solution,
    make_optimizer,
    minimize,
    minimize_restarting,
    registry,
)
from metaheuristics.ordering import find_ordering
from ocp_traj.exceptions import InputError, UnknownNameError
from ocp_traj.solvers.population.condensed import CondensedSolver, encode_motion
from ocp_traj.solvers.population.counting import Counted
from ocp_traj.solvers.solver import DEFAULT_BUDGET, Request
from ocp_traj.transcription.condensed.condensed import CondensedNlp


@dataclass(frozen=True)
class Population(CondensedSolver):
    """An optimiser of `metaheuristics` on the condensed form.

    Parameters
    ----------
    method : str
        Its short name in `metaheuristics.registry`.
    encoding, samples, extrema
        See `CondensedSolver`.
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
    handling: str | None = None
    start: str = "nothing"
    restarts: bool = False
    settings: tuple[tuple[str, Any], ...] = ()

    def __post_init__(self) -> None:
        if self.start not in ("nothing", "guess", "ipopt"):
            raise InputError(f"start {self.start!r} is unknown, expected 'nothing', 'guess' or 'ipopt'")
        if self.handling is not None:
            try:
                find_ordering(self.handling)
            except ValueError as error:
                raise InputError(str(error)) from None
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

    def optimizer(self) -> Optimizer[Any]:
        """Return the optimiser with its settings."""
        settings = dict(self.settings)
        preset = settings.pop("preset", None)
        if preset is not None:
            settings = {**_preset(self.method, str(preset)), **settings}
        try:
            return make_optimizer(self.method, **settings)
        except (TypeError, ValueError) as error:
            raise UnknownNameError(str(error)) from error

    def search(self, nlp: CondensedNlp, request: Request, start: Any = None, spent: int = 0) -> Solution:
        """Search the box of a condensed problem."""
        budget = (request.budget or DEFAULT_BUDGET) - spent
        if budget < 1:
            raise InputError(
                f"a budget of {request.budget} is used up by the start, expected more than {spent}"
            )
        return self.search_counted(Counted(nlp, budget), replace(request, budget=budget), start)

    def search_counted(self, problem: Counted, request: Request, start: Any = None) -> Solution:
        """Search a problem that counts; the budget is its own."""
        common: dict[str, Any] = {
            "rng": np.random.default_rng(request.seed),
            "budget": problem.budget,
            "seconds": request.time_limit,
            "x0": start,
            "constraint_handling": self.handling,
            "callback": request.progress,
        }
        run = minimize_restarting if self.restarts else minimize
        solution = run(problem, self.optimizer(), **common)
        return replace(solution, problem=problem.nlp, evaluations=problem.evaluations)

    def start_candidates(self, nlp: CondensedNlp, request: Request) -> tuple[Any, int, dict[str, int]]:
        """Return the warm start and what `start` asks for; see `CondensedSolver.start_candidates`."""
        known, spent, counts = super().start_candidates(nlp, request)
        candidates = [] if known is None else list(known)
        if self.start == "guess":
            candidates.append(nlp.guess)
        elif self.start == "ipopt":
            from ocp_traj.solvers.gradient.gradient import Gradient

            outcome = Gradient().run(nlp.task, Request(request.seed, request.budget, request.time_limit))
            spent, counts = outcome.solution.evaluations, outcome.counts
            if outcome.trajectory is not None:
                candidates.append(encode_motion(nlp, outcome.trajectory))
        return (np.stack(candidates) if candidates else None), spent, counts


def _preset(method: str, preset: str) -> dict[str, Any]:
    """Return the settings a paper prints: ``paper``, or ``paper-b`` where several papers use the method."""
    make = getattr(registry[method].kind, "paper", None)
    word, _, key = preset.partition("-")
    if word != "paper" or make is None:
        raise UnknownNameError(f"{method!r} has no preset {preset!r}: no such preset")
    reasons = []
    # Papers and variants are spelt "B", "TADF-SSA" and "D-plain".
    for arguments in ((key.upper(),), (key.capitalize(),)) if key else ((),):
        try:
            return _changed_fields(make(*arguments))
        except (TypeError, ValueError) as error:
            reasons.append(str(error))
    raise UnknownNameError(f"{method!r} has no preset {preset!r}: {reasons[0]}")


def _changed_fields(optimizer: Optimizer[Any]) -> dict[str, Any]:
    return {entry.name: getattr(optimizer, entry.name) for entry in fields(optimizer) if entry.init}
