"""
A solver of your own
====================

A solver is an immutable value whose fields are its settings, with one method. This one asks SciPy's
Nelder-Mead for the proportions of the durations; their smallest feasible total is closed form. To make it
known by name, name the class in your package's entry points, in the group ``ocp_traj.solvers``:

.. code-block:: toml

    [project.entry-points."ocp_traj.solvers"]
    nelder-mead = "my_package:NelderMead"
"""

import time
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

import ocp_traj as ot
from metaheuristics import History, Solution, Status
from ocp_traj.solvers import Outcome, Request, Solver
from ocp_traj.transcription.condensed.condensed import CondensedNlp


@dataclass(frozen=True)
class NelderMead(Solver):
    """SciPy's simplex search over proportions of durations."""

    kind = "third-party"
    tolerance: float = 1e-6

    def run(self, task: ot.TrajectoryTask, request: Request) -> Outcome:
        """Solve one task."""
        begin = time.perf_counter()
        nlp = CondensedNlp(task, encoding="scaled")
        rng = np.random.default_rng(request.seed)
        built = time.perf_counter()
        found = minimize(
            lambda x: float(nlp.evaluate(x[None, :]).cost[0]),
            rng.uniform(nlp.lower, nlp.upper),
            method="Nelder-Mead",
            bounds=list(zip(nlp.lower, nlp.upper)),
            options={"xatol": self.tolerance, "fatol": self.tolerance, "maxfev": request.budget or 2000},
        )
        status = Status.CONVERGED if found.success else Status.BUDGET_EXHAUSTED
        times = (built - begin, time.perf_counter() - built)
        said = (status, found.message, found.nfev)
        history = History.empty(nlp.dimension)
        solution = Solution(nlp, found.x, found.fun, 0.0, *said, *times, history)
        return Outcome(nlp.decode(found.x), solution)


result = ot.solve(ot.load_case("machines-2024-490"), NelderMead(), seed=1)
print(result)
print("the duration should be close to 4.3104 s")
assert result.feasible and abs(result.duration - 4.3104) < 0.01
