"""When a run ends."""

from __future__ import annotations

from dataclasses import dataclass

from metaheuristics.arrays import FloatArray
from metaheuristics.solution import Status

Verdict = tuple[Status, str]


@dataclass(frozen=True, eq=False)
class Progress:
    """What a callback sees after every generation.

    Parameters
    ----------
    generation, evaluations, seconds
        Spent so far; generation 0 is the initial population.
    x, cost, violation
        (d,) the best candidate so far, its cost and total violation.
    spread
        Standard deviation of the population relative to the box, mean over the coordinates.
    population
        (n, d) the current population, read-only.
    """

    generation: int
    evaluations: int
    seconds: float
    x: FloatArray
    cost: float
    violation: float
    spread: float
    population: FloatArray


@dataclass(frozen=True)
class Limits:
    """The limits of a run; the first one reached ends it.

    Parameters
    ----------
    budget
        Evaluations, never exceeded.
    generations
        Generations after the initial population.
    seconds
        Wall time; looked at between batches, s.
    target
        A feasible candidate with this cost or less ends the run.
    stall
        Generations without improvement that end the run.

    Raises
    ------
    ValueError
        If a limit is not positive, or nothing would ever end the run.
    """

    budget: int | None = None
    generations: int | None = None
    seconds: float | None = None
    target: float | None = None
    stall: int | None = None

    def __post_init__(self) -> None:
        for name in ("budget", "generations", "seconds", "stall"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise ValueError(f"The limit {name} is {value}, expected more than 0.")
        if self.budget is None and self.generations is None and self.seconds is None and self.stall is None:
            raise ValueError("No limit was given, expected budget, generations, seconds or stall.")

    def total_generations(self, initial_evaluations: int, evaluations_per_generation: int) -> int:
        """Return T, the generations the schedules should plan for.

        Parameters
        ----------
        initial_evaluations, evaluations_per_generation
            What the optimiser spends.

        Returns
        -------
        int
            The smaller of what generations and budget allow, at least 1; 1000 where only time or stall limits
            the run, since the number of generations is not known beforehand then.
        """
        planned = [] if self.generations is None else [self.generations]
        if self.budget is not None:
            planned.append(-((initial_evaluations - self.budget) // evaluations_per_generation))
        return max(min(planned), 1) if planned else 1000

    def judge(self, evaluations: int, seconds: float, cost: float, violation: float) -> Verdict | None:
        """Return the verdict of the limits that may strike at any time, or None to go on."""
        if self.target is not None and violation == 0.0 and cost <= self.target:
            return Status.CONVERGED, f"Reached {cost:.6g}, the target is {self.target:.6g}."
        if self.budget is not None and evaluations >= self.budget:
            return Status.BUDGET_EXHAUSTED, f"Used the {self.budget} evaluations allowed."
        if self.seconds is not None and seconds >= self.seconds:
            return Status.TIME_EXHAUSTED, f"Used the {self.seconds:g} s allowed."
        return None

    def judge_generation(self, generation: int, stalled: int) -> Verdict | None:
        """Return the verdict of the limits that strike at the end of a generation, or None to go on."""
        if self.generations is not None and generation >= self.generations:
            return Status.BUDGET_EXHAUSTED, f"Ran the {self.generations} generations allowed."
        if self.stall is not None and stalled >= self.stall:
            return Status.STALLED, f"The best did not improve for {stalled} generations."
        return None
