"""How far from the best possible is a motion? Timings of fixed paths, lower bounds and certificates.

Names are imported when first used: toppra, cvxpy and CasADi stay out until then.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOMES = {
    "Certificate": "certificate",
    "JerkEstimate": "jerk_motion",
    "KinematicBound": "shortest_motion",
    "ReferenceResult": "result",
    "ReferenceSet": "summary",
    "certify": "certificate",
    "collect_references": "summary",
    "convex_reference": "convex",
    "jerk_estimate": "jerk_motion",
    "jerk_limited_reference": "jerk_path",
    "LimitCurves": "speed_limits",
    "kinematic_bound": "shortest_motion",
    "limit_curves": "speed_limits",
    "reference_columns": "summary",
    "references": "summary",
    "toppra_reference": "time_optimal",
}

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
