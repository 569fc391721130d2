"""Population methods with one interface; NumPy only.

State a `Problem`, choose an `Optimizer`, call `minimize`, read the `Solution`.
"""

from __future__ import annotations

from metaheuristics.bias import BiasReport, measure_shift_dependence, measure_structural_bias
from metaheuristics.catalogue import make_optimizer, registry, unavailable
from metaheuristics.checkpoint import Checkpoint
from metaheuristics.differential_evolution import DifferentialEvolution
from metaheuristics.evaluation import Evaluation
from metaheuristics.improved_elite import EliteSparrowSearch
from metaheuristics.improved_levy import LevySparrowSearch
from metaheuristics.improved_tent import TentSparrowSearch
from metaheuristics.minimize import minimize
from metaheuristics.optimizer import Optimizer, State
from metaheuristics.ordering import (
    AdaptivePenalty,
    EpsilonLevel,
    FeasibleFirst,
    NonDominated,
    Ordering,
    StaticPenalty,
)
from metaheuristics.particle_swarm import ParticleSwarm
from metaheuristics.problem import Problem
from metaheuristics.random_search import RandomSearch
from metaheuristics.restarts import minimize_restarting
from metaheuristics.solution import History, Solution, Status
from metaheuristics.sparrow_search import SparrowSearch
from metaheuristics.stopping import Limits, Progress

__all__ = [
    "AdaptivePenalty",
    "BiasReport",
    "Checkpoint",
    "DifferentialEvolution",
    "EliteSparrowSearch",
    "EpsilonLevel",
    "Evaluation",
    "FeasibleFirst",
    "History",
    "LevySparrowSearch",
    "Limits",
    "NonDominated",
    "Optimizer",
    "Ordering",
    "ParticleSwarm",
    "Problem",
    "Progress",
    "RandomSearch",
    "Solution",
    "SparrowSearch",
    "State",
    "StaticPenalty",
    "Status",
    "TentSparrowSearch",
    "make_optimizer",
    "measure_shift_dependence",
    "measure_structural_bias",
    "minimize",
    "minimize_restarting",
    "registry",
    "unavailable",
]
