"""Compare optimal-control solvers on robot-arm trajectories: one problem, one budget, one judge."""

from __future__ import annotations

__version__ = "0.1.0"
