"""Which of two candidates is better: constraint handling as one exchangeable rule.

Optimisers never compare costs themselves; they ask an `Ordering`. What is *reported* as the best is always
judged feasible-first, whatever rule guided the search, so runs with different rules can be compared.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import numpy as np

from metaheuristics.arrays import BoolArray, FloatArray, IntArray
from metaheuristics.nondominated import crowding_distance, front_numbers


@dataclass(frozen=True)
class Ordering(ABC):
    """A rule that says which candidate is better, given cost and total violation.

    Costs and violations are as `Evaluation.scores` holds them: no NaN, infinity for a broken candidate.
    """

    @abstractmethod
    def is_better(
        self, cost: FloatArray, violation: FloatArray, other_cost: FloatArray, other_violation: FloatArray
    ) -> BoolArray:
        """Return, pair by pair (p,), whether the first candidate is strictly better than the other."""

    @abstractmethod
    def sort(self, cost: FloatArray, violation: FloatArray) -> IntArray:
        """Return the indices (p,) that put the candidates best first; equals keep their order."""

    def find_best(self, cost: FloatArray, violation: FloatArray) -> int:
        """Return the index of the best candidate."""
        return int(self.sort(cost, violation)[0])

    def beats(self, cost: float, violation: float, other_cost: float, other_violation: float) -> bool:
        """Return whether one candidate is strictly better than another."""
        values = (np.array([value]) for value in (cost, violation, other_cost, other_violation))
        return bool(self.is_better(*values)[0])

    def adapt(self, cost: FloatArray, violation: FloatArray, progress: float) -> Ordering:
        """Return the rule for the next generation.

        Parameters
        ----------
        cost, violation
            (p,) the population at the end of the generation.
        progress
            Share of the generations already run, 0 after the initial population, 1 at the end.

        Returns
        -------
        Ordering
            This rule itself unless it changes with time.
        """
        return self


@dataclass(frozen=True)
class FeasibleFirst(Ordering):
    """Less violation wins; among equal violation, less cost (Deb 2000, doi 10.1016/S0045-7825(99)00389-8).

    Parameters
    ----------
    tolerance
        A total violation up to this counts as none.
    """

    tolerance: float = 0.0

    def _counted(self, violation: FloatArray) -> FloatArray:
        return violation if self.tolerance == 0.0 else np.where(violation <= self.tolerance, 0.0, violation)

    def is_better(
        self, cost: FloatArray, violation: FloatArray, other_cost: FloatArray, other_violation: FloatArray
    ) -> BoolArray:
        """Compare violations first, then costs; see `Ordering.is_better`."""
        better: BoolArray = cost < other_cost
        if violation is other_violation:
            return better
        mine, other = self._counted(violation), self._counted(other_violation)
        if np.count_nonzero(mine) or np.count_nonzero(other):
            better &= mine == other
            better |= mine < other
        return better

    def sort(self, cost: FloatArray, violation: FloatArray) -> IntArray:
        """Sort by violation, then cost; see `Ordering.sort`."""
        counted = self._counted(violation)
        if not np.count_nonzero(counted):
            return cost.argsort(kind="stable")
        return np.lexsort((cost, counted))

    def beats(self, cost: float, violation: float, other_cost: float, other_violation: float) -> bool:
        """Compare two candidates; see `Ordering.beats`."""
        mine = 0.0 if violation <= self.tolerance else violation
        other = 0.0 if other_violation <= self.tolerance else other_violation
        return mine < other or (mine == other and cost < other_cost)

    def find_best(self, cost: FloatArray, violation: FloatArray) -> int:
        """Return the least cost among the least violation; see `Ordering.find_best`."""
        counted = self._counted(violation)
        if not np.count_nonzero(counted):
            return int(cost.argmin())
        return int(np.where(counted == counted.min(), cost, np.inf).argmin())


@dataclass(frozen=True)
class EpsilonLevel(FeasibleFirst):
    """Feasible-first with a tolerance that shrinks (Takahama & Sakai 2006, doi 10.1109/CEC.2006.1688283).

    The level starts at the violation of the candidate at `quantile` of the initial population and follows
    eps(t) = eps(0) (1 - t / t_control)^exponent, 0 from t_control on; `tolerance` holds the present level.

    Parameters
    ----------
    quantile
        Place of the candidate in the initial population, 0 = least violation (theta = 0.2 in the source).
    control
        Share of the generations after which the level is 0 (T_c).
    exponent
        How fast it falls (cp = 5 in the source).
    initial_level
        eps(0); set by the initial population, negative until then.
    """

    quantile: float = 0.2
    control: float = 0.5
    exponent: float = 5.0
    initial_level: float = -1.0

    def adapt(self, cost: FloatArray, violation: FloatArray, progress: float) -> Ordering:
        """Return the rule with the level for this progress; see `Ordering.adapt`."""
        start = self.initial_level
        if start < 0.0:
            finite = np.sort(violation[np.isfinite(violation)])
            start = float(finite[int(self.quantile * (finite.size - 1))]) if finite.size else 0.0
        level = start * (1.0 - progress / self.control) ** self.exponent if progress < self.control else 0.0
        return replace(self, initial_level=start, tolerance=level)


@dataclass(frozen=True)
class StaticPenalty(Ordering):
    """Cost plus a constant times the total violation.

    Parameters
    ----------
    weight
        Cost of one unit of violation (a violation of 1 breaks a limit by 100 %).
    """

    weight: float = 1e3

    def _penalised(self, cost: FloatArray, violation: FloatArray) -> FloatArray:
        return cost + self.weight * violation

    def is_better(
        self, cost: FloatArray, violation: FloatArray, other_cost: FloatArray, other_violation: FloatArray
    ) -> BoolArray:
        """Compare the penalised costs; see `Ordering.is_better`."""
        return self._penalised(cost, violation) < self._penalised(other_cost, other_violation)

    def beats(self, cost: float, violation: float, other_cost: float, other_violation: float) -> bool:
        """Compare two candidates; see `Ordering.beats`."""
        return cost + self.weight * violation < other_cost + self.weight * other_violation

    def find_best(self, cost: FloatArray, violation: FloatArray) -> int:
        """Return the least penalised cost; see `Ordering.find_best`."""
        return int(self._penalised(cost, violation).argmin())

    def sort(self, cost: FloatArray, violation: FloatArray) -> IntArray:
        """Sort by the penalised cost; see `Ordering.sort`."""
        return self._penalised(cost, violation).argsort(kind="stable")


@dataclass(frozen=True)
class AdaptivePenalty(StaticPenalty):
    """Static penalty whose weight follows the search (Hadj-Alouane & Bean 1997, doi 10.1287/opre.45.1.92).

    After `patience` generations whose best was always feasible the weight is divided by `decrease`; after as
    many whose best was always infeasible it is multiplied by `increase`.

    Parameters
    ----------
    increase, decrease
        Factors, different from each other so the weight cannot cycle.
    patience
        Generations that decide.
    streak
        Generations in a row with a feasible (positive) or infeasible (negative) best.
    """

    increase: float = 2.0
    decrease: float = 1.5
    patience: int = 5
    streak: int = 0

    def adapt(self, cost: FloatArray, violation: FloatArray, progress: float) -> Ordering:
        """Return the rule with its streak and weight brought up to date; see `Ordering.adapt`."""
        feasible = violation[self.find_best(cost, violation)] == 0.0
        streak = max(self.streak, 0) + 1 if feasible else min(self.streak, 0) - 1
        if abs(streak) < self.patience:
            return replace(self, streak=streak)
        weight = self.weight / self.decrease if feasible else self.weight * self.increase
        return replace(self, weight=weight, streak=0)


@dataclass(frozen=True)
class NonDominated(FeasibleFirst):
    """Non-dominated sorting of (cost, violation), the third scheme of paper A.

    The violation becomes a second objective. Candidates are ranked by their non-dominated front, inside a
    front by crowding distance (the crowding is our addition). One candidate replaces another if it dominates
    it, or if neither dominates and `best` prefers it.

    Parameters
    ----------
    best
        Which point of the first front leads: ``"feasible-first"`` (least violation, then cost; default) or
        ``"lowest-cost"`` (the words of step 5 of paper A).

    Raises
    ------
    ValueError
        If `best` is neither.
    """

    best: str = "feasible-first"

    def __post_init__(self) -> None:
        if self.best not in ("feasible-first", "lowest-cost"):
            raise ValueError(f"best is {self.best!r}, expected 'feasible-first' or 'lowest-cost'.")

    def is_better(
        self, cost: FloatArray, violation: FloatArray, other_cost: FloatArray, other_violation: FloatArray
    ) -> BoolArray:
        """Compare by dominance, then by the rule for the best; see `Ordering.is_better`."""
        # A candidate that dominates is better under either lexicographic rule, so that rule alone decides.
        if self.best == "feasible-first":
            return super().is_better(cost, violation, other_cost, other_violation)
        return super().is_better(violation, cost, other_violation, other_cost)

    def sort(self, cost: FloatArray, violation: FloatArray) -> IntArray:
        """Sort by front, then by falling crowding distance, the leading point first; see `Ordering.sort`."""
        counted = self._counted(violation)
        if not np.count_nonzero(counted):
            return cost.argsort(kind="stable")
        fronts = front_numbers(cost, counted)
        order = np.lexsort((-crowding_distance(cost, counted, fronts), fronts))
        leader = self.find_best(cost, violation)
        return np.concatenate(([leader], order[order != leader]))

    def beats(self, cost: float, violation: float, other_cost: float, other_violation: float) -> bool:
        """Compare two candidates; see `Ordering.beats`."""
        if self.best == "feasible-first":
            return super().beats(cost, violation, other_cost, other_violation)
        return super().beats(violation, cost, other_violation, other_cost)

    def find_best(self, cost: FloatArray, violation: FloatArray) -> int:
        """Return the leading point by the reading `best`; see `Ordering.find_best`."""
        if self.best == "feasible-first":
            return super().find_best(cost, violation)
        counted = self._counted(violation)
        return int(np.where(cost == cost.min(), counted, np.inf).argmin())


ORDERINGS: dict[str, Ordering] = {
    "feasible-first": FeasibleFirst(),
    "epsilon": EpsilonLevel(),
    "static-penalty": StaticPenalty(),
    "adaptive-penalty": AdaptivePenalty(),
    "nondominated": NonDominated(),
}


def find_ordering(rule: Ordering | str) -> Ordering:
    """Return the rule, by its name in `ORDERINGS` or as given.

    Raises
    ------
    ValueError
        If no rule has that name.
    """
    if isinstance(rule, Ordering):
        return rule
    if rule not in ORDERINGS:
        raise ValueError(f"The constraint handling is {rule!r}, expected one of {', '.join(ORDERINGS)}.")
    return ORDERINGS[rule]
