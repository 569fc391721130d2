"""SciPy's global optimisers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import Bounds, differential_evolution, dual_annealing

from ocp_traj.solvers.population.counting import Counted
from ocp_traj.solvers.third_party.third_party import ThirdParty

FOREVER = 10**7
"""Iterations nobody reaches: the problem's budget ends the run."""


@dataclass(frozen=True)
class DifferentialEvolutionOfSciPy(ThirdParty):
    """SciPy's differential evolution, whole generations at once, without its final polishing."""

    popsize: int = 15
    strategy: str = "best1bin"

    def optimise(self, problem: Counted, rng: np.random.Generator, start: Any) -> str:
        """Run `scipy.optimize.differential_evolution`; see `ThirdParty.optimise`."""
        objective = self.objective(problem)
        answer = differential_evolution(
            lambda X: objective(X.T),
            Bounds(problem.lower, problem.upper),
            strategy=self.strategy,
            popsize=self.popsize,
            maxiter=FOREVER,
            tol=0.0,
            rng=rng,
            polish=False,
            updating="deferred",
            vectorized=True,
            x0=None if start is None else start[0],
        )
        return str(answer.message)


@dataclass(frozen=True)
class DualAnnealingOfSciPy(ThirdParty):
    """SciPy's dual annealing with its local search, one candidate at a time."""

    initial_temp: float = 5230.0
    local_search: bool = True

    def optimise(self, problem: Counted, rng: np.random.Generator, start: Any) -> str:
        """Run `scipy.optimize.dual_annealing`; see `ThirdParty.optimise`."""
        objective = self.objective(problem)
        answer = dual_annealing(
            lambda x: float(objective(x[None])[0]),
            Bounds(problem.lower, problem.upper),
            maxiter=FOREVER,
            maxfun=FOREVER,
            initial_temp=self.initial_temp,
            no_local_search=not self.local_search,
            rng=rng,
            x0=None if start is None else start[0],
        )
        return str(answer.message)
