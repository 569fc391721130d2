"""Population methods with one interface; NumPy only.

State a `Problem`, choose an `Optimizer`, call `minimize`, read the `Solution`.
"""

from __future__ import annotations

from metaheuristics.algorithms.differential_evolution import DifferentialEvolution
from metaheuristics.algorithms.elite_sparrow_search import EliteSparrowSearch
from metaheuristics.algorithms.levy_sparrow_search import LevySparrowSearch
from metaheuristics.algorithms.particle_swarm import ParticleSwarm
from metaheuristics.algorithms.random_search import RandomSearch
from metaheuristics.algorithms.registry import make_optimizer, registry
from metaheuristics.algorithms.sparrow_search import SparrowSearch
from metaheuristics.algorithms.tent_sparrow_search import TentSparrowSearch
from metaheuristics.checkpoint import Checkpoint
from metaheuristics.evaluation import Evaluation
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
from metaheuristics.problem import Problem
from metaheuristics.restarts import minimize_restarting
from metaheuristics.solution import History, Solution, Status
from metaheuristics.stopping import Limits, Progress
from metaheuristics.test_problems.bias import BiasReport, measure_shift_dependence, measure_structural_bias

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
]
