"""Every optimiser by a short name, for command lines and comparisons."""

from __future__ import annotations

import importlib
from typing import Any

from metaheuristics.algorithms.differential_evolution import DifferentialEvolution
from metaheuristics.algorithms.elite_sparrow_search import EliteSparrowSearch
from metaheuristics.algorithms.levy_sparrow_search import LevySparrowSearch
from metaheuristics.algorithms.particle_swarm import ParticleSwarm
from metaheuristics.algorithms.random_search import RandomSearch
from metaheuristics.algorithms.sparrow_search import SparrowSearch
from metaheuristics.algorithms.tent_sparrow_search import TentSparrowSearch
from metaheuristics.optimizer import Optimizer

UNBIASED: dict[str, Any] = {"debiased": True, "bounds": "reflect"}

registry: dict[str, tuple[type[Optimizer[Any]], dict[str, Any]]] = {
    "pso": (ParticleSwarm, {"population": 50, "inertia": "linear", "cognitive": 2.0, "social": 2.0}),
    "pso-constriction": (ParticleSwarm, {"population": 50}),
    "pso-d": (ParticleSwarm, {"population": 50, "inertia": "trigonometric"}),
    "ssa": (SparrowSearch, {}),
    "ssa-debiased": (SparrowSearch, UNBIASED),
    "issa-a": (EliteSparrowSearch, {}),
    "issa-a-debiased": (EliteSparrowSearch, UNBIASED),
    "issa-b": (LevySparrowSearch, {"population": 30}),
    "issa-b-debiased": (LevySparrowSearch, {"population": 30, **UNBIASED}),
    "t-ssa": (TentSparrowSearch, {"safety": 0.5, "tent": True, "adaptive": False}),
    "adf-ssa": (TentSparrowSearch, {"safety": 0.5, "tent": False, "adaptive": True}),
    "tadf-ssa": (TentSparrowSearch, {"safety": 0.5, "tent": True, "adaptive": True}),
    "tadf-ssa-debiased": (TentSparrowSearch, {"safety": 0.5, "tent": True, "adaptive": True, **UNBIASED}),
    "de": (DifferentialEvolution, {}),
    "random": (RandomSearch, {}),
}
"""Short name -> class and settings; ``class(**settings)`` is the optimiser."""

unavailable: dict[str, str] = {}
"""Short name -> why that optimiser cannot be loaded here."""


def _register_optional(name: str, module: str, attribute: str, settings: dict[str, Any]) -> None:
    """Add an optimiser that needs another package, or the reason why it is missing."""
    try:
        registry[name] = (getattr(importlib.import_module(module), attribute), settings)
    except ImportError as error:
        unavailable[name] = f"{error}; install the package cmaes"


_register_optional("cmaes", "metaheuristics.algorithms.covariance_matrix_adaptation", "CovarianceMatrixAdaptation", {})


def make_optimizer(name: str, **settings: Any) -> Optimizer[Any]:
    """Return the optimiser of that short name, with some settings changed.

    Parameters
    ----------
    name
        A key of `registry`.
    **settings
        Fields of the optimiser that replace the registered ones.

    Raises
    ------
    ValueError
        If there is no such optimiser, it is unavailable, or it has no such setting.
    """
    if name in unavailable:
        raise ValueError(f"The optimiser {name!r} is unavailable: {unavailable[name]}.")
    if name not in registry:
        raise ValueError(f"The optimiser is {name!r}, expected one of {', '.join(registry)}.")
    kind, given = registry[name]
    known = kind.__dataclass_fields__
    for key in settings:
        if key not in known:
            raise ValueError(f"The optimiser {name!r} has no setting {key!r}, it has {', '.join(known)}.")
    return kind(**{**given, **settings})
