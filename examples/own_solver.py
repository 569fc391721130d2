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

from dataclasses import dataclass

from scipy.optimize import minimize

import ocp_traj as ot
from metaheuristics import Solution, Status
from ocp_traj.solvers import Outcome, Request, Solver


@dataclass(frozen=True)
class NelderMead(Solver):
    """SciPy's simplex search over proportions of durations."""

    kind = "third-party"
    tolerance: float = 1e-6

    def run(self, task: ot.TrajectoryTask, request: Request) -> Outcome:
        """Solve one task."""
        nlp = ot.transcribe(task, encoding="scaled")
        options = {"xatol": self.tolerance, "fatol": self.tolerance, "maxfev": request.budget or 2000}
        found = minimize(lambda x: nlp.evaluate(x).cost[0], nlp.guess, method="Nelder-Mead", options=options)
        status = Status.CONVERGED if found.success else Status.BUDGET_EXHAUSTED
        solution = Solution(
            problem=nlp, x=found.x, cost=found.fun, status=status, message=found.message, evaluations=found.nfev
        )
        return Outcome(nlp.decode(found.x), solution)


result = ot.solve(ot.load_case("machines-2024-490"), NelderMead(), seed=1)
print(result)
print("the duration should be close to 4.3104 s")
assert result.feasible and abs(result.duration - 4.3104) < 0.01
