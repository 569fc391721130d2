"""pycma, the reference implementation of CMA-ES by its author."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cma
import numpy as np

from ocp_traj.solvers.population.counting import Counted
from ocp_traj.solvers.third_party.third_party import ThirdParty


@dataclass(frozen=True)
class PyCma(ThirdParty):
    """pycma's CMA-ES with restarts of growing population, limits by a penalty."""

    sigma: float = 0.3

    def optimise(self, problem: Counted, rng: np.random.Generator, start: Any) -> str:
        """Ask and tell in the unit box, restarting whenever pycma stops; see `ThirdParty.optimise`."""
        objective = self.objective(problem)
        width = problem.upper - problem.lower
        size = 4 + int(3 * np.log(problem.dimension))
        while True:
            first = rng.uniform(size=problem.dimension)
            if start is not None:
                first = np.divide(start[0] - problem.lower, width, out=first, where=width > 0)
                start = None
            options = {
                "bounds": [0.0, 1.0],
                "popsize": size,
                "seed": int(rng.integers(1, 2**31)),
                "verbose": -9,
            }
            strategy = cma.CMAEvolutionStrategy(first, self.sigma, options)
            while not strategy.stop():
                asked = strategy.ask()
                values = objective(problem.lower + width * np.stack(asked))
                strategy.tell(asked, values.tolist())
            size *= 2
