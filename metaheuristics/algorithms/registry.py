"""Every optimiser by a short name, for command lines and comparisons: a new one is a file, and a line here."""

from __future__ import annotations

import difflib
from typing import Any, NamedTuple

from metaheuristics.algorithms.covariance_matrix_adaptation import CovarianceMatrixAdaptation
from metaheuristics.algorithms.differential_evolution import DifferentialEvolution
from metaheuristics.algorithms.elite_sparrow_search import EliteSparrowSearch
from metaheuristics.algorithms.levy_sparrow_search import LevySparrowSearch
from metaheuristics.algorithms.particle_swarm import ParticleSwarm
from metaheuristics.algorithms.random_search import RandomSearch
from metaheuristics.algorithms.sparrow_search import SparrowSearch
from metaheuristics.algorithms.tent_sparrow_search import TentSparrowSearch
from metaheuristics.optimizer import Optimizer


class Method(NamedTuple):
    """What a short name stands for.

    Parameters
    ----------
    kind, settings
        ``kind(**settings)`` is the optimiser.
    summary
        A few words for lists; empty for a variant that lists leave out.
    """

    kind: type[Optimizer[Any]]
    settings: dict[str, Any]
    summary: str = ""


UNBIASED: dict[str, Any] = {"debiased": True, "bounds": "reflect"}

_SWARM = {"population": 50, "inertia": "linear", "cognitive": 2.0, "social": 2.0}
_LEVY: dict[str, Any] = {"population": 30}
_TENT: dict[str, Any] = {"safety": 0.5, "tent": True, "adaptive": True}

registry: dict[str, Method] = {
    "pso": Method(ParticleSwarm, _SWARM, "particle swarm, inertia 0.9 to 0.4, c1 = c2 = 2"),
    "pso-constriction": Method(ParticleSwarm, {"population": 50}, "particle swarm with constriction values"),
    "pso-d": Method(
        ParticleSwarm,
        {"population": 50, "inertia": "trigonometric"},
        "particle swarm of paper D, trigonometric schedules",
    ),
    "ssa": Method(SparrowSearch, {}, "sparrow search as published"),
    "ssa-debiased": Method(SparrowSearch, UNBIASED, "sparrow search without the pull towards the origin"),
    "issa-a": Method(
        EliteSparrowSearch, {}, "sparrow search of paper A: elite opposition, Gauss-Cauchy, non-dominated sorting"
    ),
    "issa-a-debiased": Method(EliteSparrowSearch, UNBIASED),
    "issa-b": Method(
        LevySparrowSearch, _LEVY, "sparrow search of paper B: 2-D logistic chaos, Levy flights, reverse learning"
    ),
    "issa-b-debiased": Method(LevySparrowSearch, {**_LEVY, **UNBIASED}),
    "t-ssa": Method(
        TentSparrowSearch, {**_TENT, "adaptive": False}, "sparrow search of paper C: Tent chaos"
    ),
    "adf-ssa": Method(
        TentSparrowSearch, {**_TENT, "tent": False}, "sparrow search of paper C: adaptive step factors"
    ),
    "tadf-ssa": Method(
        TentSparrowSearch, _TENT, "sparrow search of paper C: Tent chaos and adaptive step factors"
    ),
    "tadf-ssa-debiased": Method(TentSparrowSearch, {**_TENT, **UNBIASED}),
    "de": Method(DifferentialEvolution, {}, "differential evolution"),
    "random": Method(RandomSearch, {}, "uniform random search"),
    "cmaes": Method(CovarianceMatrixAdaptation, {}, "covariance matrix adaptation"),
}
"""Short name -> method."""


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
        If there is no such optimiser, or it has no such setting.
    """
    if name not in registry:
        raise ValueError(f"The optimiser is {name!r}, expected one of {', '.join(registry)}.")
    method = registry[name]
    known = method.kind.__dataclass_fields__
    for key in settings:
        if key not in known:
            near = difflib.get_close_matches(key, known, n=1)
            hint = f" Did you mean {near[0]!r}?" if near else ""
            raise ValueError(f"The optimiser {name!r} has no setting {key!r}, it has {', '.join(known)}.{hint}")
    return method.kind(**{**method.settings, **settings})
