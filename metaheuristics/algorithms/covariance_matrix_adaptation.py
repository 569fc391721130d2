"""CMA-ES by the `cmaes` package, behind the same ask and tell as everything else."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from metaheuristics.arrays import FloatArray
from metaheuristics.optimizer import INITIAL_PHASE, Frame, Optimizer, State
from metaheuristics.ordering import Ordering

if TYPE_CHECKING:  # it imports scipy.stats, which takes longer than many a solve
    import cmaes


@dataclass(frozen=True, eq=False)
class CmaState(State):
    """A covariance matrix adaptation between two calls.

    Parameters
    ----------
    engine
        Everything `cmaes.CMA` knows, by name; empty before the first generation. In the unit box.
    """

    engine: dict[str, Any]


@dataclass(frozen=True)
class CovarianceMatrixAdaptation(Optimizer[CmaState]):
    """CMA-ES (Hansen 2016, arXiv:1604.00772) of the package `cmaes`, working in the unit box.

    The first population is uniform in the box, its best becomes the mean. Only the order of candidates
    counts, so every constraint handling works. Candidates outside are resampled by the package itself.
    Where the package says it has converged or degenerated, it starts again from a random mean.

    Parameters
    ----------
    population, bounds
        See `Optimizer`.
    sigma
        First standard deviation, relative to the width of the box.
    """

    population: int = 16
    sigma: float = 0.3

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.sigma > 0.0:
            raise ValueError(f"sigma is {self.sigma}, expected more than 0.")

    @property
    def minimum_population(self) -> int:
        """Smallest population the weights are defined for."""
        return 4

    def make_state(
        self, frame: Frame, ordering: Ordering, positions: FloatArray, rng: np.random.Generator
    ) -> CmaState:
        """Return the state before the initial population is evaluated; see `Optimizer.make_state`."""
        worst = np.full(positions.shape[0], np.inf)
        return CmaState(frame, ordering, 0, INITIAL_PHASE, positions, worst, worst, {})

    def make_engine(self, mean: FloatArray) -> cmaes.CMA:
        """Return a fresh engine in the unit box that starts at the mean (d,)."""
        import cmaes

        box = np.tile([0.0, 1.0], (mean.shape[0], 1))
        return cmaes.CMA(mean, self.sigma, bounds=box, population_size=self.population)

    def propose(self, state: CmaState, rng: np.random.Generator) -> tuple[FloatArray, CmaState]:
        """Sample the distribution; see `Optimizer.propose`."""
        engine = wake(state.engine)
        if engine.should_stop():
            engine = self.make_engine(rng.random(state.frame.dimension))
        engine.reseed_rng(int(rng.integers(2**32)))
        unit = np.array([engine.ask() for _ in range(self.population)])
        scaled: FloatArray = state.frame.lower + state.frame.width * unit
        return scaled, state.evolve(engine=rest(engine))

    def absorb(self, state: CmaState, X: FloatArray, cost: FloatArray, violation: FloatArray) -> CmaState:
        """Adapt the distribution; see `Optimizer.absorb`."""
        frame = state.frame
        width = np.where(frame.width > 0.0, frame.width, 1.0)
        unit = np.clip((X - frame.lower) / width, 0.0, 1.0)
        order = state.ordering.sort(cost, violation)
        if state.phase == INITIAL_PHASE:
            engine = self.make_engine(unit[order[0]])
            generation = 0
        else:
            engine = wake(state.engine)
            # The ranks stand for the costs: the method looks at nothing else.
            engine.tell([(unit[row], float(rank)) for rank, row in enumerate(order)])
            generation = state.generation + 1
        return state.evolve(
            phase=0,
            generation=generation,
            positions=X,
            cost=cost,
            violation=violation,
            engine=rest(engine),
        )


def rest(engine: cmaes.CMA) -> dict[str, Any]:
    """Return everything an engine knows, copied, by name."""
    return {
        name: value.copy() if isinstance(value, np.ndarray) else value
        for name, value in engine.__getstate__().items()
    }


def wake(known: dict[str, Any]) -> cmaes.CMA:
    """Return an engine that knows what `rest` returned; its generator has to be seeded."""
    import cmaes

    engine = cmaes.CMA.__new__(cmaes.CMA)
    engine.__setstate__(
        {name: value.copy() if isinstance(value, np.ndarray) else value for name, value in known.items()}
    )
    return engine
