"""Population methods with one interface; NumPy only.

State a `Problem`, choose an `Optimizer`, call `minimize`, read the `Solution`.
"""

from __future__ import annotations

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
from metaheuristics.particle_swarm import ParticleSwarm
from metaheuristics.problem import Problem
from metaheuristics.random_search import RandomSearch
from metaheuristics.solution import History, Solution, Status
from metaheuristics.stopping import Limits, Progress

__all__ = [
    "AdaptivePenalty",
    "Checkpoint",
    "EpsilonLevel",
    "Evaluation",
    "FeasibleFirst",
    "History",
    "Limits",
    "NonDominated",
    "Optimizer",
    "Ordering",
    "ParticleSwarm",
    "Problem",
    "Progress",
    "RandomSearch",
    "Solution",
    "State",
    "StaticPenalty",
    "Status",
    "minimize",
]
