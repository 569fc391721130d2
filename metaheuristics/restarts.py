"""Restarts with a growing population."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from metaheuristics.arrays import freeze
from metaheuristics.minimize import Callback, minimize
from metaheuristics.optimizer import Optimizer
from metaheuristics.ordering import Ordering
from metaheuristics.problem import Problem
from metaheuristics.solution import History, Solution, Status
from metaheuristics.stopping import Progress


def minimize_restarting(
    problem: Problem,
    optimizer: Optimizer[Any],
    *,
    rng: np.random.Generator,
    budget: int,
    stall: int = 50,
    growth: float = 2.0,
    seconds: float | None = None,
    target: float | None = None,
    x0: npt.ArrayLike | None = None,
    constraint_handling: Ordering | str | None = None,
    callback: Callback | None = None,
) -> Solution:
    """Search again and again with a growing population, until the budget is used (Auger & Hansen 2005, IPOP).

    Parameters
    ----------
    problem, optimizer, rng, seconds, target, constraint_handling
        As in `minimize`.
    budget
        Evaluations of all searches together.
    stall
        Generations without improvement that end one search.
    growth
        Factor on the population from one search to the next, at least 1.
    x0
        Known candidates, given to the first search only.
    callback
        As in `minimize`, with the counts of the present search; a true answer ends everything.

    Returns
    -------
    Solution
        The best of all searches, with one joined history.

    Raises
    ------
    ValueError
        If the growth is below 1, or as in `minimize`.
    """
    if growth < 1.0:
        raise ValueError(f"The growth of the population is {growth}, expected at least 1.")
    found: list[Solution] = []
    stopped: list[bool] = []

    def watch(progress: Progress) -> bool:
        if callback is not None and callback(progress):
            stopped.append(True)
        return bool(stopped)

    spent, clock, population = 0, 0.0, float(optimizer.population)
    while True:
        settings = replace(optimizer, population=int(population))
        solution = minimize(
            problem,
            settings,
            rng=rng,
            budget=budget - spent,
            stall=stall,
            seconds=None if seconds is None else seconds - clock,
            target=target,
            x0=None if found else x0,
            constraint_handling=constraint_handling,
            callback=watch,
        )
        found.append(solution)
        spent += solution.evaluations
        clock += solution.seconds
        ended = spent >= budget or bool(stopped) or (seconds is not None and clock >= seconds)
        if ended or solution.status is Status.CONVERGED:
            return join(found)
        population *= growth


def join(found: list[Solution]) -> Solution:
    """Return the best of several searches of one problem, with their histories joined.

    Parameters
    ----------
    found
        At least one solution, in the order they were found.
    """
    best = min(found, key=lambda solution: (solution.history.violation[-1], solution.cost))
    return best.paying_for(
        found,
        status=found[-1].status if best.feasible else best.status,
        message=f"Search {found.index(best) + 1} of {len(found)} was best. {found[-1].message}",
        history=join_histories(
            [solution.history for solution in found], [solution.seconds for solution in found]
        ),
    )


def join_histories(histories: list[History], durations: list[float]) -> History:
    """Return one history of searches run one after the other, its best carried over.

    Parameters
    ----------
    histories
        One a search, none empty.
    durations
        Seconds of each search.
    """
    offsets = np.cumsum([0, *(int(history.evaluations[-1]) for history in histories[:-1])])
    starts = np.cumsum([0.0, *durations[:-1]])
    cost = np.concatenate([history.cost for history in histories])
    violation = np.concatenate([history.violation for history in histories])
    best, leaders = 0, np.empty(cost.shape[0], dtype=np.intp)
    for k in range(cost.shape[0]):
        if (violation[k], cost[k]) < (violation[best], cost[best]):
            best = k
        leaders[k] = best
    evaluations = np.concatenate([h.evaluations + offset for h, offset in zip(histories, offsets)])
    evaluations.flags.writeable = False
    return History(
        evaluations=evaluations,
        cost=freeze(cost[leaders]),
        violation=freeze(violation[leaders]),
        seconds=freeze(np.concatenate([h.seconds + start for h, start in zip(histories, starts)])),
        x=freeze(np.concatenate([h.x for h in histories])[leaders]),
        spread=freeze(np.concatenate([h.spread for h in histories])),
    )
