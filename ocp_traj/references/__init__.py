"""How far from the best possible is a motion? Timings of fixed paths, lower bounds and certificates.

Names are imported when first used: toppra, cvxpy and CasADi stay out until then.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOMES = {
    "Certificate": "bounds.certify",
    "JerkEstimate": "bounds.jerk_estimate",
    "KinematicBound": "bounds.kinematic_bound",
    "Reference": "reference",
    "ReferenceFinding": "reference",
    "ReferenceRequest": "reference",
    "ReferenceResult": "timing.result",
    "ReferenceSet": "summary",
    "all_references": "registry",
    "certify": "bounds.certify",
    "collect_references": "summary",
    "convex_reference": "timing.convex_reference",
    "jerk_estimate": "bounds.jerk_estimate",
    "jerk_limited_reference": "timing.jerk_limited_reference",
    "LimitCurves": "timing.speed_limits",
    "kinematic_bound": "bounds.kinematic_bound",
    "limit_curves": "timing.speed_limits",
    "reference_columns": "summary",
    "references": "summary",
    "toppra_reference": "timing.toppra_reference",
}

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
