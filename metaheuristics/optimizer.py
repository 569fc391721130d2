"""The abstract population optimiser: immutable settings, explicit state, ask and tell."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, TypeVar, cast

import numpy as np
import numpy.typing as npt

from metaheuristics.arrays import FloatArray, freeze, read_only
from metaheuristics.bounds import BOUND_RULES, repair
from metaheuristics.evaluation import Evaluation
from metaheuristics.ordering import FeasibleFirst, Ordering
from metaheuristics.settings import check_settings

INITIAL_PHASE = -1
"""The phase of a state whose first candidates have not been evaluated yet."""


StateT = TypeVar("StateT", bound="State")


@dataclass(frozen=True, eq=False)
class Frame:
    """What stays fixed during one run.

    Parameters
    ----------
    lower, upper, width
        (d,) the box and upper - lower.
    total_generations
        T of the schedules: generations the run is planned for; later ones count as the last.
    lower_rows, upper_rows
        (n, d) the box once a row: NumPy clips a small population three times faster this way.
    """

    lower: FloatArray
    upper: FloatArray
    width: FloatArray
    total_generations: int
    lower_rows: FloatArray
    upper_rows: FloatArray

    @property
    def dimension(self) -> int:
        """Number of variables d."""
        return int(self.lower.shape[0])

    @cached_property
    def largest_width(self) -> float:
        """Width of the box where it is widest."""
        return float(self.width.max())


@dataclass(frozen=True, eq=False)
class State:
    """Where a search stands between two calls; never changed in place.

    Parameters
    ----------
    frame
        What stays fixed.
    ordering
        The rule that says which candidate is better, as of this generation.
    generation
        Finished generations; the initial population is generation 0.
    phase
        Which part of a generation is asked next: 0 at the start of one, `INITIAL_PHASE` before any.
    positions, cost, violation
        (n, d), (n,), (n,) the population as `Evaluation.scores` saw it; cost infinite before the first one.
    """

    frame: Frame
    ordering: Ordering
    generation: int
    phase: int
    positions: FloatArray
    cost: FloatArray
    violation: FloatArray

    @property
    def progress(self) -> float:
        """Share of the planned generations that is finished, 0 to 1."""
        return min(self.generation / self.frame.total_generations, 1.0)

    def evolve(self: StateT, **changes: Any) -> StateT:
        """Return a copy with some fields changed.

        What `dataclasses.replace` does, six times faster: states are made several times a generation, and
        have nothing to check again.
        """
        copied = object.__new__(type(self))
        copied.__dict__.update(self.__dict__)
        copied.__dict__.update(changes)
        return copied


@dataclass(frozen=True)
class Optimizer(ABC, Generic[StateT]):
    """A population method as a value: its fields are its settings, nothing else is kept in it.

    Use `minimize` for whole runs. By hand: ``state = start(...)``, then again and again
    ``X, state = ask(state, rng)``, evaluate X, ``state = tell(state, X, evaluation)``.

    Parameters
    ----------
    population
        Number of candidates n.
    bounds
        Way back into the box: ``"clip"``, ``"reflect"`` or ``"resample"``.

    Raises
    ------
    ValueError
        If a setting is impossible.
    """

    population: int = 50
    bounds: str = "clip"

    def __post_init__(self) -> None:
        check_settings(type(self).__name__, type(self), self.__dict__)
        if self.population < self.minimum_population:
            raise ValueError(
                f"The population of {type(self).__name__} is {self.population}, "
                f"expected at least {self.minimum_population}."
            )
        if self.bounds not in BOUND_RULES:
            raise ValueError(f"The bound rule is {self.bounds!r}, expected one of {', '.join(BOUND_RULES)}.")

    @property
    def minimum_population(self) -> int:
        """Smallest population the rules make sense for."""
        return 2

    @property
    def initial_evaluations(self) -> int:
        """Candidates evaluated before the first generation."""
        return self.population

    @property
    def evaluations_per_generation(self) -> int:
        """Candidates evaluated in every generation."""
        return self.population

    @property
    def default_ordering(self) -> Ordering:
        """The constraint handling this method uses unless told otherwise."""
        return FeasibleFirst()

    def start(
        self,
        lower: npt.ArrayLike,
        upper: npt.ArrayLike,
        rng: np.random.Generator,
        *,
        total_generations: int = 1000,
        ordering: Ordering | None = None,
        x0: npt.ArrayLike | None = None,
    ) -> StateT:
        """Draw the initial population.

        Parameters
        ----------
        lower, upper
            (d,) a finite box.
        rng
            Source of all randomness.
        total_generations
            Generations planned, T of the schedules, at least 1.
        ordering
            Constraint handling; the method's own by default.
        x0
            (d,) or (k, d) known candidates that replace the first rows of the initial population.

        Returns
        -------
        State
            Before the first `ask`.

        Raises
        ------
        ValueError
            If the box is not finite, T is below 1, or x0 does not fit.
        """
        frame = make_frame(lower, upper, total_generations, self.population)
        positions = self.draw_initial(frame, rng)
        if x0 is not None:
            positions = inject(positions, x0, frame)
        chosen = self.default_ordering if ordering is None else ordering
        return self.make_state(frame, chosen, positions, rng)

    def draw_initial(self, frame: Frame, rng: np.random.Generator) -> FloatArray:
        """Return the initial population (n, d), uniform in the box unless a method says otherwise."""
        return frame.lower + frame.width * rng.random((self.population, frame.dimension))

    def make_state(
        self, frame: Frame, ordering: Ordering, positions: FloatArray, rng: np.random.Generator
    ) -> StateT:
        """Return the state before the initial population (n, d) is evaluated; a plain `State` by default."""
        worst = np.full(positions.shape[0], np.inf)
        return cast(StateT, State(frame, ordering, 0, INITIAL_PHASE, positions, worst, worst))

    @abstractmethod
    def propose(self, state: StateT, rng: np.random.Generator) -> tuple[FloatArray, StateT]:
        """Return candidates (p, d), possibly outside the box, and the state that remembers how they came.

        The candidates are a new array, which is brought into the box in place. Not called for the initial
        population, which is asked as it was drawn.
        """

    @abstractmethod
    def absorb(self, state: StateT, X: FloatArray, cost: FloatArray, violation: FloatArray) -> StateT:
        """Return the state after the scores (p,) of the candidates (p, d) of the last `propose`."""

    def ask(self, state: StateT, rng: np.random.Generator) -> tuple[FloatArray, StateT]:
        """Return the next candidates, inside the box, and the state to hand to `tell`.

        Parameters
        ----------
        state
            As the last `start` or `tell` gave it.
        rng
            Source of all randomness.

        Returns
        -------
        X, state
            (p, d) candidates, read-only, and the state that goes with them.
        """
        if state.phase == INITIAL_PHASE:
            return read_only(state.positions), state
        proposed, state = self.propose(state, rng)
        p, frame = proposed.shape[0], state.frame
        if p <= frame.lower_rows.shape[0]:
            X = repair(self.bounds, proposed, frame.lower_rows[:p], frame.upper_rows[:p], rng)
        else:
            X = repair(self.bounds, proposed, frame.lower, frame.upper, rng)
        X.flags.writeable = False
        return X, state

    def tell(self, state: StateT, X: FloatArray, evaluation: Evaluation) -> StateT:
        """Return the state after the candidates were judged.

        Parameters
        ----------
        state, X
            As the last `ask` gave them.
        evaluation
            Of X, row by row; NaN and infinity count as worst.

        Returns
        -------
        State
            Ready for the next `ask`; `phase` is 0 when a generation is complete.

        Raises
        ------
        ValueError
            If the evaluation does not fit X.
        """
        cost, violation = evaluation.scores
        if cost.shape[0] != X.shape[0]:
            raise ValueError(
                f"The evaluation has {cost.shape[0]} costs for {X.shape[0]} candidates, expected one each."
            )
        state = self.absorb(state, X, cost, violation)
        if state.phase == 0:
            ordering = state.ordering.adapt(state.cost, state.violation, state.progress)
            if ordering is not state.ordering:
                state = state.evolve(ordering=ordering)
        return state


def make_frame(lower: npt.ArrayLike, upper: npt.ArrayLike, total_generations: int, rows: int) -> Frame:
    """Check the box and the number of generations, and return the frame of a run.

    Raises
    ------
    ValueError
        If the box is not finite or empty, or fewer than one generation is planned.
    """
    low, high = freeze(lower), freeze(upper)
    if low.ndim != 1 or low.shape != high.shape:
        raise ValueError(f"The bounds have shapes {low.shape} and {high.shape}, expected (d,) twice.")
    wrong = ~(np.isfinite(low) & np.isfinite(high) & (low <= high))
    if wrong.any():
        i = int(np.argmax(wrong))
        raise ValueError(
            f"Variable {i + 1} has bounds [{low[i]}, {high[i]}]: a population method needs a finite box."
        )
    if total_generations < 1:
        raise ValueError(f"The number of generations is {total_generations}, expected at least 1.")
    width = freeze(high - low)
    return Frame(
        low, high, width, total_generations, freeze(np.tile(low, (rows, 1))), freeze(np.tile(high, (rows, 1)))
    )


def inject(positions: FloatArray, x0: npt.ArrayLike, frame: Frame) -> FloatArray:
    """Return the population with known candidates in its first rows.

    Parameters
    ----------
    positions
        (n, d) the population drawn.
    x0
        (d,) or (k, d) known candidates, k <= n; an excess by rounding (1e-9 of the width) is clipped.
    frame
        The box.

    Raises
    ------
    ValueError
        If the shape does not fit, there are more candidates than places, or one is outside the box.
    """
    known = np.atleast_2d(np.asarray(x0, dtype=np.float64))
    n, d = positions.shape
    if known.ndim != 2 or known.shape[1] != d or known.shape[0] > n:
        raise ValueError(f"x0 has shape {np.shape(x0)}, expected ({d},) or (k, {d}) with k <= {n}.")
    slack = 1e-9 * frame.width
    inside = (known >= frame.lower - slack) & (known <= frame.upper + slack)
    if not inside.all():
        row, column = (int(i) for i in np.argwhere(~inside)[0])
        raise ValueError(
            f"x0 row {row + 1}, variable {column + 1} is {known[row, column]}, expected a value in "
            f"[{frame.lower[column]}, {frame.upper[column]}]."
        )
    filled: FloatArray = positions.copy()
    filled[: known.shape[0]] = np.clip(known, frame.lower, frame.upper)
    return filled
