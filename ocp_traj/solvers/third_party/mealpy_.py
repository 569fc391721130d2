"""mealpy's sparrow search, as it is: its update rules differ from the paper's in sign and group sizes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from mealpy import FloatVar
from mealpy.swarm_based.SSA import OriginalSSA

from ocp_traj.exceptions import InputError
from ocp_traj.solvers.population.counting import Counted
from ocp_traj.solvers.third_party.third_party import ThirdParty

FOREVER = 100_000
"""Generations nobody reaches (mealpy's largest): the problem's budget ends the run."""


@dataclass(frozen=True)
class SparrowSearchOfMealpy(ThirdParty):
    """mealpy's sparrow search, one candidate at a time, limits by a penalty."""

    population: int = 50
    ST: float = 0.8
    PD: float = 0.2
    SD: float = 0.1

    def optimise(self, problem: Counted, rng: np.random.Generator, start: Any) -> str:
        """Run `mealpy.SSA.OriginalSSA`; see `ThirdParty.optimise`."""
        if self.population < 10:
            raise InputError(f"population is {self.population}, mealpy expects at least 10")
        objective = self.objective(problem)
        stated = {
            "obj_func": lambda x: float(objective(np.asarray(x)[None])[0]),
            "bounds": FloatVar(lb=problem.lower.tolist(), ub=problem.upper.tolist()),
            "minmax": "min",
            "log_to": None,
        }
        optimizer = OriginalSSA(epoch=FOREVER, pop_size=self.population, ST=self.ST, PD=self.PD, SD=self.SD)
        known = None if start is None else _fill(problem, start, self.population, rng)
        optimizer.solve(stated, seed=int(rng.integers(2**31)), starting_solutions=known)
        return f"{FOREVER} generations"


def _fill(problem: Counted, start: Any, count: int, rng: np.random.Generator) -> Any:
    """Return a whole first population that holds the known candidates; mealpy takes no part of one."""
    drawn = rng.uniform(problem.lower, problem.upper, (count, problem.dimension))
    drawn[: len(start)] = start[:count]
    return drawn
