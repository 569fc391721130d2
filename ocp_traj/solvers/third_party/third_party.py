"""Other people's optimisers behind our interface: same problem, same counting, same judge.

An adapter says how its library is started and lets it ask; everything else, the budget included, is done here: the
problem itself counts and ends the library's loop by an exception when nothing may be evaluated any more.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from metaheuristics import Solution, Status
from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError
from ocp_traj.solvers.population.condensed import CondensedSolver
from ocp_traj.solvers.population.counting import BudgetSpent, Counted
from ocp_traj.solvers.solver import DEFAULT_BUDGET, Request
from ocp_traj.transcription.condensed.condensed import CondensedNlp


@dataclass(frozen=True)
class ThirdParty(CondensedSolver):
    """An optimiser of another library on the condensed form.

    Parameters
    ----------
    encoding, samples, extrema
        See `CondensedSolver`.
    penalty : float
        Cost of one unit of violation for libraries without constraints, in units of the first guess's cost.
    """

    kind: ClassVar[str] = "third-party"

    penalty: float = 10.0

    def __post_init__(self) -> None:
        if not self.penalty > 0.0:
            raise InputError(f"penalty is {self.penalty}, expected more than 0")

    def search(self, nlp: CondensedNlp, request: Request, start: Any = None, spent: int = 0) -> Solution:
        """Let the library search; its answer is the best candidate the problem has seen."""
        budget = (request.budget or DEFAULT_BUDGET) - spent
        problem = Counted(nlp, budget, request.time_limit, request.progress)
        try:
            words = self.optimise(problem, np.random.default_rng(request.seed), start)
            return problem.make_solution(Status.STALLED, f"Ended by itself: {words}")
        except BudgetSpent as end:
            return problem.make_solution(end.status, str(end))

    @abstractmethod
    def optimise(self, problem: Counted, rng: np.random.Generator, start: Any) -> str:
        """Search the box of `problem` with ``problem.evaluate``; return why the library ended by itself.

        Parameters
        ----------
        problem : Counted
            ``evaluate`` raises `BudgetSpent` when it is time to end; let it pass.
        rng : numpy.random.Generator
        start : (k, d) or None
            Known candidates.
        """

    def objective(self, problem: Counted) -> Callable[[Array], Array]:
        """Return a function from X (p, d) to one number per candidate, (p,): the cost plus the penalty."""
        unit = self.penalty * max(abs(float(problem.nlp.evaluate(problem.nlp.guess).cost[0])), 1e-12)

        def penalised(X: Array) -> Array:
            cost, violation = problem.evaluate(X).scores
            # A candidate that could not be evaluated is the worst, but finite: some libraries do arithmetic.
            return np.minimum(cost + unit * violation, 1e300)

        return penalised
